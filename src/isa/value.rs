//! The value of an argument, once its name is looked up.

use super::{Analog, Bit, Digital, Direction, Source};

/// The value of an argument.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A number.
    Number(f64),
    /// Something an analogue bus can read: a register, PIX, IN, a neighbour.
    Source(Source),
    /// Something a one-bit operation can read.
    Bit(Bit),
    /// One direction, or several (`alldir`).
    Directions(Vec<Direction>),
    /// A name that means nothing on the chip: a buffer of the host.
    Word(String),
}

impl Value {
    /// The analogue register, if it is one.
    #[must_use]
    pub const fn analog(&self) -> Option<Analog> {
        match self {
            Self::Source(Source::Register(register)) => Some(*register),
            _ => None,
        }
    }

    /// The one-bit register, if it is one.
    #[must_use]
    pub const fn digital(&self) -> Option<Digital> {
        match self {
            Self::Bit(Bit::Register(register)) => Some(*register),
            _ => None,
        }
    }

    /// The number, if it is one.
    #[must_use]
    pub const fn number(&self) -> Option<f64> {
        match self {
            Self::Number(value) => Some(*value),
            _ => None,
        }
    }

    /// What it is, for messages.
    #[must_use]
    pub fn describe(&self) -> &'static str {
        match self {
            Self::Number(_) => "a number",
            Self::Source(Source::Register(_)) => "an analogue register",
            Self::Source(Source::Pix | Source::In) => "an analogue source that cannot be written",
            Self::Source(Source::Neighbour(_)) => "a neighbour's cell",
            Self::Bit(Bit::Register(_)) => "a one-bit register",
            Self::Bit(_) => "a one-bit source that cannot be written",
            Self::Directions(all) if all.len() == 1 => "a direction",
            Self::Directions(_) => "several directions",
            Self::Word(_) => "an unknown name",
        }
    }
}
