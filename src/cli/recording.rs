//! How verbs are told what an event file does not say itself.

use std::path::Path;

use crate::{
    event::file::{self, FileError, Loaded, Opening},
    limit::ARRAY_SIDE,
    plane::Size,
};

/// What an event file may leave open.
#[derive(Debug, Default, clap::Args)]
pub struct Recording {
    /// The size of the sensor, where the file does not say it
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<Size>,
}

impl Recording {
    /// Reads a whole file.
    pub fn read(&self, path: &Path) -> Result<Loaded, FileError> {
        let opening = Opening {
            format: None,
            size: self.size,
        };
        file::read_as(path, &opening)
    }
}

/// What to say beside a size that nobody gave; else nothing.
pub const fn guessed(size_known: bool) -> &'static str {
    if size_known {
        ""
    } else {
        " (the file does not say: the smallest that holds all events; give --size WxH)"
    }
}

/// `346x260`, for the command line.
pub fn size(text: &str) -> Result<Size, String> {
    let read = || {
        let (width, height) = text.split_once('x')?;
        Some(Size::new(height.parse().ok()?, width.parse().ok()?))
    };
    read()
        .filter(|size| size.width.min(size.height) > 0 && size.width.max(size.height) <= ARRAY_SIDE)
        .ok_or_else(|| "give width x height in pixels, such as 346x260".into())
}
