//! In which order words and pixels are worked on. The result is the same to the bit.

use std::{fmt, str::FromStr};

use crate::plane::Size;

/// How the array is walked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Schedule {
    /// One word after the other, each on the whole array, on one thread.
    Plain,
    /// A band of rows through many words while it is in the cache, bands moving up by the
    /// reach of each word; each thread has rows of its own. Two stores of which the second
    /// reads the first are one, and a store that is overwritten before anything can read it
    /// is left out.
    Tiled {
        /// Rows of a band; 0 chooses by the size of a row.
        rows: usize,
    },
}

/// No such schedule.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("unknown schedule `{name}`")]
#[diagnostic(help("known are plain and tiled"))]
pub struct ScheduleError {
    /// What was given.
    pub name: String,
}

impl Schedule {
    /// The best for an array of this size.
    #[must_use]
    pub const fn for_size(size: Size) -> Self {
        if size.pixels() < 64 * 64 {
            Self::Plain
        } else {
            Self::Tiled { rows: 0 }
        }
    }
}

impl FromStr for Schedule {
    type Err = ScheduleError;

    fn from_str(name: &str) -> Result<Self, ScheduleError> {
        match name {
            "plain" => Ok(Self::Plain),
            "tiled" => Ok(Self::Tiled { rows: 0 }),
            _ => Err(ScheduleError { name: name.into() }),
        }
    }
}

impl fmt::Display for Schedule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Plain => "plain",
            Self::Tiled { .. } => "tiled",
        })
    }
}
