//! The registers of a pixel, and the roles that some of them have in the hardware.

use super::{
    connection::{Analog, Digital},
    direction::Direction,
};

/// The registers of a pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Registers {
    /// Names of the analogue ones; [`Analog`] is an index into them.
    pub analog: Vec<String>,
    /// The one that neighbours can reach.
    pub news: Analog,
    /// Names of the one-bit ones; [`Digital`] is an index into them.
    pub digital: Vec<String>,
    /// Other names of one-bit registers.
    pub aliases: Vec<(String, Digital)>,
    /// The one-bit registers that have a role in the hardware.
    pub roles: Roles,
}

/// One-bit registers that the hardware itself reads or writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Roles {
    /// `propagated` is written, and propagation passes, only where this is 1.
    pub mask: Digital,
    /// The one that propagation spreads.
    pub propagated: Digital,
    /// Where these are 1, the neighbour in this direction is read: north, east, south, west.
    pub enable: [Digital; 4],
}

impl Roles {
    /// The register that enables reading from this direction.
    #[must_use]
    pub const fn enables(&self, direction: Direction) -> Digital {
        let [north, east, south, west] = self.enable;
        match direction {
            Direction::North => north,
            Direction::East => east,
            Direction::South => south,
            Direction::West => west,
        }
    }

    /// The register that opens the links of the diffusion network to this neighbour and to the
    /// one opposite: R1 along columns, R2 along rows.
    #[must_use]
    pub const fn links(&self, direction: Direction) -> Digital {
        match direction {
            Direction::North | Direction::South => self.enables(Direction::South),
            Direction::East | Direction::West => self.enables(Direction::West),
        }
    }
}
