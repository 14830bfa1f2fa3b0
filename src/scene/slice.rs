//! A slice of a scene in time.

use std::{fmt, str::FromStr};

use super::{Frame, Outline, Scene, SceneError};
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

impl Moment {
    /// Whether this frame is it, or later.
    fn is_reached(self, frame: &Frame) -> bool {
        match self {
            Self::Frame(number) => frame.index >= number,
            Self::Time(time) => Micros::from_seconds(frame.seconds) >= time,
        }
    }
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

/// A slice of a scene; its first frame is frame 0 at time 0.
#[derive(Debug)]
pub struct Sliced<S> {
    source: S,
    slice: Slice,
    /// Number and time of its first frame in the source.
    first: Option<(u64, f64)>,
    /// Frames of the source so far.
    seen: u64,
}

impl<S: Scene> Sliced<S> {
    /// The slice of `source`.
    pub const fn new(source: S, slice: Slice) -> Self {
        Self {
            source,
            slice,
            first: None,
            seen: 0,
        }
    }

    /// Frame and time from the start of the slice on.
    fn from_start(&mut self, frame: Frame) -> Frame {
        let (index, seconds) = *self.first.get_or_insert((frame.index, frame.seconds));
        let fps = self.source.fps();
        let even = |index: u64| index as f64 / fps;
        let is_even = frame.seconds == even(frame.index) && seconds == even(index);
        let number = frame.index - index;
        Frame {
            index: number,
            // Not a difference, which would be rounded twice.
            seconds: if is_even {
                even(number)
            } else {
                frame.seconds - seconds
            },
            light: frame.light,
        }
    }
}

impl<S: Scene> Scene for Sliced<S> {
    fn outline(&self) -> Outline {
        let source = self.source.outline();
        let frames = match (self.slice.from, self.slice.to) {
            (Moment::Frame(from), Some(Moment::Frame(to))) => {
                source.frames.map(|all| all.min(to).saturating_sub(from))
            }
            (Moment::Frame(from), None) => source.frames.map(|all| all.saturating_sub(from)),
            _ => None,
        };
        Outline { frames, ..source }
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError> {
        while let Some(frame) = self.source.next_frame()? {
            self.seen += 1;
            if self.slice.to.is_some_and(|to| to.is_reached(&frame)) {
                break;
            }
            if self.slice.from.is_reached(&frame) {
                return Ok(Some(self.from_start(frame)));
            }
        }
        if self.first.is_none() {
            return Err(SceneError::EmptySlice {
                slice: self.slice,
                frames: self.seen,
                fps: self.source.fps(),
            });
        }
        Ok(None)
    }
}
