//! The chip's own addresses, and the order in which it reads out set pixels.
//!
//! ```text
//!   image            chip
//!   (0,0)──► x       column ◄──(0,0)
//!     │                          │
//!     ▼ y                        ▼ row
//! ```
//!
//! The scan finds the first column that holds a set pixel, then the first row in it, clears
//! that pixel and goes on: columns outside, rows inside, from the top right. An unused slot
//! reads as (0,0), so a true event at (0,0) cannot be told from the end of the list.

use super::BitPlane;
use crate::plane::{At, Size};

/// A pixel as the chip counts: from the top right corner, columns leftwards.
///
/// This is the one place where the chip's count and image coordinates are converted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Address {
    /// Counted leftwards from the right.
    pub column: usize,
    /// Counted down from the top.
    pub row: usize,
}

impl Address {
    /// Of a pixel of an array of this size.
    #[must_use]
    pub const fn of(at: At, size: Size) -> Self {
        Self {
            column: size.width - 1 - at.x,
            row: at.y,
        }
    }

    /// Where it lies in the image; `None` off the array.
    #[must_use]
    pub const fn at(self, size: Size) -> Option<At> {
        if self.column < size.width && self.row < size.height {
            Some(At {
                y: self.row,
                x: size.width - 1 - self.column,
            })
        } else {
            None
        }
    }
}

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
        for column in 0..size.width {
            let column = if from_left {
                size.width - 1 - column
            } else {
                column
            };
            if !set[size.width - 1 - column] {
                continue;
            }
            for row in 0..size.height {
                let row = if from_bottom {
                    size.height - 1 - row
                } else {
                    row
                };
                let address = Address { column, row };
                let Some(at) = address.at(size).filter(|at| bits.get(at.y, at.x)) else {
                    continue;
                };
                if scan.found.len() < slots as usize {
                    scan.found.push(at);
                    scan.ambiguous |= address == Address { column: 0, row: 0 };
                } else {
                    scan.missed += 1;
                }
            }
        }
        scan
    }
}
