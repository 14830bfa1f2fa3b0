//! Which values, and what holds between them.

use std::{fmt, str::FromStr};

use amacrine::kernel::quantise::Quantiser;

use super::{error::LevelsError, orbits::Symmetry};

/// What the name of levels may be.
pub const KNOWN: &str = "ternary, int-B (2 to 8 bits) or po2-N (1 to 6 exponents); then, each after a colon, `zero` for a sum of 0 and `mirror` or `d4` for a symmetry: ternary:zero:d4";

/// The few values that weights take, and what holds between them.
///
/// ```
/// use amacrine_learn::levels::Levels;
/// assert_eq!("int-5:zero:d4".parse::<Levels>().unwrap().to_string(), "int-5:zero:d4");
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Levels {
    pub(super) quantiser: Quantiser,
    /// The levels that are not negative, from 0 on.
    pub(super) magnitudes: Vec<i32>,
    /// Whether the levels sum to 0 exactly: uniform light gives nothing.
    pub zero_sum: bool,
    /// Which weights are equal.
    pub symmetry: Symmetry,
}

impl Levels {
    /// The levels of a name, `None` where it stands for none.
    #[must_use]
    pub fn parse(name: &str) -> Option<Self> {
        let mut parts = name.split(':');
        let first = parts.next()?;
        let number = |stem: &str, most: u32| -> Option<u32> {
            let digits = first.strip_prefix(stem)?;
            digits.parse().ok().filter(|n| (1..=most).contains(n))
        };
        let magnitudes = if first == "ternary" {
            vec![0, 1]
        } else if let Some(bits) = number("int-", 8) {
            (0..1 << (bits - 1)).collect()
        } else {
            let exponents = number("po2-", 6)?;
            std::iter::once(0)
                .chain((0..exponents).map(|e| 1 << e))
                .collect()
        };
        let mut levels = Self {
            quantiser: first.parse().ok()?,
            magnitudes,
            zero_sum: false,
            symmetry: Symmetry::None,
        };
        for part in parts {
            match part {
                "zero" => levels.zero_sum = true,
                "mirror" => levels.symmetry = Symmetry::Mirror,
                "d4" => levels.symmetry = Symmetry::Square,
                _ => return None,
            }
        }
        Some(levels)
    }

    /// How many different levels there are but for their sign.
    #[must_use]
    pub const fn count(&self) -> usize {
        self.magnitudes.len()
    }

    /// The largest level.
    pub(super) fn largest(&self) -> i32 {
        self.magnitudes.last().copied().unwrap_or(0)
    }
}

impl FromStr for Levels {
    type Err = LevelsError;

    fn from_str(name: &str) -> Result<Self, LevelsError> {
        Self::parse(name).ok_or_else(|| LevelsError::Name {
            name: name.to_owned(),
        })
    }
}

impl fmt::Display for Levels {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.quantiser)?;
        if self.zero_sum {
            f.write_str(":zero")?;
        }
        f.write_str(match self.symmetry {
            Symmetry::None => "",
            Symmetry::Mirror => ":mirror",
            Symmetry::Square => ":d4",
        })
    }
}
