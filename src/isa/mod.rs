//! The chip as data: registers, primitives, macros, costs.
//!
//! A SCAMP-5 pixel can put registers on a summing bus (every store inverts), connect to a
//! neighbour's NEWS cell, set FLAG from a sign, do a few one-bit operations, propagate, and
//! diffuse. Those are the [`Primitive`]s; everything else (`mov`, `add`, `abs`, `XORX`, …)
//! is a macro, text in `isa/<chip>/macros.scamp`.

mod device;
mod figure;
mod load;
pub mod macros;
pub mod operands;
pub mod row;
pub mod signature;
pub mod text;
mod value;

pub use device::{Callable, Device, FigureError, Registers, Roles};
pub use figure::{Domain, Evidence, Figure, Quantity};
pub use load::{LoadError, keys};

pub use macros::Macro;
pub use operands::{Cell, Operands};
pub use row::{Clock, HostKind, HostRow, Kind, PrimitiveRow};
pub use signature::{Operand, Signature};
pub use value::Value;

/// A neighbour, by compass: north is up (row - 1), east is right (column + 1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Direction {
    /// Row above.
    North,
    /// Column to the right.
    East,
    /// Row below.
    South,
    /// Column to the left.
    West,
}

impl Direction {
    /// All four.
    pub const ALL: [Self; 4] = [Self::North, Self::East, Self::South, Self::West];

    /// The other way.
    #[must_use]
    pub const fn opposite(self) -> Self {
        match self {
            Self::North => Self::South,
            Self::East => Self::West,
            Self::South => Self::North,
            Self::West => Self::East,
        }
    }

    /// `(dy, dx)` of the neighbour.
    #[must_use]
    pub const fn step(self) -> (isize, isize) {
        match self {
            Self::North => (-1, 0),
            Self::East => (0, 1),
            Self::South => (1, 0),
            Self::West => (0, -1),
        }
    }
}

/// A storage cell of the analogue kind, an index into the device's list (`A` is 0).
/// NEWS, the cell that neighbours can reach, is one of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Analog(pub u8);

/// A one-bit storage cell, an index into the device's list (`R0` is 0).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Digital(pub u8);

/// What an analogue bus can read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Source {
    /// A register of this pixel (NEWS included).
    Register(Analog),
    /// The photodiode.
    Pix,
    /// The global input (DAC).
    In,
    /// The NEWS cell of the neighbour in this direction (`XN` … `XW`).
    Neighbour(Direction),
}

/// Where an analogue bus can store.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Target {
    /// A register of this pixel (NEWS included).
    Register(Analog),
    /// The NEWS cell of the neighbour in this direction.
    Neighbour(Direction),
}

/// What a one-bit operation can read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Bit {
    /// A one-bit register of this pixel.
    Register(Digital),
    /// The activity flag.
    Flag,
    /// The address decoder's line.
    Select,
    /// SELECT with the extra enable bits of a rectangle.
    Rect,
}

/// One instruction word of the array. There is no `_` arm on this enum anywhere: a new
/// primitive is a row in `primitives.toml`, a variant here, and the places the compiler names.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Primitive {
    /// Nothing for one word.
    Nop,
    /// Reset the photodiode.
    ResetPix,
    /// `each target := -(sum of sources) / (number of targets) + error`, where FLAG is 1.
    Bus {
        /// One to three (more on a generic bus).
        targets: Vec<Target>,
        /// None to four (more on a generic bus), pairwise distinct, distinct from the targets.
        sources: Vec<Source>,
    },
    /// NEWS := square of the sum of the sources.
    Square {
        /// One or two.
        sources: Vec<Source>,
    },
    /// FLAG := (sum of sources) > 0. Not masked by FLAG.
    Where {
        /// One to three.
        sources: Vec<Source>,
    },
    /// FLAG := 1.
    All,
    /// Prepare the diffusion network (reads R1 and R2).
    BlurSet,
    /// `target := -(diffused source) + error`.
    Blur {
        /// Where the result goes.
        target: Analog,
        /// What is diffused.
        source: Analog,
        /// Along rows (needs R2).
        horizontal: bool,
        /// Along columns (needs R1).
        vertical: bool,
    },
    /// Each target := 1.
    Set {
        /// One to four.
        targets: Vec<Digital>,
    },
    /// Each target := 0.
    Clear {
        /// One to four.
        targets: Vec<Digital>,
    },
    /// `target := OR of sources` (`MOV` is the case of one source).
    Or {
        /// Where the result goes.
        target: Digital,
        /// One to four.
        sources: Vec<Bit>,
    },
    /// `target := NOR of sources` (`NOT` is the case of one source).
    Nor {
        /// Where the result goes.
        target: Digital,
        /// One to four.
        sources: Vec<Bit>,
    },
    /// FLAG := OR of sources.
    WhereBit {
        /// One to three.
        sources: Vec<Bit>,
    },
    /// `target := OR over the directions enabled in this pixel (R1 … R4) of the
    /// neighbour's source`; off-array neighbours read `boundary`.
    Dnews {
        /// Where the result goes.
        target: Digital,
        /// What is read at the neighbours.
        source: Bit,
        /// What lies off the array.
        boundary: bool,
    },
    /// Make R12 ready to propagate.
    PropRead,
    /// R12 spreads through enabled neighbours where R0 is 1, for one clock.
    Prop {
        /// What lies off the array.
        boundary: bool,
    },
}
