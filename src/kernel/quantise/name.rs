//! Quantisers by name, as they are written on the command line and in studies.

use std::{fmt, str::FromStr};

use super::{Quantiser, Rounding};

/// A name that is no quantiser's.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("`{name}` is no quantiser{why}")]
#[diagnostic(help(
    "binary, ternary, ternary-0.7, ternary-split, po2-N (1 to 8 exponents), int-B (2 to 12 bits), csd-D (1 or more digits in the whole kernel), qM.N (1 to 24 bits before the point and 0 to 24 after it; :floor or :stochastic may follow)"
))]
pub struct QuantiserNameError {
    /// What was given.
    pub name: String,
    /// What is wrong with it, after a colon; nothing if it is like none.
    pub why: String,
}

impl fmt::Display for Quantiser {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Binary => f.write_str("binary"),
            Self::Ternary => f.write_str("ternary"),
            Self::Ternary07 => f.write_str("ternary-0.7"),
            Self::TernarySplit => f.write_str("ternary-split"),
            Self::PowersOfTwo(n) => write!(f, "po2-{n}"),
            Self::Whole(bits) => write!(f, "int-{bits}"),
            Self::Digits(budget) => write!(f, "csd-{budget}"),
            Self::Fixed(whole, fraction, rounding) => {
                let rounding = match rounding {
                    Rounding::Nearest => "",
                    Rounding::Floor => ":floor",
                    Rounding::Stochastic => ":stochastic",
                };
                write!(f, "q{whole}.{fraction}{rounding}")
            }
        }
    }
}

impl FromStr for Quantiser {
    type Err = QuantiserNameError;

    fn from_str(name: &str) -> Result<Self, QuantiserNameError> {
        let wrong = |why: &str| QuantiserNameError {
            name: name.to_owned(),
            why: if why.is_empty() {
                String::new()
            } else {
                format!(": {why}")
            },
        };
        let number = |text: &str, range: std::ops::RangeInclusive<u32>| {
            let number: u32 = text
                .parse()
                .map_err(|_| wrong(&format!("`{text}` is no whole number")))?;
            if range.contains(&number) {
                return Ok(number);
            }
            Err(wrong(&format!(
                "{number} is not within {} to {}",
                range.start(),
                range.end()
            )))
        };
        match name {
            "binary" => return Ok(Self::Binary),
            "ternary" => return Ok(Self::Ternary),
            "ternary-0.7" => return Ok(Self::Ternary07),
            "ternary-split" => return Ok(Self::TernarySplit),
            _ => {}
        }
        if let Some(n) = name.strip_prefix("po2-") {
            return Ok(Self::PowersOfTwo(number(n, 1..=8)?));
        }
        if let Some(bits) = name.strip_prefix("int-") {
            return Ok(Self::Whole(number(bits, 2..=12)?));
        }
        if let Some(budget) = name.strip_prefix("csd-") {
            return Ok(Self::Digits(number(budget, 1..=100_000)?));
        }
        if let Some(rest) = name.strip_prefix('q') {
            let (format, rounding) = rest.split_once(':').unwrap_or((rest, "nearest"));
            let (whole, fraction) = format
                .split_once('.')
                .ok_or_else(|| wrong("a Q format is written as q3.4"))?;
            let rounding = match rounding {
                "nearest" => Rounding::Nearest,
                "floor" => Rounding::Floor,
                "stochastic" => Rounding::Stochastic,
                other => return Err(wrong(&format!("`{other}` is no rounding"))),
            };
            return Ok(Self::Fixed(
                number(whole, 1..=24)?,
                number(fraction, 0..=24)?,
                rounding,
            ));
        }
        Err(wrong(""))
    }
}
