//! Numbers about the silicon, each with its unit, its source and how well it is known.

use serde::{Deserialize, Serialize};

/// How well a number is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Evidence {
    /// Measured, on the chip or from its published data.
    Measured,
    /// Stated by whoever made the chip or a tool for it.
    Quoted,
    /// Derived from a model that explains what is known.
    Modelled,
    /// Nobody says; a reasonable value.
    Guess,
}

/// A number as it stands in `device.toml`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Quantity {
    /// The number.
    pub value: f64,
    /// Its unit.
    pub unit: String,
    /// Who says so.
    pub source: String,
    /// How well it is known.
    pub evidence: Evidence,
    /// What else is to be said about it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

/// What values make sense.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Domain {
    /// Any finite number.
    Any,
    /// Zero or more.
    NotNegative,
    /// More than zero.
    Positive,
    /// A whole number, at least one.
    Count,
}

impl Domain {
    /// Whether a value makes sense.
    #[must_use]
    pub fn holds(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Self::Any => true,
                Self::NotNegative => value >= 0.0,
                Self::Positive => value > 0.0,
                Self::Count => value >= 1.0 && value.fract() == 0.0 && value <= 1e9,
            }
    }

    /// In words.
    #[must_use]
    pub const fn expected(self) -> &'static str {
        match self {
            Self::Any => "a finite number",
            Self::NotNegative => "a number of zero or more",
            Self::Positive => "a number above zero",
            Self::Count => "a whole number of one or more",
        }
    }
}

/// One list: the variant, its section and key in `device.toml`, unit, domain, meaning.
macro_rules! figures {
    ($($(#[$doc:meta])* $name:ident = $section:literal . $key:literal, $unit:literal, $domain:ident;)*) => {
        /// The numbers that every chip states, under `[figure.<section>]`.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        pub enum Figure {
            $($(#[$doc])* $name,)*
        }

        impl Figure {
            /// All of them, in the order of the list.
            pub const ALL: &'static [Self] = &[$(Self::$name),*];

            /// Section and key in `device.toml`.
            #[must_use]
            pub const fn key(self) -> (&'static str, &'static str) {
                match self { $(Self::$name => ($section, $key),)* }
            }

            /// The unit in which it is stated.
            #[must_use]
            pub const fn unit(self) -> &'static str {
                match self { $(Self::$name => $unit,)* }
            }

            /// What values make sense.
            #[must_use]
            pub const fn domain(self) -> Domain {
                match self { $(Self::$name => Domain::$domain,)* }
            }
        }
    };
}

figures! {
    /// Rows of pixels.
    Height = "array"."height", "px", Count;
    /// Columns of pixels.
    Width = "array"."width", "px", Count;
    /// Side of a pixel.
    Pitch = "array"."pitch", "um", Positive;
    /// Instruction words per second.
    Clock = "clock"."rate", "MHz", Positive;
    /// Host time to start a kernel.
    Launch = "clock"."launch", "us", NotNegative;
    /// Electrical power at the full instruction rate.
    Power = "clock"."power", "W", NotNegative;
    /// Instruction words that all kernels of a program may have together.
    Store = "store"."words", "words", Count;
    /// Bits of an instruction word.
    WordBits = "store"."bits", "bits", Count;
    /// Lowest value of an analogue register.
    Lowest = "range"."low", "LSB", Any;
    /// Highest value of an analogue register.
    Highest = "range"."high", "LSB", Any;
    /// Codes of the converter that reads analogue registers.
    AdcCodes = "converter"."adc_codes", "codes", Count;
    /// Codes of the converter that drives the global input.
    DacCodes = "converter"."dac_codes", "codes", Count;
    /// How far a light level of one (of 255) moves the photodiode.
    LightScale = "light"."scale", "LSB/level", Positive;
    /// The photodiode after a reset.
    LightReset = "light"."reset", "LSB", Any;
    /// Value of every analogue register off the array.
    Edge = "edge"."analogue", "LSB", Any;
    /// FLAG off the array.
    EdgeFlag = "edge"."flag", "bit", NotNegative;
    /// Error of one store; two stores cancel it.
    TransferError = "error"."transfer", "LSB", Any;
    /// An analogue register that nothing was put on.
    ResetLevel = "error"."reset_level", "LSB", Any;
    /// Mean gain of the identity `diva; mov; add`.
    IdentityGain = "error"."identity_gain", "1", Positive;
    /// Mean offset of the identity `diva; mov; add`.
    IdentityOffset = "error"."identity_offset", "LSB", Any;
    /// Spread over the pixels of that gain.
    IdentityGainSpread = "error"."identity_gain_spread", "1", NotNegative;
    /// Spread over the pixels of that offset.
    IdentityOffsetSpread = "error"."identity_offset_spread", "LSB", NotNegative;
    /// Correlation over the pixels of that gain and that offset.
    IdentityCorrelation = "error"."identity_correlation", "1", Any;
    /// Temporal noise of that identity.
    IdentityNoise = "error"."identity_noise", "LSB", NotNegative;
    /// How fast an analogue register decays to its reset level.
    AnalogueDecay = "error"."analogue_decay", "LSB/s", NotNegative;
    /// How long a one-bit register holds without a refresh.
    Retention = "error"."retention", "s", Positive;
    /// How far a bit travels in one propagation, in pixels.
    Travel = "propagation"."travel", "px", Count;
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
    fn domains() {
        assert!(
            Domain::Count.holds(256.0) && !Domain::Count.holds(0.5) && !Domain::Count.holds(0.0)
        );
        assert!(!Domain::Any.holds(f64::NAN) && !Domain::Positive.holds(f64::INFINITY));
    }
}
