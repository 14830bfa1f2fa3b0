//! Terminals of a pixel's buses: what they can read and where they can store.

use super::direction::Direction;

/// An analogue register of a pixel, an index into the device's list (`A` is 0).
/// NEWS, the one that neighbours can reach, is among them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Analog(pub u8);

/// A one-bit register of a pixel, an index into the device's list (`R0` is 0).
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
