//! Quantities as types, so that words are never added to microseconds.

use std::{fmt, iter::Sum, ops, str::FromStr};

/// Time in whole microseconds, as in every event and every file.
#[derive(
    Clone,
    Copy,
    Debug,
    Default,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Hash,
    serde::Serialize,
    serde::Deserialize,
)]
#[serde(transparent)]
pub struct Micros(pub u64);

impl Micros {
    /// The nearest microsecond to `seconds`.
    ///
    /// Times before zero become zero; a sensor starts at its first frame. The times of events
    /// between two frames the float model rounds by
    /// [`Interval::micros`](crate::reference::Interval::micros).
    #[must_use]
    pub fn from_seconds(seconds: f64) -> Self {
        // `as` saturates, which is what is meant.
        Self((seconds * 1e6).round() as u64)
    }

    /// This time in seconds.
    #[must_use]
    pub fn seconds(self) -> f64 {
        self.0 as f64 * 1e-6
    }
}

/// Microseconds in seconds, to the last digit: `-0.133333`.
#[must_use]
pub fn exact_seconds(micros: impl Into<i128>) -> String {
    let micros = micros.into();
    let (sign, micros) = (if micros < 0 { "-" } else { "" }, micros.unsigned_abs());
    format!("{sign}{}.{:06}", micros / 1_000_000, micros % 1_000_000)
}

impl fmt::Display for Micros {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} us", self.0)
    }
}

/// An analogue value in steps of the chip's 8-bit converter; `{:.2}` writes `1.25 LSB`, and no sign
/// where all digits shown are 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lsb(pub f64);

impl Lsb {
    /// To a thousandth, for people: not the last bits of a calculation, and never -0.
    #[must_use]
    pub fn rounded(self) -> f64 {
        (self.0 * 1000.0).round() / 1000.0 + 0.0
    }
}

impl fmt::Display for Lsb {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let digits = f.precision().unwrap_or(2);
        write!(f, "{} LSB", fixed(self.0, digits))
    }
}

/// A text that is no duration.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("`{text}` is not a duration in whole microseconds, such as 100us, 1ms or 0.5s")]
#[diagnostic(help("write a number and one of the units us, ms, s"))]
pub struct DurationError {
    /// What was given.
    pub text: String,
}

impl FromStr for Micros {
    type Err = DurationError;

    /// Reads `100us`, `1ms`, `0.5s`: a decimal number and a unit, exact to the microsecond.
    fn from_str(text: &str) -> Result<Self, DurationError> {
        // The longer units first: `s` ends all of them.
        decimal(text, &[("us", 0), ("µs", 0), ("ms", 3), ("s", 6)])
            .map(Self)
            .ok_or_else(|| DurationError {
                text: text.to_owned(),
            })
    }
}

/// Time in whole picoseconds: what one address word takes on a link.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
#[serde(transparent)]
pub struct Picos(pub u64);

impl Picos {
    /// The units, and the decimals by which each is more than a picosecond; longer names first,
    /// since `s` ends all of them.
    const UNITS: [(&str, usize); 6] = [
        ("ps", 0),
        ("ns", 3),
        ("us", 6),
        ("µs", 6),
        ("ms", 9),
        ("s", 12),
    ];

    /// This time in seconds.
    #[must_use]
    pub fn seconds(self) -> f64 {
        self.0 as f64 * 1e-12
    }
}

impl fmt::Display for Picos {
    /// In the largest of ps, ns, us, ms and s that leaves at least 1, exactly.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let fits = |(_, decimals): &&(&str, usize)| self.0 >= 10_u64.pow(*decimals as u32);
        let units = || Self::UNITS.iter().filter(|(name, _)| *name != "µs");
        let (name, decimals) = units().rfind(fits).unwrap_or(&("ns", 0));
        let one = 10_u64.pow(*decimals as u32);
        let fraction = format!("{:0>decimals$}", self.0 % one);
        match fraction.trim_end_matches('0') {
            "" => write!(f, "{} {name}", self.0 / one),
            fraction => write!(f, "{}.{fraction} {name}", self.0 / one),
        }
    }
}

impl FromStr for Picos {
    type Err = ShortTimeError;

    /// Reads `36ns`, `0.91 us`, `0ns`: a decimal number and a unit, exact to the picosecond.
    fn from_str(text: &str) -> Result<Self, ShortTimeError> {
        decimal(text.trim(), &Self::UNITS)
            .map(Self)
            .ok_or_else(|| ShortTimeError {
                text: text.to_owned(),
            })
    }
}

/// A text that is no short time.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("`{text}` is not a time in whole picoseconds, such as 36ns, 0.91us or 1ms")]
#[diagnostic(help("write a number and one of the units ps, ns, us, ms, s"))]
pub struct ShortTimeError {
    /// What was given.
    pub text: String,
}

/// A decimal number with one of `units`, as a whole number of the smallest.
fn decimal(text: &str, units: &[(&str, usize)]) -> Option<u64> {
    // Two letters look alike: the sign for micro, U+00B5, and the Greek mu, U+03BC.
    let text = &text.replace('\u{3bc}', "\u{b5}");
    let (number, decimals) = units
        .iter()
        .find_map(|(unit, decimals)| Some((text.strip_suffix(unit)?, *decimals)))?;
    let (whole, fraction) = number.trim().split_once('.').unwrap_or((number.trim(), ""));
    let fraction = fraction.trim_end_matches('0');
    let digits = format!("{whole}{fraction:0<decimals$}");
    let plain = digits.bytes().all(|b| b.is_ascii_digit());
    (plain && fraction.len() <= decimals && !whole.is_empty())
        .then(|| digits.parse().ok())
        .flatten()
}

/// How well a number is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
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

impl Evidence {
    /// All, from the best on.
    pub const ALL: [Self; 4] = [Self::Measured, Self::Quoted, Self::Modelled, Self::Guess];

    /// As they are written, in the same order.
    pub const WORDS: [&str; 4] = ["measured", "quoted", "modelled", "guess"];

    /// As it is written.
    #[must_use]
    pub const fn word(self) -> &'static str {
        Self::WORDS[self as usize]
    }

    /// The weakest of some: how well a number is known that is made of others. A guess where it
    /// is made of none.
    #[must_use]
    pub fn weakest(of: impl IntoIterator<Item = Self>) -> Self {
        { of.into_iter() }
            .max_by_key(|evidence| *evidence as usize)
            .unwrap_or(Self::Guess)
    }
}

/// Instruction words: what a program costs on the chip, one clock of the array each.
#[derive(
    Clone,
    Copy,
    Debug,
    Default,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Hash,
    serde::Serialize,
    serde::Deserialize,
)]
#[serde(transparent)]
pub struct Words(pub u64);

impl ops::Add for Words {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }
}

impl ops::AddAssign for Words {
    fn add_assign(&mut self, other: Self) {
        self.0 += other.0;
    }
}

impl ops::Mul<u64> for Words {
    type Output = Self;
    fn mul(self, times: u64) -> Self {
        Self(self.0 * times)
    }
}

impl Sum for Words {
    fn sum<I: Iterator<Item = Self>>(iter: I) -> Self {
        iter.fold(Self(0), ops::Add::add)
    }
}

impl fmt::Display for Words {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&counted(self.0, "word"))
    }
}

/// So many of a thing whose plural ends in s, in words: `1 frame`, `2 frames`.
pub fn counted(number: impl Copy + fmt::Display + PartialEq + From<u8>, thing: &str) -> String {
    let plural = if number == 1.into() { "" } else { "s" };
    format!("{number} {thing}{plural}")
}

/// A number with so many digits behind the point, and no sign where all digits shown are 0.
#[must_use]
pub fn fixed(number: f64, digits: usize) -> String {
    unsigned_zero(format!("{number:.digits$}"))
}

/// The same with its sign: `+1.50`, `-0.01`, `0.00`.
#[must_use]
pub fn signed(number: f64, digits: usize) -> String {
    unsigned_zero(format!("{number:+.digits$}"))
}

/// A rounded number as it was written, without the sign of a zero: what was rounded away is no side.
fn unsigned_zero(text: String) -> String {
    match text.strip_prefix(['-', '+']) {
        Some(digits) if digits.bytes().all(|byte| b"0.".contains(&byte)) => digits.to_owned(),
        _ => text,
    }
}

/// A number to five digits, with no zeros at the end: `0.25`, `1e-6`, `51000`.
#[must_use]
pub fn five_digits(number: f64) -> String {
    let text = format!("{number:.4e}");
    let Some((digits, power)) = text.split_once('e') else {
        return text;
    };
    let few = power
        .parse()
        .is_ok_and(|power: i32| (-5..9).contains(&power));
    match text.parse::<f64>() {
        Ok(0.0) => "0".to_owned(),
        // Shown as short as it can be.
        Ok(rounded) if few => rounded.to_string(),
        _ if digits.contains('.') => {
            let digits = digits.trim_end_matches('0').trim_end_matches('.');
            format!("{digits}e{power}")
        }
        _ => text,
    }
}

/// Frames a second with at most three decimals.
#[must_use]
pub fn frame_rate(fps: f64) -> String {
    let text = format!("{fps:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn five_digits_are_five() {
        let shown = [
            (0.0, "0"),
            (-0.0, "0"),
            (0.25, "0.25"),
            (11.5129, "11.513"),
            (51000.0, "51000"),
            (1e-6, "1e-6"),
            (-3.51e-7, "-3.51e-7"),
            (1e300, "1e300"),
            (f64::INFINITY, "inf"),
        ];
        for (number, text) in shown {
            assert_eq!(five_digits(number), text);
        }
    }

    #[test]
    fn nothing_has_no_sign() {
        let shown = [-0.0, -0.004, -0.006, 1.5].map(|lsb| format!("{:.2}", Lsb(lsb)));
        assert_eq!(shown, ["0.00 LSB", "0.00 LSB", "-0.01 LSB", "1.50 LSB"]);
        let numbers = [-0.0, -0.004, 0.004, -0.006, 1.5, f64::NEG_INFINITY];
        let plain = ["0.00", "0.00", "0.00", "-0.01", "1.50", "-inf"];
        assert_eq!(numbers.map(|number| fixed(number, 2)), plain);
        let both = ["0.00", "0.00", "0.00", "-0.01", "+1.50", "-inf"];
        assert_eq!(numbers.map(|number| signed(number, 2)), both);
        assert_eq!(
            [-0.4, 0.4, -1.4].map(|number| signed(number, 0)),
            ["0", "0", "-1"]
        );
    }

    #[test]
    fn durations_are_read_to_the_microsecond() {
        for (text, micros) in [
            ("1us", 1),
            ("100us", 100),
            ("7µs", 7),
            ("7\u{3bc}s", 7),
            ("1ms", 1_000),
            ("0.25 ms", 250),
            ("10ms", 10_000),
            ("0.5s", 500_000),
            ("1.000001s", 1_000_001),
            ("3.500s", 3_500_000),
            ("0us", 0),
        ] {
            assert_eq!(text.parse(), Ok(Micros(micros)), "{text}");
        }
    }

    #[test]
    fn what_is_no_duration_is_refused() {
        for text in [
            "",
            "1",
            "ms",
            ".5s",
            "1m",
            "1 min",
            "-1ms",
            "0.5us",
            "1.0000001s",
            "1e3us",
            "1,5ms",
            "1.2.3s",
            "99999999999999999999us",
            "nans",
        ] {
            assert!(text.parse::<Micros>().is_err(), "{text}");
        }
    }
    #[test]
    fn short_times_are_read_and_written_to_the_picosecond() {
        for (text, picos, shown) in [
            ("36ns", 36_000, "36 ns"),
            ("35.97 ns", 35_970, "35.97 ns"),
            ("0.91us", 910_000, "910 ns"),
            ("0.91\u{3bc}s", 910_000, "910 ns"),
            ("1.5ms", 1_500_000_000, "1.5 ms"),
            ("2s", 2_000_000_000_000, "2 s"),
            ("7ps", 7, "7 ps"),
            ("0ns", 0, "0 ns"),
        ] {
            assert_eq!(text.parse(), Ok(Picos(picos)), "{text}");
            assert_eq!(Picos(picos).to_string(), shown);
            assert_eq!(shown.parse(), Ok(Picos(picos)), "{shown}");
        }
        for text in ["", "1", "ns", "-1ns", "0.1ps", "1e3ns", "999999999s"] {
            assert!(text.parse::<Picos>().is_err(), "{text}");
        }
    }
}
