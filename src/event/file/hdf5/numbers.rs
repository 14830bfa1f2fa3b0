//! Numbers of a data set, whole or real, and what they mean.

use hdf5_pure::{DType, Dataset};

use super::{
    super::{Fault, fault::Stop},
    open::{unreadable, wrong},
};

/// Numbers as a data set has them.
pub enum Numbers {
    /// Integers and truth values.
    Whole(Vec<i64>),
    /// Integers of 64 bits without a sign.
    Natural(Vec<u64>),
    /// Floating point.
    Real(Vec<f64>),
}

impl Numbers {
    /// Rows `from` and on, `each` numbers of each.
    pub fn read(of: &Dataset, name: &str, rows: (u64, u64), each: u64) -> Result<Self, Stop> {
        let (from, count) = rows;
        let cannot = |e| wrong(format!("has a column `{name}` that cannot be read: {e}"));
        let numbers = match of.dtype().map_err(unreadable)? {
            DType::F32 | DType::F64 => Self::Real(of.read_f64_rows(from, count).map_err(cannot)?),
            DType::U64 => Self::Natural(of.read_u64_rows(from, count).map_err(cannot)?),
            _ => Self::Whole(of.read_i64_rows(from, count).map_err(cannot)?),
        };
        let found = match &numbers {
            Self::Whole(values) => values.len(),
            Self::Natural(values) => values.len(),
            Self::Real(values) => values.len(),
        };
        if found as u64 == count * each {
            return Ok(numbers);
        }
        Err(wrong(format!("has a column `{name}` that ends early")))
    }

    /// A coordinate or a sign: a whole number, of whatever type.
    pub fn whole(&self, at: usize, name: &'static str) -> Result<i128, Fault> {
        match self {
            Self::Whole(values) => Ok(values[at].into()),
            Self::Natural(values) => Ok(values[at].into()),
            Self::Real(values) => {
                let value = values[at];
                // Neither NaN nor infinity has a fraction of 0.
                if value.fract() == 0.0 {
                    return Ok(value as i128);
                }
                let found = format!("{value:?}");
                Err(Fault::NotInteger { name, found })
            }
        }
    }

    /// A time in microseconds: integers are microseconds, reals seconds.
    pub fn micros(&self, at: usize) -> Result<i128, Fault> {
        match self {
            Self::Whole(values) => Ok(values[at].into()),
            Self::Natural(values) => Ok(values[at].into()),
            Self::Real(values) => {
                let seconds = values[at];
                if seconds.is_finite() {
                    return Ok((seconds * 1e6).round() as i128);
                }
                let found = format!("{seconds:?}");
                Err(Fault::NotSeconds { found })
            }
        }
    }

    /// Whether a time is real and has a fraction of a second.
    pub fn is_fraction(&self, at: usize) -> bool {
        match self {
            Self::Whole(_) | Self::Natural(_) => false,
            Self::Real(values) => values[at].fract() != 0.0,
        }
    }
}

/// Whether the numbers are real.
pub fn is_real(of: &Dataset) -> Result<bool, Stop> {
    let kind = of.dtype().map_err(unreadable)?;
    Ok(matches!(kind, DType::F32 | DType::F64))
}
