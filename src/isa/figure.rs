//! Figures: numbers about the silicon, each with its unit, its source and how well it is known.

use serde::Serialize;

use super::{Interval, Role};
use crate::{
    config::{Range, nearest},
    limit::{ARRAY_SIDE, FIGURE, STORE_WORDS},
};

pub use crate::unit::Evidence;

/// A number as it stands in `device.toml`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Quantity {
    /// The number.
    pub value: f64,
    /// Its unit.
    pub unit: String,
    /// The publication or reasoning that it comes from.
    pub source: String,
    /// How well it is known.
    pub evidence: Evidence,
    /// A remark about it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
    /// Between which values it may lie, where that was stated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interval: Option<Interval>,
}

impl Quantity {
    /// The least and the most that it may be: the value itself where no interval was stated.
    #[must_use]
    pub fn ends(&self) -> [f64; 2] {
        { self.interval.as_ref() }.map_or([self.value; 2], Interval::ends)
    }

    /// How well it is known that it lies there: as well as the weaker of value and interval.
    #[must_use]
    pub fn interval_evidence(&self) -> Evidence {
        let ends = self.interval.as_ref().map(|interval| interval.evidence);
        Evidence::weakest([Some(self.evidence), ends].into_iter().flatten())
    }
}

/// The set of values that a figure can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FigureRange {
    /// Any finite number.
    Any,
    /// Zero or more.
    NotNegative,
    /// More than zero.
    Positive,
    /// A whole number, at least one.
    Count,
    /// A side of the array, in pixels.
    Side,
    /// A number of words of the kernel store.
    Words,
    /// A whole number from 2 to 256.
    Codes,
    /// A whole number from 4 to 255.
    Links,
    /// From 0 to below 1.
    Part,
    /// From -1 to 1.
    Correlation,
    /// 1, the only one that is modelled.
    Set,
}

impl FigureRange {
    /// The numbers that make sense, and whether they are whole.
    #[must_use]
    pub fn numbers(self) -> (Range, bool) {
        match self {
            Self::Any => (Range::between(-FIGURE, FIGURE), false),
            Self::NotNegative => (Range::between(0.0, FIGURE), false),
            Self::Positive => (Range::between(1.0 / FIGURE, FIGURE), false),
            Self::Count => (Range::between(1.0, 1e9), true),
            Self::Side => (Range::between(1.0, ARRAY_SIDE as f64), true),
            Self::Words => (Range::between(1.0, STORE_WORDS as f64), true),
            Self::Codes => (Range::between(2.0, 256.0), true),
            Self::Links => (Range::between(4.0, 255.0), true),
            Self::Part => {
                let part = Range::between(0.0, 1.0);
                (
                    Range {
                        below: true,
                        ..part
                    },
                    false,
                )
            }
            Self::Correlation => (Range::between(-1.0, 1.0), false),
            Self::Set => (Range::between(1.0, 1.0), true),
        }
    }

    /// Whether a value makes sense.
    #[must_use]
    pub fn holds(self, value: f64) -> bool {
        let (range, whole) = self.numbers();
        range.holds(value) && !(whole && value.fract() != 0.0)
    }

    /// What a value should have been, in words: with the limits, where it is beyond them.
    #[must_use]
    pub fn instead_of(self, value: f64) -> String {
        let expected = self.expected();
        let limit = match self {
            Self::Any | Self::NotNegative | Self::Positive
                if value.is_finite() && value.abs() > FIGURE =>
            {
                ", at most 1e12 in size"
            }
            Self::Positive if value > 0.0 && value < 1.0 / FIGURE => ", at least 1e-12",
            Self::Count if value.is_finite() && value > 1e9 => ", at most 1e9",
            Self::Side if value.is_finite() && value > ARRAY_SIDE as f64 => ", at most 65536",
            Self::Words if value.is_finite() && value > STORE_WORDS as f64 => ", at most 262144",
            _ => "",
        };
        format!("{expected}{limit}")
    }

    /// The set in words.
    #[must_use]
    pub const fn expected(self) -> &'static str {
        match self {
            Self::Any => "a finite number",
            Self::NotNegative => "a number of zero or more",
            Self::Positive => "a number above zero",
            Self::Count | Self::Side | Self::Words => "a whole number of one or more",
            Self::Codes => "a whole number from 2 to 256",
            Self::Links => "a whole number from 4 to 255",
            Self::Part => "a number from 0 to below 1",
            Self::Correlation => "a number from -1 to 1",
            Self::Set => "1: arrays with another one are not modelled",
        }
    }
}

/// One list: the variant, its section and key in `device.toml`, unit, range, part in errors, meaning.
macro_rules! figures {
    ($($(#[doc = $doc:literal])* $name:ident = $section:literal . $key:literal, $unit:literal, $range:ident, $role:ident;)*) => {
        /// The numbers that every chip states, under `[figure.<section>]`.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        pub enum Figure {
            $($(#[doc = $doc])* $name,)*
        }

        impl Figure {
            /// All of them, in the order of the list.
            pub const ALL: &'static [Self] = &[$(Self::$name),*];

            /// The one that is called `section.key`.
            #[must_use]
            pub fn named(name: &str) -> Option<Self> {
                let (section, key) = name.split_once('.')?;
                Self::ALL.iter().copied().find(|f| f.key() == (section, key))
            }

            /// Section and key in `device.toml`.
            #[must_use]
            pub const fn key(self) -> (&'static str, &'static str) {
                match self { $(Self::$name => ($section, $key),)* }
            }

            /// What it is.
            #[must_use]
            pub const fn what(self) -> &'static str {
                match self { $(Self::$name => concat!($($doc),*),)* }
            }

            /// The unit in which it is stated in `device.toml`.
            #[must_use]
            pub const fn unit(self) -> &'static str {
                match self { $(Self::$name => $unit,)* }
            }

            /// A value of it with its unit, if it has one.
            #[must_use]
            pub fn shown(self, value: f64) -> String {
                match self.unit() {
                    "1" => value.to_string(),
                    unit => format!("{value} {unit}"),
                }
            }

            /// What values make sense.
            #[must_use]
            pub const fn range(self) -> FigureRange {
                match self { $(Self::$name => FigureRange::$range,)* }
            }

            /// What part it has in a chip's errors.
            #[must_use]
            pub const fn role(self) -> Role {
                match self { $(Self::$name => Role::$role,)* }
            }
        }
    };
}

figures! {
    /// Rows of pixels.
    Height = "array"."height", "px", Side, None;
    /// Columns of pixels.
    Width = "array"."width", "px", Side, None;
    /// Side of a pixel.
    Pitch = "array"."pitch", "um", Positive, None;
    /// Instruction words per second.
    Clock = "clock"."rate", "MHz", Positive, None;
    /// Host time to start a kernel.
    Launch = "clock"."launch", "us", NotNegative, None;
    /// Electrical power at the full instruction rate.
    Power = "clock"."power", "W", NotNegative, None;
    /// Instruction words that all kernels of a program may have together.
    Store = "store"."words", "words", Words, None;
    /// Bits of an instruction word.
    WordBits = "store"."bits", "bits", Count, None;
    /// Lowest value of an analogue register.
    Lowest = "range"."low", "LSB", Any, Range;
    /// Highest value of an analogue register.
    Highest = "range"."high", "LSB", Any, Range;
    /// Codes of the converter that reads analogue registers.
    AdcCodes = "converter"."adc_codes", "codes", Codes, None;
    /// Codes of the converter that drives the global input.
    DacCodes = "converter"."dac_codes", "codes", Count, None;
    /// How far a light level of one (of 255) moves the photodiode.
    LightScale = "light"."scale", "LSB/level", Positive, None;
    /// The photodiode after a reset.
    LightReset = "light"."reset", "LSB", Any, None;
    /// Value of every analogue register off the array.
    Edge = "edge"."analogue", "LSB", Any, None;
    /// FLAG off the array.
    EdgeFlag = "edge"."flag", "bit", Set, None;
    /// Transfer error of one store; two stores cancel it.
    TransferError = "error"."transfer", "LSB", Any, Systematic;
    /// Level towards which an analogue register decays; a register that was never written holds 0.
    ResetLevel = "error"."reset_level", "LSB", Any, Decay;
    /// Relative loss of the signal in one store.
    StoreLoss = "error"."loss", "1", Part, Systematic;
    /// Additional error of a store when the bus splits between several targets.
    DivisionError = "error"."division", "LSB", Any, Systematic;
    /// Standard deviation over the cells of the relative gain of a store.
    GainMismatch = "error"."gain_mismatch", "1", Part, Mismatch;
    /// Standard deviation over the cells of the error of a store.
    OffsetMismatch = "error"."offset_mismatch", "LSB", NotNegative, Mismatch;
    /// Correlation over the cells between the two.
    MismatchCorrelation = "error"."mismatch_correlation", "1", Correlation, Mismatch;
    /// Standard deviation over the pixels of a split bus's imbalance.
    DivisionMismatch = "error"."division_mismatch", "1", Part, Mismatch;
    /// Temporal noise of one store, standard deviation.
    StoreNoise = "error"."noise", "LSB", NotNegative, Noise;
    /// How far beyond the ADC's range a register saturates.
    Headroom = "error"."headroom", "LSB", NotNegative, Range;
    /// Decay of an analogue register towards its reset level.
    AnalogueDecay = "error"."analogue_decay", "LSB/s", NotNegative, Decay;
    /// Retention of a one-bit register: how long it holds without being written.
    Retention = "error"."retention", "s", Positive, Decay;
    /// Standard deviation over the cells of a longer retention, relative to it.
    RetentionSpread = "error"."retention_spread", "1", NotNegative, Decay;
    /// One link of the diffusion network against the pixel's own cell: one part in so many of
    /// the difference flows in one `blur`.
    DiffusionParts = "diffusion"."parts", "1", Links, None;
    /// Result of the squarer for a sum of 1 LSB.
    SquareGain = "squarer"."gain", "1/LSB", Any, None;
    /// How far a bit travels in one propagation, in pixels.
    Travel = "propagation"."travel", "px", Count, None;
}

/// The chip has no number of this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("the chip has no number `{name}`; {instead}")]
pub struct UnknownFigure {
    /// What was given.
    pub name: String,
    /// The one that was meant, or all that there are.
    instead: String,
}

impl std::fmt::Display for Figure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (section, key) = self.key();
        write!(f, "{section}.{key}")
    }
}

impl Figure {
    /// Those with this part in a chip's errors.
    pub fn in_role(role: Role) -> impl Iterator<Item = Self> {
        Self::ALL
            .iter()
            .copied()
            .filter(move |figure| figure.role() == role)
    }

    /// Those by which a store errs.
    pub fn of_a_store() -> impl Iterator<Item = Self> {
        Self::ALL
            .iter()
            .copied()
            .filter(|figure| figure.role().is_of_a_store())
    }

    /// The one that is called `section.key`.
    ///
    /// # Errors
    /// When there is none: with the one that was meant, or all.
    pub fn find(name: &str) -> Result<Self, UnknownFigure> {
        Self::named(name).ok_or_else(|| {
            let all: Vec<String> = Self::ALL.iter().map(ToString::to_string).collect();
            let instead = match nearest(name, all.iter().map(String::as_str)) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("it has {}", all.join(", ")),
            };
            let name = name.to_owned();
            UnknownFigure { name, instead }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_unique() {
        let mut keys: Vec<_> = Figure::ALL.iter().map(|f| f.key()).collect();
        keys.sort_unstable();
        keys.dedup();
        assert_eq!(keys.len(), Figure::ALL.len());
    }

    #[test]
    fn ranges() {
        assert!(
            FigureRange::Count.holds(256.0)
                && !FigureRange::Count.holds(0.5)
                && !FigureRange::Count.holds(0.0)
        );
        assert!(FigureRange::Part.holds(0.0) && !FigureRange::Part.holds(1.0));
        assert!(FigureRange::Correlation.holds(-1.0) && !FigureRange::Correlation.holds(1.1));
        assert!(FigureRange::Codes.holds(16.0) && !FigureRange::Codes.holds(512.0));
        assert!(
            FigureRange::Set.holds(1.0)
                && !FigureRange::Set.holds(0.0)
                && !FigureRange::Set.holds(7.0)
        );
        assert!(!FigureRange::Any.holds(f64::NAN) && !FigureRange::Positive.holds(f64::INFINITY));
    }
}
