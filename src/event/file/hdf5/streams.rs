//! Reader and writer of event files in HDF5.

use std::{
    io::{self, Seek, SeekFrom},
    path::Path,
};

use hdf5_pure::{
    AttrValue, Dataset, Error, File, FileAccessProperties, FileBuilder, MaxExtent, SyncPolicy,
};

use super::{
    super::{
        Fault, Format, Place,
        about::About,
        columns::{self, COLUMNS, OTHERS},
        fault::Stop,
        head::Head,
        origin::Origin,
        source::{BLOCK, Out, Sink, Source},
    },
    event_utils, mvsec,
    numbers::Numbers,
    open::{column, length, open, unreadable, wrong},
    v2e,
};
use crate::{event::Event, save::Spool};

/// Values of a chunk; at 2^16 the C library refuses how hdf5-pure 0.47 writes the number.
const CHUNK: u64 = 1 << 15;

/// Recordings whose first event is before this, in microseconds, are written with their own times
/// and an offset of 0, since readers that add no offset are many (evlib, eventcv). The index then
/// begins at 0, too: the ten minutes before are at most 600 000 equal entries, 4.8 MB as they are
/// read and 46 KB as they are packed.
const FROM_ZERO: u64 = 600_000_000;

/// Opens a file's stream of events, in whichever layout they are.
pub(super) fn source(origin: &Origin) -> Result<Box<dyn Source>, Stop> {
    let file = open(origin)?;
    if file.dataset("events/t").is_err() {
        if file.dataset(event_utils::TIMES).is_ok() {
            return Ok(Box::new(event_utils::source(&file)?));
        }
        if mvsec::fits(&file) {
            return Ok(Box::new(mvsec::source(&file)?));
        }
        if file.dataset(v2e::EVENTS).is_ok() {
            return Ok(Box::new(v2e::source(&file)?));
        }
    }
    Ok(Box::new(dsec(&file)?))
}

/// Opens the stream of a file that is laid out as DSEC.
fn dsec(file: &File) -> Result<Reading, Stop> {
    let mut columns = Vec::new();
    let mut events = None;
    for name in COLUMNS {
        let path = format!("events/{name}");
        if name == "channel" && file.dataset(&path).is_err() {
            continue;
        }
        let column = column(file, &path)?;
        length(&column, name, &mut events)?;
        columns.push(column);
    }
    let offset = match file.dataset("t_offset") {
        Ok(offset) => {
            let offset = Numbers::read(&offset, "t_offset", (0, 1), 1)?.whole(0, "t_offset");
            Some(offset.map_err(|fault| Stop::Fault(Place::Byte(0), fault))?)
        }
        Err(_) => None,
    };
    let comment = match file.root().attrs().map_err(unreadable)?.get("amacrine") {
        Some(AttrValue::String(text) | AttrValue::AsciiString(text)) => Some(text.clone()),
        _ => None,
    };
    let about = columns::about(comment.as_deref(), columns.len())?;
    let index = file.dataset("ms_to_idx").ok().map(Index::new).transpose()?;
    let all = file.group("events").and_then(|group| group.datasets());
    Ok(Reading {
        others: all.map_err(unreadable)?.len() > columns.len(),
        columns,
        index,
        offset: offset.unwrap_or(0),
        about,
        events: events.unwrap_or(0),
        read: 0,
        first: 0,
    })
}

/// A check of `ms_to_idx`, which repeats the times of `t`: the index of the first event at or after
/// each millisecond.
struct Index {
    entries: Dataset,
    length: u64,
    /// The next millisecond, and entries from `from` on.
    next: u64,
    from: u64,
    here: Vec<i64>,
}

impl Index {
    fn new(entries: Dataset) -> Result<Self, Stop> {
        let shape = entries.shape();
        let shape = shape.map_err(|e| wrong(format!("has an index that cannot be read: {e}")))?;
        let [length] = shape[..] else {
            return Err(wrong(format!("has an index of {} dimensions", shape.len())));
        };
        Ok(Self {
            entries,
            length,
            next: 0,
            from: 0,
            here: Vec::new(),
        })
    }

    /// The entry of a millisecond.
    fn at(&mut self, millisecond: u64) -> Result<Option<i64>, Stop> {
        if millisecond >= self.length {
            return Ok(None);
        }
        let inside = |from: u64, here: &[i64]| {
            let at = usize::try_from(millisecond.checked_sub(from)?).ok()?;
            here.get(at).copied()
        };
        if inside(self.from, &self.here).is_none() {
            let count = (self.length - millisecond).min(BLOCK as u64);
            let here = self.entries.read_i64_rows(millisecond, count);
            self.here = here
                .map_err(|e| wrong(format!("has an index `ms_to_idx` that cannot be read: {e}")))?;
            self.from = millisecond;
        }
        Ok(inside(self.from, &self.here))
    }

    /// Checks the entries up to millisecond `to`, for which event `event` is the first.
    fn hold(&mut self, to: u64, event: u64) -> Result<(), Stop> {
        // Of a long silence the end says enough.
        self.next = self.next.max(to.saturating_sub(BLOCK as u64));
        while self.next <= to {
            let Some(stated) = self.at(self.next)? else {
                return Ok(());
            };
            if u64::try_from(stated) != Ok(event) {
                let millisecond = self.next;
                let one = format!(
                    "`ms_to_idx` says that event {stated} is the first after {millisecond} ms"
                );
                let fault = Fault::twice(Format::Hdf5, one, format!("`t` says {event}"));
                return Err(Stop::Fault(Place::Event(event), fault));
            }
            self.next += 1;
        }
        Ok(())
    }

    /// Checks the entries behind the last event, which must say that no event comes; a file of this
    /// program has no such entries, and no fewer than needed.
    fn end(&mut self, events: u64, ours: bool) -> Result<(), Stop> {
        let last = self.length.saturating_sub(1).min(self.next + BLOCK as u64);
        if ours && self.length != self.next {
            let one = format!("`ms_to_idx` has {} milliseconds", self.length);
            let fault = Fault::twice(Format::Hdf5, one, format!("`t` has {}", self.next));
            return Err(Stop::Fault(Place::Event(events), fault));
        }
        if self.next < self.length {
            self.hold(last, events)?;
        }
        Ok(())
    }
}

/// Reads the columns side by side.
pub(super) struct Reading {
    columns: Vec<Dataset>,
    index: Option<Index>,
    /// Whether there are other columns.
    others: bool,
    offset: i128,
    about: About,
    events: u64,
    read: u64,
    first: u64,
}

impl Source for Reading {
    fn about(&self) -> About {
        self.about.clone()
    }

    fn fill(&mut self, events: &mut Vec<Event>) -> Result<bool, Stop> {
        self.first = self.read;
        let count = (self.events - self.read).min(BLOCK as u64);
        if count == 0 {
            let ours = self.about.events.is_some();
            if let Some(index) = &mut self.index {
                index.end(self.events, ours)?;
            }
            return Ok(false);
        }
        let mut columns = Vec::new();
        for (column, name) in self.columns.iter().zip(COLUMNS) {
            columns.push(Numbers::read(column, name, (self.read, count), 1)?);
        }
        for i in 0..count as usize {
            let value = |n: usize| {
                let column: Option<&Numbers> = columns.get(n);
                column.map_or(Ok(0), |column| column.whole(i, COLUMNS[n]))
            };
            let mut since = 0;
            let event = columns::raw(value).and_then(|mut raw| {
                since = raw.t;
                raw.t += self.offset;
                raw.event()
            });
            let event = event.map_err(|fault| Stop::Fault(self.place(i), fault))?;
            if let Some(index) = &mut self.index {
                let millisecond = u64::try_from(since).unwrap_or(0) / 1000;
                if millisecond >= index.next {
                    index.hold(millisecond, self.first + i as u64)?;
                }
            }
            events.push(event);
        }
        self.read += count;
        Ok(true)
    }

    fn note(&self) -> Option<&'static str> {
        self.others.then_some(OTHERS)
    }

    fn place(&self, event: usize) -> Place {
        Place::Event(self.first + event as u64)
    }
}

/// A writer of events.
pub(super) fn sink(head: &Head) -> Writing {
    Writing {
        head: head.clone(),
        open: None,
        offset: None,
        events: 0,
        index: Vec::new(),
        indexed: 0,
        rest: Vec::new(),
    }
}

/// A file being written.
struct Open {
    place: Spool,
    file: File,
}

pub(super) struct Writing {
    head: Head,
    open: Option<Open>,
    offset: Option<u64>,
    events: u64,
    /// Entries of `ms_to_idx` to be written, and those that were.
    index: Vec<u64>,
    indexed: u64,
    /// Events that do not fill a chunk yet.
    rest: Vec<Event>,
}

impl Writing {
    /// The empty file, once the first time is known.
    fn begin(&mut self) -> io::Result<()> {
        let mut builder = FileBuilder::new();
        let about = self.head.about().to_string();
        builder.set_attr("amacrine", AttrValue::String(about));
        let mut group = builder.create_group("events");
        let count = if self.head.channels > 1 { 5 } else { 4 };
        for name in &COLUMNS[..count] {
            let column = group.create_dataset(name);
            match *name {
                "t" => column.with_i64_data(&[]),
                "x" | "y" => column.with_u16_data(&[]),
                _ => column.with_u8_data(&[]),
            }
            .with_shape(&[0])
            .with_maxshape(&[MaxExtent::Unlimited])
            .with_chunks(&[CHUNK])
            .with_deflate(1);
        }
        builder.add_group(group.finish());
        let offset = self.offset.unwrap_or(0);
        builder
            .create_dataset("t_offset")
            .with_i64_data(&[offset as i64])
            .with_shape(&[]);
        builder
            .create_dataset("ms_to_idx")
            .with_u64_data(&[])
            .with_shape(&[0])
            .with_maxshape(&[MaxExtent::Unlimited])
            .with_chunks(&[CHUNK])
            .with_deflate(1);
        let mut place = Spool::new()?;
        let path = place.path().unwrap_or(Path::new("")).to_owned();
        builder.write(&path).map_err(io::Error::other)?;
        let access = FileAccessProperties::new().with_sync_policy(SyncPolicy::OnClose);
        let file = File::open_rw_with_options(&path, access).map_err(io::Error::other)?;
        place.hide();
        self.open = Some(Open { place, file });
        Ok(())
    }

    /// Writes the events that wait.
    fn write(&mut self) -> Result<(), Error> {
        let Some(Open { file, .. }) = &self.open else {
            return Ok(());
        };
        let offset = self.offset.unwrap_or(0);
        let events = &self.rest;
        let column = |name: &str| file.dataset(&format!("events/{name}"));
        let t: Vec<i64> = events.iter().map(|e| (e.t.0 - offset) as i64).collect();
        column("t")?.append(&t)?;
        let x: Vec<u16> = events.iter().map(|e| e.x).collect();
        column("x")?.append(&x)?;
        let y: Vec<u16> = events.iter().map(|e| e.y).collect();
        column("y")?.append(&y)?;
        let p: Vec<u8> = events.iter().map(|e| e.polarity.bit()).collect();
        column("p")?.append(&p)?;
        if self.head.channels > 1 {
            let channel: Vec<u8> = events.iter().map(|e| e.channel).collect();
            column("channel")?.append(&channel)?;
        }
        file.dataset("ms_to_idx")?.append(&self.index)?;
        self.indexed += self.index.len() as u64;
        self.index.clear();
        self.rest.clear();
        Ok(())
    }
}

impl Sink for Writing {
    fn start(&mut self, _: &mut dyn Out) -> io::Result<()> {
        Ok(())
    }

    fn put(&mut self, _: &mut dyn Out, events: &[Event]) -> io::Result<()> {
        let Some(first) = events.first() else {
            return Ok(());
        };
        if self.open.is_none() {
            self.offset = match first.t.0 {
                ..FROM_ZERO => Some(0),
                late => Some(late / 1000 * 1000),
            };
            self.begin()?;
        }
        let offset = self.offset.unwrap_or(0);
        for e in events {
            // Every millisecond up to this event starts with it at the earliest.
            let millisecond = (e.t.0 - offset).div_ceil(1000);
            let next = self.indexed + self.index.len() as u64;
            let last = if (e.t.0 - offset).is_multiple_of(1000) {
                millisecond
            } else {
                millisecond.saturating_sub(1)
            };
            for _ in next..=last {
                self.index.push(self.events);
            }
            self.events += 1;
            self.rest.push(*e);
            if self.rest.len() as u64 == CHUNK || self.index.len() > 1 << 20 {
                self.write().map_err(io::Error::other)?;
            }
        }
        Ok(())
    }

    fn finish(&mut self, out: &mut dyn Out, about: &About) -> io::Result<()> {
        if self.open.is_none() {
            self.begin()?;
        }
        self.write().map_err(io::Error::other)?;
        if let Some(Open { mut place, file }) = self.open.take() {
            let about = AttrValue::String(about.to_string());
            let stated = file.root().set_attr("amacrine", about);
            stated
                .and_then(|()| file.commit())
                .map_err(io::Error::other)?;
            file.close().map_err(io::Error::other)?;
            place.file().seek(SeekFrom::Start(0))?;
            io::copy(place.file(), out)?;
        }
        Ok(())
    }
}
