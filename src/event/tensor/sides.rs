//! ON and OFF: one less the other, or each on its own.

use std::str::FromStr;

use super::error::{TensorError, named};
use crate::{
    event::{Event, Polarity},
    plane::Size,
};

/// What becomes of the sign of an event.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sides {
    /// ON adds and OFF takes away.
    #[default]
    Signed,
    /// OFF and ON each have a plane of their own, OFF first; both add.
    Split,
}

/// All of them, by name.
const NAMES: [(&str, Sides); 2] = [("signed", Sides::Signed), ("split", Sides::Split)];

impl FromStr for Sides {
    type Err = TensorError;

    fn from_str(text: &str) -> Result<Self, TensorError> {
        named(&NAMES, "polarity", text)
    }
}

impl Sides {
    /// Planes of each kind of cell.
    #[must_use]
    pub const fn count(self) -> usize {
        match self {
            Self::Signed => 1,
            Self::Split => 2,
        }
    }

    /// The plane of an event of this sign, from 0.
    #[must_use]
    pub const fn plane(self, polarity: Polarity) -> usize {
        match self {
            Self::Signed => 0,
            Self::Split => polarity.bit() as usize,
        }
    }

    /// What an event of this sign adds.
    #[must_use]
    pub const fn sign(self, polarity: Polarity) -> i32 {
        match self {
            Self::Signed => polarity.sign(),
            Self::Split => 1,
        }
    }

    /// The place of an event's cell in `[channel][side][y, x]`.
    pub(super) fn place(self, event: &Event, size: Size) -> usize {
        let plane = usize::from(event.channel) * self.count() + self.plane(event.polarity);
        plane * size.pixels() + usize::from(event.y) * size.width + usize::from(event.x)
    }
}
