//! One readout of the chip: the set pixels of a register, in the order of
//! [`event::readout::scan`](crate::event::readout::scan).

use super::BitPlane;
pub use crate::event::readout::scan::Address;
use crate::{
    event::readout::scan::Order,
    plane::{At, Size},
};

/// One readout of set pixels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Scan {
    /// The pixels that found a slot, in the chip's order, in image coordinates.
    pub found: Vec<At>,
    /// Set pixels without a slot.
    pub missed: u64,
    /// Whether the pixel at the chip's (0,0) is among those found: a host that takes (0,0) for
    /// the end of the list loses it.
    pub ambiguous: bool,
}

impl Scan {
    /// Reads `bits` out into `slots`, from the chip's origin, or from the far end of the
    /// columns or rows.
    #[must_use]
    pub fn new(
        bits: &BitPlane,
        size: Size,
        slots: u32,
        from_left: bool,
        from_bottom: bool,
    ) -> Self {
        let mut scan = Self {
            found: Vec::new(),
            missed: 0,
            ambiguous: false,
        };
        let set = bits.columns();
        let order = Order {
            from_left,
            from_bottom,
        };
        for x in order.columns(size).filter(|x| set[*x]) {
            for y in order.rows(size).filter(|y| bits.get(*y, x)) {
                let at = At { y, x };
                if scan.found.len() < slots as usize {
                    scan.found.push(at);
                    scan.ambiguous |= Address::of(at, size) == Address::ORIGIN;
                } else {
                    scan.missed += 1;
                }
            }
        }
        scan
    }
}
