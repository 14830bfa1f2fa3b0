//! The entry of a quantiser in the list: what is said of it, how it works, its parameters.

use std::fmt;

use super::error::QuantiseError;
use crate::config::listed;

/// How a weight is rounded to a multiple.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rounding {
    /// The nearest, halves to even.
    #[default]
    Nearest,
    /// The next below.
    Floor,
    /// Stochastic: one of the two next, with probabilities that make the mean exact.
    Stochastic,
}

listed! {
/// Constraint on the sum of the quantised kernel, which is its response to uniform light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sum = "sum" {
    /// No constraint.
    #[default]
    Free = "free",
    /// 0: uniform light gives nothing.
    Zero = "zero",
    /// As near to the sum of the kernel as the levels allow; a Q format that is not rounded to the
    /// nearest stays as it is rounded.
    Kept = "kept",
}
}

/// The level of each weight, and the scale.
pub type Chosen = (Vec<f64>, f64);

/// What there is to say of a quantiser, and how it works: one or more in each quantiser's file.
#[derive(Debug)]
pub struct Entry {
    /// How its name is written, a capital letter for each number: `po2-N`.
    pub form: &'static str,
    /// What the numbers are, and what else may follow; empty without numbers.
    pub numbers: &'static str,
    /// What numbers a name has.
    pub parameters: Parameters,
    /// The levels, for people.
    pub levels: &'static str,
    /// The scale, for people.
    pub scale: &'static str,
    /// How good it is, for people.
    pub quality: &'static str,
    /// The levels of weights that are not all 0, and the scale; the seed is that of stochastic
    /// rounding.
    pub quantise: fn(Quantiser, &[f64], Sum, u64) -> Result<Chosen, QuantiseError>,
}

impl Entry {
    /// What stands in its names before the numbers.
    pub(super) fn stem(&self) -> &'static str {
        match self.parameters {
            Parameters::None => self.form,
            Parameters::One(..) | Parameters::Fixed => self
                .form
                .split(|c: char| c.is_ascii_uppercase())
                .next()
                .unwrap_or_default(),
        }
    }
}

/// What numbers the name of a quantiser has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parameters {
    /// None.
    None,
    /// A whole number, from the first to the second.
    One(u32, u32),
    /// Bits before and after the point, and a rounding.
    Fixed,
}

/// How a kernel is brought to few values: one of the list, with its numbers.
#[derive(Clone, Copy, Debug)]
pub struct Quantiser {
    pub(super) entry: &'static Entry,
    /// As many as its name has, then 0.
    pub(super) numbers: [u32; 2],
    pub(super) rounding: Rounding,
}

impl Quantiser {
    /// Whether its levels depend on a seed.
    #[must_use]
    pub fn is_random(&self) -> bool {
        self.rounding == Rounding::Stochastic
    }
}

impl PartialEq for Quantiser {
    fn eq(&self, other: &Self) -> bool {
        (self.entry.form, self.numbers, self.rounding)
            == (other.entry.form, other.numbers, other.rounding)
    }
}

impl Eq for Quantiser {}

impl fmt::Display for Quantiser {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [first, second] = self.numbers;
        f.write_str(self.entry.stem())?;
        match self.entry.parameters {
            Parameters::None => Ok(()),
            Parameters::One(..) => write!(f, "{first}"),
            Parameters::Fixed => {
                let rounding = match self.rounding {
                    Rounding::Nearest => "",
                    Rounding::Floor => ":floor",
                    Rounding::Stochastic => ":stochastic",
                };
                write!(f, "{first}.{second}{rounding}")
            }
        }
    }
}

/// A whole number within bounds.
pub(super) fn whole(text: &str, least: u32, most: u32) -> Result<u32, String> {
    let number: u32 = text
        .parse()
        .map_err(|_| format!("`{text}` is no whole number"))?;
    if (least..=most).contains(&number) {
        return Ok(number);
    }
    Err(format!("{number} is not within {least} to {most}"))
}
