//! How verbs are told what an event file does not say itself.

use std::path::Path;

use miette::miette;

use super::budget::{budget, check};
use crate::{
    event::file::{self, Loaded, Opening, Reader},
    limit::ARRAY_SIDE,
    memory::Need,
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
    /// Reads a whole file, of which each event takes `each` bytes in all that is made of it,
    /// where there is room for it beside `held` bytes.
    pub fn read(&self, path: &Path, held: u128, each: u128) -> miette::Result<Loaded> {
        let opening = Opening {
            format: None,
            size: self.size,
        };
        let room = u128::from(Need::new().and("", held).left(budget())) / each;
        let reader = Reader::open(path, &opening)?;
        let (loaded, damage, more) = file::up_to(reader, room as usize);
        if let Some(damage) = damage {
            return Err(damage.into());
        }
        if more {
            let events = loaded.packet.events.len();
            let need = Need::new()
                .and("what is read already", held)
                .and(format!("its first {events} events"), each * events as u128);
            let what = format!(
                "{}, which holds more events than there is room for,",
                path.display()
            );
            check(
                &need,
                &what,
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
