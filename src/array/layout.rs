//! How many registers a pixel has, and which of them have a special part.

use crate::{
    isa::{Analog, Digital, Direction},
    plane::Size,
};

/// The registers of every pixel, and the size of the array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Size of the array.
    pub size: Size,
    /// Number of analogue registers, NEWS included.
    pub analog: u8,
    /// The one that neighbours can reach.
    pub news: Analog,
    /// Number of one-bit registers.
    pub digital: u8,
}

impl Layout {
    /// SCAMP-5's registers: A to F and NEWS, R0 to R12.
    #[must_use]
    pub const fn scamp5(size: Size) -> Self {
        Self {
            size,
            analog: 7,
            news: Analog(6),
            digital: 13,
        }
    }

    /// R0 (`RF`): where it is 0, [`Layout::SPREADS`] cannot be written.
    pub const MASK: Digital = Digital(0);

    /// R12 (`RP`): written only where R0 is 1, and what PROP spreads.
    pub const SPREADS: Digital = Digital(12);

    /// The register whose 1 lets a pixel read from the neighbour in this direction:
    /// R1 (`RS`) south, R2 (`RW`) west, R3 (`RN`) north, R4 (`RE`) east.
    #[must_use]
    pub const fn enable(direction: Direction) -> Digital {
        match direction {
            Direction::South => Digital(1),
            Direction::West => Digital(2),
            Direction::North => Digital(3),
            Direction::East => Digital(4),
        }
    }
}
