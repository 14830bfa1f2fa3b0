//! numpy's `.npz`: the arrays `t`, `x`, `y`, `p` (and `channel`), one number an event each:
//! `numpy.load(path)['t']`.
//!
//! t is `<i8`, x and y `<u2`, p and channel `|u1`; stored as they are. Size, channels, time
//! watched and drops travel as the comment of the archive. Read stored or deflated, with integers of any width; also an archive of one structured array. While a
//! file is written its columns wait in temporary files. Layout:
//! <https://numpy.org/doc/stable/reference/generated/numpy.savez.html>.

use std::{
    fs::File,
    io::{self, BufReader, BufWriter, Read, Seek, SeekFrom, Write},
};

use flate2::read::DeflateDecoder;
use zip::{CompressionMethod, ZipArchive, ZipWriter, write::SimpleFileOptions};

use super::{
    Format, Place,
    about::About,
    chunks::Chunks,
    fault::Stop,
    gate::Raw,
    npy::{self, Column},
    reader::Origin,
    source::{BLOCK, Out, Sink, Source},
    writer::Head,
};
use crate::event::Event;

/// The columns as they are written.
const COLUMNS: [(&str, &str); 5] = [
    ("t", "'<i8'"),
    ("x", "'<u2'"),
    ("y", "'<u2'"),
    ("p", "'|u1'"),
    ("channel", "'|u1'"),
];

fn wrong(why: impl Into<String>) -> Stop {
    Stop::layout(Format::Npz, 0, why)
}

/// Reads the events.
pub(super) fn source(origin: &Origin) -> Result<Box<dyn Source>, Stop> {
    let input = BufReader::new(origin.open()?);
    let mut archive =
        ZipArchive::new(input).map_err(|e| wrong(format!("cannot be read as an archive: {e}")))?;
    let names: Result<Vec<String>, _> = archive
        .file_names()
        .map(|name| name.map(std::borrow::Cow::into_owned))
        .collect();
    let names = names.map_err(|e| wrong(format!("has a name that is no text: {e}")))?;
    let has = |name: &str| names.iter().any(|n| n.strip_suffix(".npy") == Some(name));
    if let [name] = &names[..] {
        return Ok(Box::new(npy::source(member(origin, &mut archive, name)?)?));
    }
    for name in &names {
        let known = COLUMNS
            .iter()
            .any(|(column, _)| name.strip_suffix(".npy") == Some(column));
        if !known {
            return Err(wrong(format!(
                "holds `{name}`; it should hold the arrays t, x, y, p, and perhaps channel"
            )));
        }
    }
    let mut columns = Vec::new();
    for (name, _) in COLUMNS {
        if has(name) {
            let chunks = member(origin, &mut archive, &format!("{name}.npy"))?;
            columns.push((name, npy::column(chunks)?));
        } else if name != "channel" {
            return Err(wrong(format!("has no array `{name}`")));
        }
    }
    let events = columns.first().map_or(0, |(_, column)| column.events);
    for (name, column) in &columns {
        if column.events != events {
            return Err(wrong(format!(
                "has {events} times and {} values of {name}",
                column.events
            )));
        }
    }
    let comment = String::from_utf8_lossy(archive.comment()).into_owned();
    let about = About::parse(&comment).map_err(|fault| Stop::Fault(Place::Byte(0), fault))?;
    Ok(Box::new(Reading {
        about: about.unwrap_or_default(),
        columns: columns.into_iter().map(|(_, column)| column).collect(),
        left: events,
        first: 0,
        read: 0,
    }))
}

/// One array of the archive, with a hand of its own on the file.
fn member(
    origin: &Origin,
    archive: &mut ZipArchive<impl Read + Seek>,
    name: &str,
) -> Result<Chunks, Stop> {
    let bad = |e| wrong(format!("has an array `{name}` that cannot be read: {e}"));
    let file = archive.by_name_raw(name.as_bytes()).map_err(bad)?;
    let (start, size) = (file.data_start(), file.compressed_size());
    let (method, crc, encrypted) = (file.compression(), file.crc32(), file.encrypted());
    let start = start.ok_or_else(|| wrong(format!("does not say where `{name}` is")))?;
    drop(file);
    if encrypted {
        return Err(wrong(format!("is encrypted, `{name}` too")));
    }
    let mut input = origin.open()?;
    input.seek(SeekFrom::Start(start))?;
    let input = BufReader::with_capacity(1 << 16, input.take(size));
    let bytes: Box<dyn Read + Send> = match method {
        CompressionMethod::Stored => Box::new(input),
        CompressionMethod::Deflated => Box::new(DeflateDecoder::new(input)),
        other => {
            let why = format!("has `{name}` compressed by {other}; stored and deflated are read");
            return Err(wrong(why));
        }
    };
    Ok(Chunks::new(Box::new(Checked {
        bytes,
        sum: flate2::Crc::new(),
        crc,
    })))
}

/// Bytes whose sum is checked at their end.
struct Checked {
    bytes: Box<dyn Read + Send>,
    sum: flate2::Crc,
    crc: u32,
}

impl Read for Checked {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.bytes.read(buffer)?;
        self.sum.update(&buffer[..read]);
        if read == 0 && !buffer.is_empty() && self.sum.sum() != self.crc {
            let why = "an array is damaged: its check sum is another";
            return Err(io::Error::new(io::ErrorKind::InvalidData, why));
        }
        Ok(read)
    }
}

/// The columns side by side.
struct Reading {
    about: About,
    /// t, x, y, p, and perhaps the channel.
    columns: Vec<Column>,
    left: u64,
    /// Number of the first event of the last block, and of the next.
    first: u64,
    read: u64,
}

impl Source for Reading {
    fn about(&self) -> About {
        self.about
    }

    fn fill(&mut self, events: &mut Vec<Event>) -> Result<bool, Stop> {
        self.first = self.read;
        if self.left == 0 {
            for column in &mut self.columns {
                column.end()?;
            }
            return Ok(false);
        }
        let count = usize::try_from(self.left).unwrap_or(BLOCK).min(BLOCK);
        for _ in 0..count {
            let mut values = [0; 5];
            for (value, column) in values.iter_mut().zip(&mut self.columns) {
                *value = column.next()?;
            }
            let [t, x, y, p, channel] = values;
            let raw = Raw {
                t,
                x,
                y,
                p,
                channel,
            };
            let event = raw
                .event()
                .map_err(|fault| Stop::Fault(self.place(events.len()), fault))?;
            events.push(event);
            self.read += 1;
            self.left -= 1;
        }
        Ok(true)
    }

    fn place(&self, event: usize) -> Place {
        Place::Event(self.first + event as u64)
    }
}

/// Takes all that it is given, and remembers the first error: a `ZipWriter` that hears of one
/// panics, or prints.
struct Steady<'a> {
    out: &'a mut dyn Out,
    lost: Option<io::Error>,
    at: u64,
    end: u64,
}

impl<'a> Steady<'a> {
    fn new(out: &'a mut dyn Out) -> Self {
        Self {
            out,
            lost: None,
            at: 0,
            end: 0,
        }
    }

    /// Does it, unless something is lost already.
    fn attempt<T>(&mut self, work: impl FnOnce(&mut dyn Out) -> io::Result<T>) -> Option<T> {
        if self.lost.is_some() {
            return None;
        }
        work(self.out).map_err(|e| self.lost = Some(e)).ok()
    }
}

impl Write for Steady<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.attempt(|out| out.write_all(bytes));
        self.at += bytes.len() as u64;
        self.end = self.end.max(self.at);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.attempt(|out| out.flush());
        Ok(())
    }
}

impl Seek for Steady<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let at = match to {
            SeekFrom::Start(at) => Some(at),
            SeekFrom::Current(by) => self.at.checked_add_signed(by),
            SeekFrom::End(by) => self.end.checked_add_signed(by),
        };
        self.at = at.ok_or(io::ErrorKind::InvalidInput)?;
        let at = self.at;
        self.attempt(|out| out.seek(SeekFrom::Start(at)));
        Ok(at)
    }
}

/// Writes the events.
pub(super) fn sink(head: &Head) -> io::Result<Writing> {
    let count = if head.channels > 1 { 5 } else { 4 };
    let columns = (0..count).map(|_| tempfile::tempfile().map(BufWriter::new));
    Ok(Writing {
        head: *head,
        events: 0,
        columns: columns.collect::<io::Result<_>>()?,
    })
}

#[derive(Debug)]
pub(super) struct Writing {
    head: Head,
    events: u64,
    columns: Vec<BufWriter<File>>,
}

impl Sink for Writing {
    fn start(&mut self, _: &mut dyn Out) -> io::Result<()> {
        Ok(())
    }

    fn put(&mut self, _: &mut dyn Out, events: &[Event]) -> io::Result<()> {
        self.events += events.len() as u64;
        for (number, column) in self.columns.iter_mut().enumerate() {
            for e in events {
                match number {
                    0 => column.write_all(&e.t.0.to_le_bytes())?,
                    1 => column.write_all(&e.x.to_le_bytes())?,
                    2 => column.write_all(&e.y.to_le_bytes())?,
                    3 => column.write_all(&[e.polarity.bit()])?,
                    _ => column.write_all(&[e.channel])?,
                }
            }
        }
        Ok(())
    }

    fn finish(&mut self, out: &mut dyn Out) -> io::Result<()> {
        let mut steady = Steady::new(out);
        let written = self.archive(&mut steady);
        // What went wrong first.
        steady.lost.map_or(written, Err)
    }
}

impl Writing {
    fn archive(&mut self, out: &mut Steady<'_>) -> io::Result<()> {
        let mut zip = ZipWriter::new(out);
        zip.set_comment(self.head.about().to_string())?;
        // The same file for the same events: no clock.
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .large_file(self.events >= 1 << 28);
        for (column, (name, kind)) in self.columns.iter_mut().zip(COLUMNS) {
            zip.start_file(format!("{name}.npy"), options)?;
            zip.write_all(&npy::written_header(kind, self.events, "")?)?;
            column.flush()?;
            let file = column.get_mut();
            file.seek(SeekFrom::Start(0))?;
            io::copy(file, &mut zip)?;
        }
        zip.finish()?;
        Ok(())
    }
}
