//! Which part of each picture of a scene is shown.

use std::{fmt, str::FromStr};

use crate::plane::{At, Size};

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crop {
    /// Its height and width.
    pub size: Size,
    /// Its upper left pixel; in the middle of the picture where it is left out.
    pub at: Option<At>,
}

impl FromStr for Crop {
    type Err = String;

    /// Reads `WIDTHxHEIGHT`, in the middle, or `WIDTHxHEIGHT+X+Y`.
    fn from_str(text: &str) -> Result<Self, String> {
        let read = || {
            let (size, at) = match text.split_once('+') {
                Some((size, at)) => (size, Some(at.split_once('+')?)),
                None => (text, None),
            };
            let at = match at {
                Some((x, y)) => Some(At {
                    y: y.parse().ok()?,
                    x: x.parse().ok()?,
                }),
                None => None,
            };
            let size = Size::read(size).filter(|size| size.is_possible())?;
            Some(Self { size, at })
        };
        read().ok_or_else(|| {
            "give WIDTHxHEIGHT for the middle of the picture, or WIDTHxHEIGHT+X+Y from its left and its top, such as 256x256+10+20".to_owned()
        })
    }
}

impl fmt::Display for Crop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.size)?;
        self.at.map_or(Ok(()), |at| write!(f, "+{}+{}", at.x, at.y))
    }
}
