//! The names of number formats.

use std::{fmt, str::FromStr};

/// A number format by name: `f64` (or `exact`), `f32`, `f16`, `bf16`, `q8.8`, `q4.12-wrap`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// IEEE binary64.
    F64,
    /// IEEE binary32.
    F32,
    /// IEEE binary16.
    F16,
    /// bfloat16.
    Bf16,
    /// Fixed point.
    Fixed(FixedFormat),
}

/// Fixed point, as helps write it.
pub const FIXED: &str = "qM.N or qM.N-wrap (M + N = 8, 16 or 32)";

/// What happens beyond the largest and the smallest number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Overflow {
    /// Stay at the limit.
    #[default]
    Saturate,
    /// Come in again at the other end, as two's complement does.
    Wrap,
}

/// `qM.N`: M bits before the point, sign included, N bits after it; 8, 16 or 32 together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FixedFormat {
    bits: u8,
    fraction: u8,
    overflow: Overflow,
}

impl FixedFormat {
    /// Only for widths that exist, and no more fraction than width.
    pub(super) const fn new(bits: u8, fraction: u8, overflow: Overflow) -> Self {
        Self {
            bits,
            fraction,
            overflow,
        }
    }

    /// Bits in all: 8, 16 or 32.
    #[must_use]
    pub const fn bits(self) -> u8 {
        self.bits
    }

    /// Bits after the point.
    #[must_use]
    pub const fn fraction(self) -> u8 {
        self.fraction
    }

    /// Bits before the point, sign included.
    #[must_use]
    pub const fn integer(self) -> u8 {
        self.bits - self.fraction
    }

    /// The distance from one number to the next.
    #[must_use]
    pub fn step(self) -> f64 {
        1.0 / (1_u64 << self.fraction) as f64
    }

    /// The least number, and the first that is too large.
    fn ends(self) -> [f64; 2] {
        let most = (1_u64 << (self.bits - 1)) as f64 * self.step();
        [-most, most]
    }

    /// What happens beyond the limits.
    #[must_use]
    pub const fn overflow(self) -> Overflow {
        self.overflow
    }
}

/// The floats by name; fixed point is `qM.N`. A second name of a format stands after its own.
const NAMES: &[(&str, Format)] = &[
    ("f64", Format::F64),
    ("exact", Format::F64),
    ("f32", Format::F32),
    ("f16", Format::F16),
    ("bf16", Format::Bf16),
];

/// How the names of the floats are written, with commas between.
pub fn known_floats() -> String {
    let alike = NAMES.chunk_by(|(_, a), (_, b)| a == b);
    let each = alike.map(|names| match names {
        [(own, _), (other, _), ..] => format!("{other} ({own})"),
        [(own, _)] => (*own).to_owned(),
        [] => String::new(),
    });
    each.collect::<Vec<_>>().join(", ")
}

/// A regular expression that the names of all formats match, and nothing else.
pub const FORMAT_PATTERN: &str = concat!(
    "^(f64|exact|f32|f16|bf16|q0*(",
    "0\\.0*8|1\\.0*7|2\\.0*6|3\\.0*5|4\\.0*4|5\\.0*3|6\\.0*2|7\\.0*1|8\\.0*0",
    "|",
    "0\\.0*16|1\\.0*15|2\\.0*14|3\\.0*13|4\\.0*12|5\\.0*11|6\\.0*10|7\\.0*9|8\\.0*8",
    "|9\\.0*7|10\\.0*6|11\\.0*5|12\\.0*4|13\\.0*3|14\\.0*2|15\\.0*1|16\\.0*0",
    "|",
    "0\\.0*32|1\\.0*31|2\\.0*30|3\\.0*29|4\\.0*28|5\\.0*27|6\\.0*26|7\\.0*25",
    "|8\\.0*24|9\\.0*23|10\\.0*22|11\\.0*21|12\\.0*20|13\\.0*19|14\\.0*18|15\\.0*17",
    "|16\\.0*16|17\\.0*15|18\\.0*14|19\\.0*13|20\\.0*12|21\\.0*11|22\\.0*10|23\\.0*9",
    "|24\\.0*8|25\\.0*7|26\\.0*6|27\\.0*5|28\\.0*4|29\\.0*3|30\\.0*2|31\\.0*1",
    "|32\\.0*0",
    ")(-wrap)?)$"
);

impl Format {
    /// The floats, each once.
    pub fn floats() -> impl Iterator<Item = Self> {
        let alike = NAMES.chunk_by(|(_, a), (_, b)| a == b);
        alike.filter_map(|names| names.first().map(|(_, format)| *format))
    }

    /// A format of each kind: the floats, and one of fixed point.
    pub fn examples() -> impl Iterator<Item = Self> {
        std::iter::successors(Some(Self::F64), |format| format.following())
    }

    /// The example behind one of this kind.
    const fn following(self) -> Option<Self> {
        match self {
            Self::F64 => Some(Self::F32),
            Self::F32 => Some(Self::F16),
            Self::F16 => Some(Self::Bf16),
            Self::Bf16 => Some(Self::Fixed(FixedFormat::new(16, 8, Overflow::Saturate))),
            Self::Fixed(_) => None,
        }
    }

    /// The least number and the first that is too large, of a format that saturates or wraps
    /// beyond them; none of one whose numbers become infinite.
    #[must_use]
    pub fn ends(self) -> Option<[f64; 2]> {
        match self {
            Self::F64 | Self::F32 | Self::F16 | Self::Bf16 => None,
            Self::Fixed(fixed) => Some(fixed.ends()),
        }
    }

    /// Bytes of a number, by its bits alone: a run may hold it in more, as halves in an f32.
    #[must_use]
    pub const fn bytes(self) -> u64 {
        match self {
            Self::F64 => 8,
            Self::F32 => 4,
            Self::F16 | Self::Bf16 => 2,
            Self::Fixed(fixed) => fixed.bits() as u64 / 8,
        }
    }

    /// The names of all formats, with commas between: `f64, f32, …`, and [`FIXED`].
    #[must_use]
    pub fn names() -> String {
        let floats = Self::floats().map(|format| format.to_string() + ", ");
        floats.collect::<String>() + FIXED
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fixed(q) => {
                write!(f, "q{}.{}", q.integer(), q.fraction)?;
                match q.overflow {
                    Overflow::Saturate => Ok(()),
                    Overflow::Wrap => f.write_str("-wrap"),
                }
            }
            float => {
                let name = NAMES.iter().find(|(_, format)| format == float);
                f.write_str(name.map_or("", |(name, _)| name))
            }
        }
    }
}

/// No such number format.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
pub enum FormatError {
    /// Not a name.
    #[error("unknown number format `{name}`")]
    #[diagnostic(help(
        "known are {}, and qM.N for fixed point, for instance q8.8, q4.12, q8.24, q1.7; qM.N-wrap wraps instead of saturating",
        known_floats()
    ))]
    Unknown {
        /// What was given.
        name: String,
    },
    /// A fixed-point format that no integer holds.
    #[error("number format `{name}` has {bits} bit{}, not 8, 16 or 32", if *bits == 1 { "" } else { "s" })]
    #[diagnostic(help(
        "M (with the sign) and N in qM.N must be 8, 16 or 32 together, for instance q8.8 or q8.24"
    ))]
    Width {
        /// What was given.
        name: String,
        /// M + N.
        bits: u32,
    },
}

impl FromStr for Format {
    type Err = FormatError;

    fn from_str(name: &str) -> Result<Self, FormatError> {
        let float = NAMES.iter().find(|(known, _)| *known == name);
        float.map_or_else(|| fixed(name), |(_, format)| Ok(*format))
    }
}

fn fixed(name: &str) -> Result<Format, FormatError> {
    let (plain, overflow) = match name.strip_suffix("-wrap") {
        Some(plain) => (plain, Overflow::Wrap),
        None => (name, Overflow::Saturate),
    };
    // `parse` alone would accept a sign.
    let number = |text: &str| -> Option<u8> {
        let digits = !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
        digits.then(|| text.parse().ok()).flatten()
    };
    let parts = plain
        .strip_prefix('q')
        .and_then(|rest| rest.split_once('.'))
        .and_then(|(m, n)| Some((number(m)?, number(n)?)));
    let Some((integer, fraction)) = parts else {
        return Err(FormatError::Unknown { name: name.into() });
    };
    match u32::from(integer) + u32::from(fraction) {
        bits @ (8 | 16 | 32) => Ok(Format::Fixed(FixedFormat {
            bits: bits as u8,
            fraction,
            overflow,
        })),
        bits => Err(FormatError::Width {
            name: name.into(),
            bits,
        }),
    }
}

impl serde::Serialize for Format {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> serde::Deserialize<'de> for Format {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        name.parse().map_err(serde::de::Error::custom)
    }
}
