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
        let order = Order {
            from_left,
            from_bottom,
        };
        // Where the pixels of each column begin in the list.
        let mut of_column = vec![0; size.width];
        for y in 0..size.height {
            for x in bits.ones_of(y) {
                of_column[x] += 1;
            }
        }
        let mut all = 0;
        for x in order.columns(size) {
            all += std::mem::replace(&mut of_column[x], all);
        }
        let slots = slots as usize;
        let origin = At {
            y: 0,
            x: size.width - 1,
        };
        let mut scan = Self {
            found: vec![origin; all.min(slots)],
            missed: all.saturating_sub(slots) as u64,
            ambiguous: false,
        };
        for y in order.rows(size) {
            for x in bits.ones_of(y) {
                let at = At { y, x };
                if let Some(slot) = scan.found.get_mut(of_column[x]) {
                    *slot = at;
                    scan.ambiguous |= Address::of(at, size) == Address::ORIGIN;
                }
                of_column[x] += 1;
            }
        }
        scan
    }
}
