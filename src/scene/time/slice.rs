//! Which frames of a scene are shown.

use std::{fmt, str::FromStr};

use crate::unit::Micros;

/// From one frame on, and before another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slice {
    /// The first frame.
    pub from: Moment,
    /// The first frame that is no longer in it; none where it goes to the end.
    pub to: Option<Moment>,
}

/// A frame, by its number or by the time from which on it is the first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moment {
    /// The number of the frame, from 0.
    Frame(u64),
    /// The time.
    Time(Micros),
}

impl FromStr for Moment {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if let Ok(number) = text.parse() {
            return Ok(Self::Frame(number));
        }
        let time = text.parse().map(Self::Time);
        time.map_err(|_| {
            format!("`{text}` is no time, such as 1.5s or 500ms, and no number of a frame")
        })
    }
}

impl fmt::Display for Moment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Frame(number) => write!(f, "{number}"),
            Self::Time(time) => write!(f, "{}us", time.0),
        }
    }
}

impl FromStr for Slice {
    type Err = String;

    /// Reads `FROM..TO`, each a time, the number of a frame, or left out.
    fn from_str(text: &str) -> Result<Self, String> {
        let (from, to) = text.split_once("..").ok_or(
            "give FROM..TO in times or numbers of frames, such as 1s..2.5s, ..500ms or 0..100",
        )?;
        let end = |text: &str| (!text.is_empty()).then(|| text.parse()).transpose();
        let (from, to) = (end(from)?.unwrap_or(Moment::Frame(0)), end(to)?);
        let is_empty = match (from, to) {
            (Moment::Frame(from), Some(Moment::Frame(to))) => from >= to,
            (Moment::Time(from), Some(Moment::Time(to))) => from >= to,
            _ => false,
        };
        if is_empty {
            return Err("FROM is not before TO".into());
        }
        Ok(Self { from, to })
    }
}

impl fmt::Display for Slice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.from {
            Moment::Frame(0) => {}
            from => write!(f, "{from}")?,
        }
        f.write_str("..")?;
        self.to.map_or(Ok(()), |to| write!(f, "{to}"))
    }
}
