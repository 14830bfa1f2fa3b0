//! How verbs are told what an event file does not say itself.

use std::{fs, path::Path};

use miette::miette;

use super::{
    budget::{budget, check},
    heading,
};
use crate::{
    cli::output::progress::Progress,
    event::file::{self, FileError, Format, Loaded, Opening, Reader},
    limit::ARRAY_SIDE,
    memory::Need,
    plane::Size,
    unit::counted,
};

/// What an event file may leave open.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub struct Recording {
    /// Size of the sensor, if the file does not say it
    #[arg(long, value_name = "WxH", value_parser = size, help_heading = heading::INPUT)]
    pub size: Option<Size>,
    /// Stream of events to read from a file of several cameras
    ///
    /// In an aedat4 file its number; in an hdf5 file of MVSEC 0 for the left camera and 1 for the
    /// right.
    #[arg(long, value_name = "N", help_heading = heading::INPUT)]
    pub stream: Option<i32>,
}

impl Recording {
    /// How a file is opened, whose format is this one where it is given.
    pub const fn opening(&self, format: Option<Format>) -> Opening {
        Opening {
            format,
            size: self.size,
            stream: self.stream,
        }
    }

    /// That of each of two files: a stream is asked of those that have several, and of the first
    /// where neither has.
    pub fn of_each(&self, paths: [&Path; 2]) -> Result<[Self; 2], FileError> {
        let mut each = [*self, *self];
        if self.stream.is_none() {
            return Ok(each);
        }
        for (own, path) in each.iter_mut().zip(paths) {
            // A pipe is read once.
            if fs::metadata(path).is_ok_and(|it| it.is_file())
                && Reader::open(path, &own.without_stream().opening(None))?
                    .streams()
                    .len()
                    < 2
            {
                *own = own.without_stream();
            }
        }
        if each.iter().all(|own| own.stream.is_none()) {
            each[0] = *self;
        }
        Ok(each)
    }

    const fn without_stream(self) -> Self {
        Self {
            stream: None,
            ..self
        }
    }

    /// Reads a whole file, of which each event takes `each` bytes in all that is made of it,
    /// where there is room for it beside `held` bytes.
    pub fn read(&self, path: &Path, held: u128, each: u128) -> miette::Result<Loaded> {
        let room = u128::from(Need::new().and("", held).left(budget())) / each;
        let mut reader = Reader::open(path, &self.opening(None))?;
        let _progress = Progress::spinner(format!("reading {}", path.display()));
        let (loaded, damage, more) = file::up_to(&mut reader, room as usize);
        if let Some(damage) = damage {
            return Err(damage.into());
        }
        if more {
            let events = loaded.packet.events.len() as u64 + reader.count()?;
            let mut need = Need::new().and(counted(events, "event"), each * u128::from(events));
            if held > 0 {
                need = need.and("what is read already", held);
            }
            check(
                &need,
                &path.display().to_string(),
                "take a part of it: amacrine convert A B --slice FROM..TO",
            )?;
        }
        Ok(loaded)
    }
}

/// A file without events that says no size.
pub fn sizeless(path: &Path) -> miette::Report {
    miette!(
        help = "give --size WxH",
        "{}: no events, and it does not say how large its sensor is",
        path.display()
    )
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
    Size::read(text)
        .filter(|size| size.width.min(size.height) > 0 && size.width.max(size.height) <= ARRAY_SIDE)
        .ok_or_else(|| "give width x height in pixels, such as 346x260".into())
}
