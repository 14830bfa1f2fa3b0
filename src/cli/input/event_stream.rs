//! The events of a file that `convert` reads: as they come, or all of them, sorted by time.

use std::{
    mem,
    ops::{Deref, DerefMut},
    path::Path,
};

use crate::{
    cli::arguments::budget::{budget, check},
    event::{
        Event,
        file::{FileError, Opening, Reader},
    },
    memory::Need,
    unit::counted,
};

/// Bytes of an event that is sorted: as it was read, and what the sort takes, a half of it.
const EACH: u128 = 2 * size_of::<Event>() as u128;

/// A reader, and what it gave where that is sorted.
pub struct Events {
    reader: Reader,
    /// Those that were not taken yet.
    sorted: Option<Vec<Event>>,
    /// What ended them.
    damage: Option<FileError>,
    /// How many came earlier than the one before them, where they are sorted.
    pub out_of_order: u64,
}

impl Deref for Events {
    type Target = Reader;

    fn deref(&self) -> &Reader {
        &self.reader
    }
}

impl DerefMut for Events {
    fn deref_mut(&mut self) -> &mut Reader {
        &mut self.reader
    }
}

impl Events {
    /// As they come, in constant memory; they must be in order.
    pub fn streamed(path: &Path, how: &Opening) -> Result<Self, FileError> {
        let reader = Reader::open(path, how)?;
        Ok(Self {
            reader,
            sorted: None,
            damage: None,
            out_of_order: 0,
        })
    }

    /// Reads them to the end, or to damage, and sorts them by time; those of one time stay as they
    /// were.
    ///
    /// # Errors
    /// When there is no room for all of them at once.
    pub fn sort(&mut self, path: &Path) -> miette::Result<()> {
        let room = u128::from(Need::new().left(budget())) / EACH;
        self.reader.in_any_order();
        let (mut all, mut block) = (Vec::new(), Vec::new());
        loop {
            match self.reader.next_block(&mut block) {
                Ok(true) => all.append(&mut block),
                Ok(false) => break,
                Err(damage) => {
                    self.damage = Some(damage);
                    break;
                }
            }
            if all.len() as u128 > room {
                let events = all.len() as u64 + self.reader.count()?;
                let sorted = format!("{}, sorted", counted(events, "event"));
                check(
                    &Need::new().and(sorted, EACH * u128::from(events)),
                    &format!("--sort of {}", path.display()),
                    "sort where there is more memory",
                )?;
            }
        }
        let back = all.windows(2).filter(|two| two[1].t < two[0].t);
        self.out_of_order = back.count() as u64;
        all.sort_by_key(|event| event.t);
        self.sorted = Some(all);
        Ok(())
    }

    /// As [`Reader::next_block`].
    pub fn next_block(&mut self, events: &mut Vec<Event>) -> Result<bool, FileError> {
        let Some(all) = &mut self.sorted else {
            return self.reader.next_block(events);
        };
        *events = mem::take(all);
        match self.damage.take_if(|_| events.is_empty()) {
            Some(damage) => Err(damage),
            None => Ok(!events.is_empty()),
        }
    }
}
