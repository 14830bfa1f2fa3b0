//! Events as rows of x, y, t and p, of one camera or of several.

use hdf5_pure::{Dataset, File};

use super::{
    super::{
        Fault, Format, Place,
        about::About,
        fault::Stop,
        gate::Raw,
        source::{BLOCK, Source},
    },
    numbers::{Numbers, is_real},
    open::{column, unreadable, wrong},
};
use crate::{event::Event, plane::Size};

/// Four columns that are x, y, t and p.
pub const XYTP: [usize; 4] = [0, 1, 2, 3];

/// Where the rows are.
pub enum Table {
    /// x, y, t and p, each a data set.
    Columns(Vec<(Dataset, &'static str)>),
    /// One data set of four columns, and which of them x, y, t and p are.
    Rows(Dataset, [usize; 4]),
}

impl Table {
    /// One data set of four columns, and how many events it has.
    pub fn rows(file: &File, path: &str, order: [usize; 4]) -> Result<(Self, u64), Stop> {
        let rows = column(file, path)?;
        let shape = rows.shape().map_err(unreadable)?;
        let [events, 4] = shape[..] else {
            let shape: Vec<_> = shape.iter().map(u64::to_string).collect();
            let why = format!(
                "has `{path}` of the shape ({}), not (N, 4)",
                shape.join(", ")
            );
            return Err(wrong(why));
        };
        Ok((Self::Rows(rows, order), events))
    }

    /// Whether its times are real numbers.
    pub fn has_real_times(&self) -> Result<bool, Stop> {
        match self {
            Self::Columns(columns) => is_real(&columns[2].0),
            Self::Rows(rows, _) => is_real(rows),
        }
    }
}

/// A camera.
pub struct Camera {
    /// Its number, by which it is chosen.
    pub number: i32,
    /// Where its events are.
    pub path: &'static str,
    /// Its events.
    pub table: Table,
    /// How many there are.
    pub events: u64,
    /// How many the file says that there are, and where it says so.
    pub stated: Option<(i64, &'static str)>,
    /// The size of its sensor, where the file says it.
    pub size: Option<Size>,
    /// Records of other things: images, motion.
    pub others: u64,
}

impl Camera {
    /// Counts what is no event; images also say the size.
    pub fn leave_out(&mut self, file: &File, path: &str) -> Result<(), Stop> {
        let Ok(other) = file.dataset(path) else {
            return Ok(());
        };
        let shape = other.shape().map_err(unreadable)?;
        self.others += shape.first().copied().unwrap_or(0);
        if let [_, height, width] | [_, height, width, _] = shape[..] {
            self.size = Some(Size::new(height as usize, width as usize));
        }
        Ok(())
    }
}

/// Four numbers of each event of a block.
struct Block {
    columns: Vec<Numbers>,
    /// Which of the four x, y, t and p are.
    order: [usize; 4],
}

impl Block {
    /// Where number `column` of an event is.
    const fn at(&self, event: usize, column: usize) -> (usize, usize) {
        if self.columns.len() == 1 {
            (0, 4 * event + self.order[column])
        } else {
            (column, event)
        }
    }

    /// The fields of an event.
    fn raw(&self, event: usize) -> Result<Raw, Fault> {
        let whole = |column, name| {
            let (list, at) = self.at(event, column);
            self.columns[list].whole(at, name)
        };
        let (list, at) = self.at(event, 2);
        Ok(Raw {
            t: self.columns[list].micros(at)?,
            x: whole(0, "x")?,
            y: whole(1, "y")?,
            p: whole(3, "p")?,
            channel: 0,
        })
    }

    /// Whether the time of an event has a fraction of a second.
    fn is_fraction(&self, event: usize) -> bool {
        let (list, at) = self.at(event, 2);
        self.columns[list].is_fraction(at)
    }
}

impl Table {
    fn read(&self, path: &str, from: u64, count: u64) -> Result<Block, Stop> {
        match self {
            Self::Columns(columns) => {
                let mut all = Vec::with_capacity(4);
                for (column, name) in columns {
                    all.push(Numbers::read(column, name, (from, count), 1)?);
                }
                Ok(Block {
                    columns: all,
                    order: XYTP,
                })
            }
            Self::Rows(rows, order) => Ok(Block {
                columns: vec![Numbers::read(rows, path, (from, count), 4)?],
                order: *order,
            }),
        }
    }
}

/// Reads the events of one camera.
pub struct Reading {
    cameras: Vec<Camera>,
    /// Which of them.
    chosen: usize,
    /// Whether it is clear which: there is one, or it was asked for.
    is_clear: bool,
    read: u64,
    first: u64,
    /// Whether times are in seconds, and all that were read are whole ones.
    whole_seconds: bool,
}

impl Reading {
    /// Of these cameras, at least one.
    pub fn new(cameras: Vec<Camera>, seconds: bool) -> Self {
        Self {
            is_clear: cameras.len() == 1,
            cameras,
            chosen: 0,
            read: 0,
            first: 0,
            whole_seconds: seconds,
        }
    }

    /// A stream as its refusal names it.
    fn name(&self, camera: usize) -> String {
        let Camera { number, path, .. } = &self.cameras[camera];
        format!("{number} ({path})")
    }

    /// Checks how many events there are against what the file says.
    fn complete(&self) -> Result<(), Stop> {
        let camera = &self.cameras[self.chosen];
        let Some((stated, key)) = camera.stated else {
            return Ok(());
        };
        if u64::try_from(stated) == Ok(camera.events) {
            return Ok(());
        }
        let one = format!("`{key}` says {stated} events");
        let other = format!("`{}` has {}", camera.path, camera.events);
        let fault = Fault::twice(Format::Hdf5, one, other);
        Err(Stop::Fault(Place::Event(camera.events), fault))
    }
}

impl Source for Reading {
    fn about(&self) -> About {
        About {
            size: self.cameras[self.chosen].size.filter(|_| self.is_clear),
            channels: Some(1),
            ..About::NOTHING
        }
    }

    fn streams(&self) -> Vec<i32> {
        self.cameras.iter().map(|camera| camera.number).collect()
    }

    fn choose(&mut self, stream: i32) {
        let mut numbers = self.cameras.iter().map(|camera| camera.number);
        if let Some(chosen) = numbers.position(|number| number == stream) {
            (self.chosen, self.is_clear) = (chosen, true);
        }
    }

    fn fill(&mut self, events: &mut Vec<Event>) -> Result<bool, Stop> {
        if !self.is_clear {
            let fault = Fault::Streams {
                format: Format::Hdf5,
                one: self.name(0),
                other: self.name(1),
            };
            return Err(Stop::Fault(Place::Event(0), fault));
        }
        self.first = self.read;
        let camera = &self.cameras[self.chosen];
        let count = (camera.events - self.read).min(BLOCK as u64);
        if count == 0 {
            self.complete()?;
            return Ok(false);
        }
        let block = camera.table.read(camera.path, self.read, count)?;
        for i in 0..count as usize {
            let event = block.raw(i).and_then(Raw::event);
            events.push(event.map_err(|fault| Stop::Fault(self.place(i), fault))?);
            self.whole_seconds &= !block.is_fraction(i);
        }
        self.read += count;
        Ok(true)
    }

    fn place(&self, event: usize) -> Place {
        Place::Event(self.first + event as u64)
    }

    fn skipped(&self) -> u64 {
        self.cameras[self.chosen].others
    }

    fn note(&self) -> Option<&'static str> {
        (self.whole_seconds && self.read > 1).then_some(
            "all times are whole seconds, as floating point is read; microseconds are to be stored as integers",
        )
    }
}
