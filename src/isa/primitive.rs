//! Primitives: what one instruction word does.

use super::connection::{Analog, Bit, Digital, Source, Target};

/// One instruction word of the array. There is no `_` arm on this enum anywhere, nor
/// a pattern that one variant alone passes: a new primitive is a row in `primitives.toml`, a
/// variant here, and the places the compiler names.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Primitive {
    /// Nothing for one word.
    Nop,
    /// Reset the photodiode.
    ResetPix,
    /// `each target := -(sum of sources) / (number of targets) + error`, where FLAG is 1.
    Bus {
        /// One to three destinations (more on a generic bus).
        targets: Vec<Target>,
        /// Up to four sources (more on a generic bus), pairwise distinct, distinct from the
        /// targets.
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
        /// Destination.
        target: Analog,
        /// Source, which is diffused.
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
        /// Destination.
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
        /// Source, which is read at the neighbours.
        source: Bit,
        /// Value of the source off the array.
        boundary: bool,
    },
    /// Make R12 ready to propagate.
    PropRead,
    /// R12 spreads through enabled neighbours where R0 is 1, for one clock.
    Prop {
        /// Value of R12 off the array.
        boundary: bool,
    },
}

/// What others take a word apart into.
enum Parts<'a> {
    /// A bus word's targets and sources.
    Bus(&'a [Target], &'a [Source]),
    /// What a word that propagates reads off the array.
    Propagates(bool),
    /// No other word is taken apart.
    Whole,
}

impl Primitive {
    fn parts(&self) -> Parts<'_> {
        match self {
            Self::Bus { targets, sources } => Parts::Bus(targets, sources),
            Self::Prop { boundary } => Parts::Propagates(*boundary),
            Self::Nop
            | Self::ResetPix
            | Self::Square { .. }
            | Self::Where { .. }
            | Self::All
            | Self::BlurSet
            | Self::Blur { .. }
            | Self::Set { .. }
            | Self::Clear { .. }
            | Self::Or { .. }
            | Self::Nor { .. }
            | Self::WhereBit { .. }
            | Self::Dnews { .. }
            | Self::PropRead => Parts::Whole,
        }
    }

    /// The targets and the sources of a bus word; none of any other.
    #[must_use]
    pub fn as_bus(&self) -> Option<(&[Target], &[Source])> {
        match self.parts() {
            Parts::Bus(targets, sources) => Some((targets, sources)),
            Parts::Propagates(_) | Parts::Whole => None,
        }
    }

    /// What a word that propagates reads off the array; none of any other word.
    #[must_use]
    pub fn propagates_from(&self) -> Option<bool> {
        match self.parts() {
            Parts::Propagates(boundary) => Some(boundary),
            Parts::Bus(..) | Parts::Whole => None,
        }
    }
}
