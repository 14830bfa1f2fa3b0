//! numpy's `.npz`: the arrays `t`, `x`, `y`, `p` (and `channel`), one number an event each:
//! `numpy.load(path)['t']`.
//!
//! t is `<i8`, x and y `<u2`, p and channel `|u1`; stored as they are. Size, channels, time
//! watched and drops travel as the comment of the archive. Archives are read stored or deflated, with
//! integers of any width; also one of one structured array. While a file is written its columns wait
//! in memory, long ones in temporary files. Layout:
//! <https://numpy.org/doc/stable/reference/generated/numpy.savez.html>.

use std::io::{self, BufReader, Read, Seek, SeekFrom, Write};

use flate2::read::DeflateDecoder;
use tempfile::{SpooledTempFile, spooled_tempfile};
use zip::{CompressionMethod, ZipArchive, ZipWriter, write::SimpleFileOptions};

use super::{
    Format, Place,
    about::About,
    chunks::Chunks,
    entry::{Entry, Limits, Sign, Streams},
    fault::{Fault, Stop},
    gate::{Raw, hold_kinds},
    head::Head,
    npy::{self, Column},
    origin::Origin,
    source::{BLOCK, Out, Sink, Source},
};
use crate::{
    event::{Event, Polarity},
    unit::Micros,
};

/// The format's entry in the list of formats.
pub(super) const ENTRY: Entry = Entry {
    name: "npz",
    extension: "npz",
    limits: Limits::WIDE,
    readers: "numpy, eventcv",
    module: "numpy",
    python: "numpy.load(path)",
    sign: Sign::Archive("npy"),
    index_at_end: true,
    streams: Some(Streams {
        source: |origin, _| source(origin),
        sink: |head, _| Ok(Box::new(sink(head))),
    }),
    ..Entry::PLAIN
};

/// The columns as they are written.
const COLUMNS: [(&str, &str); 5] = [
    ("t", "'<i8'"),
    ("x", "'<u2'"),
    ("y", "'<u2'"),
    ("p", "'|u1'"),
    ("channel", "'|u1'"),
];

fn wrong(why: impl Into<String>) -> Stop {
    wrong_in(Format::Npz, why)
}

fn wrong_in(format: Format, why: impl Into<String>) -> Stop {
    Stop::layout(format, 0, why)
}

/// An archive whose arrays are not those of events.
fn arrays(why: String) -> Stop {
    Stop::Fault(Place::Byte(0), Fault::Arrays { why })
}

/// What is wrong with the header of one array, said of that array.
fn of_array(name: &str, stop: Stop) -> Stop {
    match stop {
        Stop::Fault(_, Fault::Npy { why }) => {
            arrays(format!("has an array `{name}` whose NPY header {why}"))
        }
        other => other,
    }
}

/// Opens a file's stream of events.
pub(super) fn source(origin: &Origin) -> Result<Box<dyn Source>, Stop> {
    let input = BufReader::new(origin.open()?);
    let mut archive =
        ZipArchive::new(input).map_err(|e| wrong(format!("cannot be read as an archive: {e}")))?;
    archived(Format::Npz, origin, &archive)?;
    let names: Result<Vec<String>, _> = archive
        .file_names()
        .map(|name| name.map(std::borrow::Cow::into_owned))
        .collect();
    let names = names.map_err(|e| wrong(format!("has a name that is no text: {e}")))?;
    let has = |name: &str| names.iter().any(|n| n.strip_suffix(".npy") == Some(name));
    if let [name] = &names[..] {
        return Ok(Box::new(npy::source(member(
            Format::Npz,
            origin,
            &mut archive,
            name,
        )?)?));
    }
    for name in &names {
        let known = COLUMNS
            .iter()
            .any(|(column, _)| name.strip_suffix(".npy") == Some(column));
        if !known {
            return Err(arrays(format!(
                "holds `{name}`; it should hold the arrays t, x, y, p, and perhaps channel"
            )));
        }
    }
    let mut columns = Vec::new();
    for (name, _) in COLUMNS {
        if has(name) {
            let chunks = member(Format::Npz, origin, &mut archive, &format!("{name}.npy"))?;
            columns.push((
                name,
                npy::column(chunks).map_err(|stop| of_array(name, stop))?,
            ));
        } else if name != "channel" {
            return Err(arrays(format!("has no array `{name}`")));
        }
    }
    let events = columns.first().map_or(0, |(_, column)| column.events);
    for (name, column) in &columns {
        if column.events != events {
            return Err(wrong(format!(
                "has {} and {} of {name}",
                crate::unit::counted(events, "time"),
                crate::unit::counted(column.events, "value")
            )));
        }
    }
    let comment = String::from_utf8_lossy(archive.comment()).into_owned();
    let about = About::parse(&comment).map_err(|fault| Stop::Fault(Place::Byte(0), fault))?;
    hold_kinds(about.as_ref(), has("channel"))
        .map_err(|fault| Stop::Fault(Place::Byte(0), fault))?;
    Ok(Box::new(Reading {
        about: about.unwrap_or_default(),
        columns: columns.into_iter().map(|(_, column)| column).collect(),
        left: events,
        first: 0,
        read: 0,
    }))
}

/// Cross-checks an archive: its end record, its central directory and the members' own headers.
pub(super) fn archived(
    format: Format,
    origin: &Origin,
    archive: &ZipArchive<impl Read + Seek>,
) -> Result<(), Stop> {
    let start = archive.central_directory_start();
    let mut input = origin.open()?;
    let length = input.seek(SeekFrom::End(0))?;
    input.seek(SeekFrom::Start(start))?;
    let mut list = Vec::new();
    input.by_ref().take(LONGEST_LIST).read_to_end(&mut list)?;
    let list = Listed::read(&list)
        .ok_or_else(|| Stop::layout(format, start, "has a list of arrays that cannot be read"))?;
    let end = start + list.end as u64;
    let counts = [
        ("arrays", list.stated.0, list.members.len() as u64),
        ("arrays", list.stated.0, archive.len() as u64),
        ("bytes of list", list.stated.1, list.bytes as u64),
        ("bytes of remark at its end", list.stated.2, length - end),
    ];
    for (what, stated, found) in counts {
        if stated != found {
            let one = format!("its end says that it has {stated} {what}");
            return Err(Stop::twice(format, end, one, format!("there are {found}")));
        }
    }
    for member in &list.members {
        hold_member(
            format,
            member,
            archive.offset(),
            (start, length),
            &mut input,
        )?;
    }
    Ok(())
}

/// Cross-checks an entry of the central directory, which begins at byte `start` of a file of
/// `length` bytes, and the member's own header; `offset` is where the archive begins.
fn hold_member(
    format: Format,
    member: &Member,
    offset: u64,
    (start, length): (u64, u64),
    input: &mut (impl Read + Seek),
) -> Result<(), Stop> {
    let name = String::from_utf8_lossy(&member.name);
    let at = member.at.saturating_add(offset);
    if at >= length {
        let one = format!("its list says that `{name}` is at byte {at}");
        let other = format!("the file has {length} bytes");
        return Err(Stop::twice(format, start, one, other));
    }
    let local = input.seek(SeekFrom::Start(at)).and_then(|_| {
        let mut local = vec![0; 30 + member.name.len()];
        input.read_exact(&mut local).map(|()| local)
    });
    let unlike = |what: &str| {
        let one = format!("its list says one thing of the {what} of `{name}`");
        Err(Stop::twice(
            format,
            at,
            one,
            "the array's own header another",
        ))
    };
    let Ok(local) = local else {
        return unlike("place");
    };
    let part = |from, to| local.get(from..to).unwrap_or_default();
    if part(0, 4) != b"PK\x03\x04" {
        return unlike("place");
    }
    if part(30, local.len()) != member.name || part(26, 28) != member.head(28, 30) {
        return unlike("name");
    }
    if part(6, 8) != member.head(8, 10) || part(8, 10) != member.head(10, 12) {
        return unlike("compression");
    }
    // Sizes in a data descriptor behind the data, or of 64 bits, are not in this header.
    let later = part(6, 7).first().is_some_and(|flags| flags & 8 != 0);
    if !later && part(14, 18) != member.head(16, 20) {
        return unlike("check sum");
    }
    let elsewhere = |size: &[u8]| size == [0xFF; 4];
    for (own, listed) in [((18, 22), (20, 24)), ((22, 26), (24, 28))] {
        let (own, listed) = (part(own.0, own.1), member.head(listed.0, listed.1));
        if !later && own != listed && !elsewhere(own) && !elsewhere(listed) {
            return unlike("size");
        }
    }
    Ok(())
}

/// The longest central directory with its comment, in bytes: there are few arrays.
const LONGEST_LIST: u64 = 1 << 20;

/// The central directory of an archive, and its end record.
struct Listed {
    members: Vec<Member>,
    /// Bytes of the directory, and from its start to the comment behind the end record.
    bytes: usize,
    end: usize,
    /// As the end record states: number of members, bytes of the directory, bytes of the comment.
    stated: (u64, u64, u64),
}

/// An entry of the central directory.
struct Member {
    head: [u8; 46],
    name: Vec<u8>,
    /// Place of the member's own (local) header.
    at: u64,
}

impl Member {
    fn head(&self, from: usize, to: usize) -> &[u8] {
        self.head.get(from..to).unwrap_or_default()
    }
}

impl Listed {
    /// Parses the bytes from the directory's start on.
    fn read(bytes: &[u8]) -> Option<Self> {
        /// `N` bytes of a number.
        fn number<const N: usize>(bytes: &[u8], at: usize) -> Option<u64> {
            let mut wide = [0; 8];
            wide[..N].copy_from_slice(bytes.get(at..at + N)?);
            Some(u64::from_le_bytes(wide))
        }
        let (mut at, mut members) = (0, Vec::new());
        while bytes.get(at..at + 4)? == b"PK\x01\x02" {
            let head: [u8; 46] = bytes.get(at..at + 46)?.try_into().ok()?;
            let part = |place| number::<2>(&head, place).map(|n| n as usize);
            let (name, extra, comment) = (part(28)?, part(30)?, part(32)?);
            let start = at + 46;
            let wide = bytes.get(start + name..start + name + extra)?;
            let mut place = number::<4>(&head, 42)?;
            if place == u64::from(u32::MAX) {
                // Behind the sizes that are too large as well.
                let sizes = [20, 24].map(|p| number::<4>(&head, p) == Some(u64::from(u32::MAX)));
                let before = sizes.iter().filter(|wide| **wide).count();
                place = number::<8>(wide, 4 + 8 * before)?;
            }
            members.push(Member {
                head,
                name: bytes.get(start..start + name)?.to_vec(),
                at: place,
            });
            at = start + name + extra + comment;
        }
        let length = at;
        let mut wide = None;
        if bytes.get(at..at + 4)? == b"PK\x06\x06" {
            wide = Some((number::<8>(bytes, at + 32)?, number::<8>(bytes, at + 40)?));
            at += 12 + usize::try_from(number::<8>(bytes, at + 4)?).ok()? + 20;
        }
        if bytes.get(at..at.checked_add(4)?)? != b"PK\x05\x06" {
            return None;
        }
        let (count, size) = (number::<2>(bytes, at + 10)?, number::<4>(bytes, at + 12)?);
        let (count, size) = match wide {
            Some(wide) => wide,
            None => (count, size),
        };
        Some(Self {
            members,
            bytes: length,
            end: at + 22,
            stated: (count, size, number::<2>(bytes, at + 20)?),
        })
    }
}

/// Opens one array of the archive, with a file handle of its own.
pub(super) fn member(
    format: Format,
    origin: &Origin,
    archive: &mut ZipArchive<impl Read + Seek>,
    name: &str,
) -> Result<Chunks, Stop> {
    let bad = |e| {
        wrong_in(
            format,
            format!("has an array `{name}` that cannot be read: {e}"),
        )
    };
    let file = archive.by_name_raw(name.as_bytes()).map_err(bad)?;
    let (start, size) = (file.data_start(), file.compressed_size());
    let length = file.size();
    let (method, crc, encrypted) = (file.compression(), file.crc32(), file.encrypted());
    let start = start.ok_or_else(|| wrong_in(format, format!("does not say where `{name}` is")))?;
    drop(file);
    if encrypted {
        return Err(wrong_in(format, format!("is encrypted, `{name}` too")));
    }
    let mut input = origin.open()?;
    input.seek(SeekFrom::Start(start))?;
    let input = BufReader::with_capacity(1 << 16, input.take(size));
    let bytes: Box<dyn Read + Send> = match method {
        CompressionMethod::Stored => Box::new(input),
        CompressionMethod::Deflated => Box::new(DeflateDecoder::new(input)),
        other => {
            let why = format!("has `{name}` compressed by {other}; stored and deflated are read");
            return Err(wrong_in(format, why));
        }
    };
    Ok(Chunks::new(Box::new(Checked {
        bytes,
        sum: flate2::Crc::new(),
        crc,
        left: length,
    })))
}

/// A reader that verifies a checksum at its end.
struct Checked {
    bytes: Box<dyn Read + Send>,
    sum: flate2::Crc,
    crc: u32,
    /// Bytes still expected.
    left: u64,
}

impl Read for Checked {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.bytes.read(buffer)?;
        self.sum.update(&buffer[..read]);
        let left = self.left.checked_sub(read as u64);
        if left.is_none() || (read == 0 && !buffer.is_empty() && left != Some(0)) {
            let why = "an array does not have as many bytes as its archive says";
            return Err(io::Error::new(io::ErrorKind::InvalidData, why));
        }
        self.left = left.unwrap_or(0);
        if read == 0 && !buffer.is_empty() && self.sum.sum() != self.crc {
            let why = "an array is damaged: its check sum is another";
            return Err(io::Error::new(io::ErrorKind::InvalidData, why));
        }
        Ok(read)
    }
}

/// Reads the columns side by side.
struct Reading {
    about: About,
    /// t, x, y, p, and perhaps the channel.
    columns: Vec<Column>,
    left: u64,
    /// Number of the first event of the last block, and of the next.
    first: u64,
    read: u64,
}

impl Reading {
    /// An event of the block, as wide as the file has it.
    fn exact(&self, event: usize) -> Raw {
        let of = |column: usize| self.columns.get(column).map_or(0, |it| it.value(event));
        Raw {
            t: of(0),
            x: of(1),
            y: of(2),
            p: of(3),
            channel: of(4),
        }
    }

    /// Adds all events of the block where its columns have the widths that numpy and this program
    /// give them, and all are good; else none.
    fn plain(&self, events: &mut Vec<Event>) -> Option<()> {
        let [t, x, y, p, channels @ ..] = &self.columns[..] else {
            return None;
        };
        let limit = |column: &Column| if column.is_signed() { 0x7F } else { 0xFF };
        let highest = |column: &Column| u16::from_le_bytes([0xFF, limit(column)]);
        let (highest_x, highest_y, signed) = (highest(x), highest(y), p.is_signed());
        let (t, x, y, p) = (t.plain()?, x.plain()?, y.plain()?, p.plain()?);
        let rows = t.iter().zip(x).zip(y).zip(p);
        let (mut good, before) = (true, events.len());
        events.extend(rows.map(|(((t, x), y), [p])| {
            let t = u64::from_le_bytes(*t);
            let (x, y) = (u16::from_le_bytes(*x), u16::from_le_bytes(*y));
            good &= i64::try_from(t).is_ok();
            good &= x <= highest_x;
            good &= y <= highest_y;
            // 255 is -1 where there is a sign.
            good &= *p <= 1 || (signed && *p == u8::MAX);
            Event {
                t: Micros(t),
                x,
                y,
                polarity: Polarity::of(*p == 1),
                channel: 0,
            }
        }));
        if let [column] = channels {
            // One less than a byte holds, since their number is a byte too.
            let most = limit(column).min(u8::MAX - 1);
            for (event, [channel]) in events[before..].iter_mut().zip(column.plain()?) {
                good &= *channel <= most;
                event.channel = *channel;
            }
        }
        if !good {
            events.truncate(before);
        }
        good.then_some(())
    }
}

impl Source for Reading {
    fn about(&self) -> About {
        self.about.clone()
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
        // Events before a damage are whole: they are told before it is.
        let (mut whole, mut damage) = (count, None);
        for column in &mut self.columns {
            damage = column.take(whole).err().or(damage);
            whole = column.taken();
        }
        if damage.is_some() || self.plain(events).is_none() {
            for k in 0..whole {
                let place = self.place(k);
                let event = self.exact(k).event();
                events.push(event.map_err(|fault| Stop::Fault(place, fault))?);
            }
        }
        self.read += whole as u64;
        self.left -= whole as u64;
        if let Some(damage) = damage {
            return Err(damage);
        }
        Ok(true)
    }

    fn place(&self, event: usize) -> Place {
        Place::Event(self.first + event as u64)
    }
}

/// A writer that never fails, and remembers the first error: a `ZipWriter` that meets one panics,
/// or prints.
pub(in crate::event) struct Steady<'a> {
    out: &'a mut dyn Out,
    pub(in crate::event) lost: Option<io::Error>,
    at: u64,
    end: u64,
}

impl<'a> Steady<'a> {
    pub(in crate::event) fn new(out: &'a mut dyn Out) -> Self {
        Self {
            out,
            lost: None,
            at: 0,
            end: 0,
        }
    }

    /// Tries `work`, unless an error came before.
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

/// Bytes of a column that wait in memory: more do in a temporary file.
const WAITING: usize = 1 << 23;

/// A writer of events.
pub(super) fn sink(head: &Head) -> Writing {
    let count = if head.channels > 1 { 5 } else { 4 };
    Writing {
        events: 0,
        columns: (0..count).map(|_| spooled_tempfile(WAITING)).collect(),
        block: Vec::new(),
    }
}

#[derive(Debug)]
pub(super) struct Writing {
    events: u64,
    columns: Vec<SpooledTempFile>,
    /// The bytes of one column, of the last events.
    block: Vec<u8>,
}

/// Puts each event's bytes after one another, in place of what `block` holds.
fn gather<const N: usize>(
    block: &mut Vec<u8>,
    events: &[Event],
    bytes: impl Fn(&Event) -> [u8; N],
) {
    block.resize(N * events.len(), 0);
    for (place, event) in block.as_chunks_mut::<N>().0.iter_mut().zip(events) {
        *place = bytes(event);
    }
}

impl Sink for Writing {
    fn start(&mut self, _: &mut dyn Out) -> io::Result<()> {
        Ok(())
    }

    fn put(&mut self, _: &mut dyn Out, events: &[Event]) -> io::Result<()> {
        self.events += events.len() as u64;
        let block = &mut self.block;
        for (number, column) in self.columns.iter_mut().enumerate() {
            match number {
                0 => gather(block, events, |e| e.t.0.to_le_bytes()),
                1 => gather(block, events, |e| e.x.to_le_bytes()),
                2 => gather(block, events, |e| e.y.to_le_bytes()),
                3 => gather(block, events, |e| [e.polarity.bit()]),
                _ => gather(block, events, |e| [e.channel]),
            }
            column.write_all(block)?;
        }
        Ok(())
    }

    fn finish(&mut self, out: &mut dyn Out, about: &About) -> io::Result<()> {
        let mut steady = Steady::new(out);
        let written = self.archive(&mut steady, about);
        // The first error.
        steady.lost.map_or(written, Err)
    }
}

impl Writing {
    fn archive(&mut self, out: &mut Steady<'_>, about: &About) -> io::Result<()> {
        let mut zip = ZipWriter::new(out);
        zip.set_comment(about.to_string())?;
        // The same file for the same events: no clock.
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .large_file(self.events >= 1 << 28);
        for (column, (name, kind)) in self.columns.iter_mut().zip(COLUMNS) {
            zip.start_file(format!("{name}.npy"), options)?;
            zip.write_all(&npy::written_header(kind, self.events, "")?)?;
            column.rewind()?;
            io::copy(column, &mut zip)?;
        }
        zip.finish()?;
        Ok(())
    }
}
