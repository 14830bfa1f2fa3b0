//! numpy's `.npy` with one record an event: `numpy.load(path)`.
//!
//! Dtype `[('t','<i8'),('x','<i2'),('y','<i2'),('p','i1')]` (the names and order that tonic
//! wants), and `('channel','u1')` when there are several channels. Size, channels, time
//! watched and drops travel as a comment behind the header's dictionary, `# amacrine size=…`:
//! numpy reads the header as a Python literal, in which a comment is allowed, so `read`
//! gives back the very packet that `write` got.
//!
//! Read with integers of any width and byte order, the fields in any order, padding, and
//! booleans for `p`; versions 1 to 3. Layout: numpy's NEP 1,
//! <https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>.

use std::io::{self, SeekFrom};

use super::{
    Fault, Place,
    about::{About, BLANK},
    chunks::Chunks,
    entry::{Entry, Limits, Sign, Streams},
    fault::Stop,
    gate::{Numbers, Raw, hold_kinds},
    head::Head,
    source::{BLOCK, Out, Sink, Source},
};
use crate::{
    event::Event,
    npy::{MAGIC, framed},
};

/// The format's entry in the list of formats.
pub(super) const ENTRY: Entry = Entry {
    name: "npy",
    extension: "npy",
    limits: Limits {
        x: i16::MAX.unsigned_abs(),
        y: i16::MAX.unsigned_abs(),
        ..Limits::WIDE
    },
    readers: "numpy",
    module: "numpy",
    python: "numpy.load(path)",
    sign: Sign::Bytes(MAGIC),
    streams: Some(Streams {
        source: |_, chunks| Ok(Box::new(source(chunks)?)),
        sink: |head, _| Ok(Box::new(sink(head))),
    }),
    ..Entry::PLAIN
};

/// numpy itself refuses headers above ten thousand bytes.
const LONGEST_HEADER: usize = 1 << 16;

/// No event is this long, in bytes.
const LONGEST_RECORD: usize = 1 << 16;

/// A writer of events.
pub(super) fn sink(head: &Head) -> Writing {
    Writing {
        head: head.clone(),
        events: 0,
        bytes: Vec::new(),
    }
}

#[derive(Debug)]
pub(super) struct Writing {
    head: Head,
    events: u64,
    bytes: Vec<u8>,
}

impl Writing {
    /// The header; its length does not depend on what is not known before the events.
    fn header(&self, about: &About) -> io::Result<Vec<u8>> {
        let more = if self.head.channels > 1 {
            ", ('channel', '|u1')"
        } else {
            ""
        };
        let record = format!("[('t', '<i8'), ('x', '<i2'), ('y', '<i2'), ('p', '|i1'){more}]");
        let columns = self.head.about().to_string().len() + BLANK.len();
        let comment = format!(" # {}", about.clone().within(columns));
        written_header(&record, self.events, &comment)
    }
}

/// The bytes of a header (version 1); its length does not depend on `events`.
pub(super) fn written_header(record: &str, events: u64, comment: &str) -> io::Result<Vec<u8>> {
    // As many digits as there are, so that the header can be written again at the end.
    let digits = u64::MAX.to_string().len() - events.to_string().len();
    let header = format!(
        "{{'descr': {record}, 'fortran_order': False, 'shape': ({events},), }}{:digits$}{comment}",
        ""
    );
    framed(&header, 0)
}

impl Sink for Writing {
    fn start(&mut self, out: &mut dyn Out) -> io::Result<()> {
        out.write_all(&self.header(&self.head.about())?)
    }

    fn put(&mut self, out: &mut dyn Out, events: &[Event]) -> io::Result<()> {
        let channels = self.head.channels > 1;
        self.events += events.len() as u64;
        let fill = |record: &mut [u8; 13], e: &Event| {
            record[..8].copy_from_slice(&e.t.0.to_le_bytes());
            record[8..10].copy_from_slice(&e.x.to_le_bytes());
            record[10..12].copy_from_slice(&e.y.to_le_bytes());
            record[12] = e.polarity.bit();
        };
        if channels {
            self.bytes.resize(14 * events.len(), 0);
            for (record, e) in self.bytes.as_chunks_mut::<14>().0.iter_mut().zip(events) {
                if let Some((record, [channel])) = record.split_first_chunk_mut() {
                    fill(record, e);
                    *channel = e.channel;
                }
            }
        } else {
            self.bytes.resize(13 * events.len(), 0);
            for (record, e) in self.bytes.as_chunks_mut().0.iter_mut().zip(events) {
                fill(record, e);
            }
        }
        out.write_all(&self.bytes)
    }

    fn finish(&mut self, out: &mut dyn Out, about: &About) -> io::Result<()> {
        out.seek(SeekFrom::Start(0))?;
        out.write_all(&self.header(about)?)?;
        out.seek(SeekFrom::End(0))?;
        Ok(())
    }
}

/// A reader of records.
pub(super) struct Reading {
    chunks: Chunks,
    record: Record,
    events: u64,
    about: About,
    /// Events read, and where the last block starts.
    read: u64,
    from: u64,
}

/// Opens a file's stream of events.
pub(super) fn source(mut chunks: Chunks) -> Result<Reading, Stop> {
    let header = header(&mut chunks, true)?;
    let Shape::Record(record) = header.shape else {
        return Err(Stop::Fault(Place::Byte(0), Fault::Magic));
    };
    hold_kinds(header.about.as_ref(), record.channel.is_some())
        .map_err(|fault| chunks.stop(fault))?;
    Ok(Reading {
        from: chunks.at(),
        chunks,
        record,
        events: header.events,
        about: header.about.unwrap_or_default(),
        read: 0,
    })
}

impl Source for Reading {
    fn about(&self) -> About {
        self.about.clone()
    }

    fn fill(&mut self, events: &mut Vec<Event>) -> Result<bool, Stop> {
        let width = self.record.width;
        let left = self.events - self.read;
        self.from = self.chunks.at();
        if left == 0 {
            if self.chunks.ahead(1)?.is_empty() {
                return Ok(false);
            }
            return Err(self.chunks.stop(Fault::Trailing));
        }
        let here = self.chunks.ahead(width)?;
        if here.len() < width {
            return Err(self.chunks.truncated(format!("event {}", self.read)));
        }
        let room = usize::try_from(left).unwrap_or(BLOCK).min(BLOCK);
        let (from, mut read) = (self.from, 0);
        let plain = self.record.plain;
        events.reserve(room.min(here.len() / width));
        for record in here.chunks_exact(width).take(room) {
            if let (true, Some(own)) = (plain, record.first_chunk())
                && let Some(event) = numbers(*own).event()
            {
                events.push(event);
                read += 1;
                continue;
            }
            let event = self.record.read(record).event().map_err(|fault| {
                let at = from + (read * width) as u64;
                Stop::Fault(Place::Byte(at), fault)
            })?;
            events.push(event);
            read += 1;
        }
        self.read += read as u64;
        self.chunks.eat(read * width);
        Ok(true)
    }

    fn place(&self, event: usize) -> Place {
        Place::Byte(self.from + (event * self.record.width) as u64)
    }
}

/// A reader of an array with one number for each event.
pub(super) struct Column {
    chunks: Chunks,
    field: Field,
    /// The bytes of the numbers that were taken last.
    block: Vec<u8>,
    /// How many there are.
    pub events: u64,
}

/// Reads an array of integers.
pub(super) fn column(mut chunks: Chunks) -> Result<Column, Stop> {
    let Header { shape, events, .. } = header(&mut chunks, false)?;
    let Shape::Number(Some(field)) = shape else {
        let why = "should describe one integer an event".into();
        return Err(Stop::Fault(Place::Byte(0), Fault::Npy { why }));
    };
    Ok(Column {
        chunks,
        field,
        block: Vec::new(),
        events,
    })
}

impl Column {
    /// Takes the next `count` numbers in place of the last ones, or those before the array breaks
    /// off.
    pub(super) fn take(&mut self, count: usize) -> Result<(), Stop> {
        self.block.clear();
        let (width, mut left) = (self.field.width, count);
        while left > 0 {
            let here = self.chunks.ahead(width)?;
            let whole = (here.len() / width).min(left);
            let Some(bytes) = here.get(..whole * width).filter(|_| whole > 0) else {
                return Err(self.chunks.truncated("an array".into()));
            };
            self.block.extend_from_slice(bytes);
            self.chunks.eat(whole * width);
            left -= whole;
        }
        Ok(())
    }

    /// How many numbers were taken last.
    pub(super) fn taken(&self) -> usize {
        self.block.len() / self.field.width
    }

    /// One of them.
    pub(super) fn value(&self, n: usize) -> i128 {
        let bytes = self.block.get(n * self.field.width..).unwrap_or_default();
        self.field.read(bytes)
    }

    /// All of them, where each has `N` bytes, the lowest first.
    pub(super) fn plain<const N: usize>(&self) -> Option<&[[u8; N]]> {
        let plain = self.field.width == N && (N == 1 || !self.field.big);
        plain.then(|| self.block.as_chunks().0)
    }

    /// Whether they have a sign.
    pub(super) const fn is_signed(&self) -> bool {
        self.field.signed
    }

    /// Checks that the file ends here.
    pub(super) fn end(&mut self) -> Result<(), Stop> {
        if self.chunks.ahead(1)?.is_empty() {
            return Ok(());
        }
        Err(self.chunks.stop(Fault::Trailing))
    }
}

/// The type of the array.
enum Shape {
    Record(Record),
    /// `None` when it is no integer.
    Number(Option<Field>),
}

/// What the header says.
struct Header {
    shape: Shape,
    events: u64,
    about: Option<About>,
}

/// The header of an array of records, or of one number an event.
fn header(bytes: &mut Chunks, records: bool) -> Result<Header, Stop> {
    let mut start = [0; 8];
    bytes
        .fill(&mut start, || "the first eight bytes".into())
        .and_then(|()| match start {
            [magic @ .., 1..=3, 0] if magic == MAGIC => Ok(()),
            _ => Err(Stop::Fault(Place::Byte(0), Fault::Magic)),
        })?;
    let mut length = [0; 4];
    let digits = if start[6] == 1 { 2 } else { 4 };
    bytes.fill(&mut length[..digits], || "the length of the header".into())?;
    let length = u32::from_le_bytes(length) as usize;
    let from = bytes.at();
    let wrong =
        |at: usize, why: String| Stop::Fault(Place::Byte(from + at as u64), Fault::Npy { why });
    if length > LONGEST_HEADER {
        return Err(wrong(
            0,
            format!("is {length} bytes long, which no event file needs"),
        ));
    }
    let mut text = vec![0; length];
    bytes.fill(&mut text, || "the header".into())?;
    let text = String::from_utf8(text).map_err(|_| wrong(0, "is not text".into()))?;
    let mut literal = Literal {
        text: &text,
        at: 0,
        records,
        comment: None,
    };
    let (shape, events) = literal.header().map_err(|why| wrong(literal.at, why))?;
    let about = literal.comment.map_or(Ok(None), About::parse);
    Ok(Header {
        shape,
        events,
        about: about.map_err(|fault| Stop::Fault(Place::Byte(from), fault))?,
    })
}

/// The layout of one event in the file.
#[derive(Debug, Default)]
struct Record {
    /// Bytes of one event.
    width: usize,
    t: Field,
    x: Field,
    y: Field,
    p: Field,
    channel: Option<Field>,
    /// Whether it is the layout that this program writes, without channels.
    plain: bool,
}

/// Decodes a record of that layout.
fn numbers(record: [u8; 13]) -> Numbers {
    let [t0, t1, t2, t3, t4, t5, t6, t7, x0, x1, y0, y1, p] = record;
    Numbers {
        t: i64::from_le_bytes([t0, t1, t2, t3, t4, t5, t6, t7]),
        x: i16::from_le_bytes([x0, x1]).into(),
        y: i16::from_le_bytes([y0, y1]).into(),
        p: i64::from(p as i8),
        channel: 0,
    }
}

impl Record {
    fn read(&self, record: &[u8]) -> Raw {
        Raw {
            t: self.t.read(record),
            x: self.x.read(record),
            y: self.y.read(record),
            p: self.p.read(record),
            channel: self.channel.map_or(0, |field| field.read(record)),
        }
    }
}

/// One integer of a record.
#[derive(Clone, Copy, Debug, Default)]
struct Field {
    offset: usize,
    width: usize,
    signed: bool,
    big: bool,
}

impl Field {
    /// Parses a numpy type code; `None` for what is not an integer.
    fn parse(code: &str, offset: usize) -> Option<Self> {
        let (order, kind) = match code.as_bytes() {
            [order @ (b'<' | b'>' | b'|' | b'='), kind @ ..] => (*order, kind),
            kind => (b'|', kind),
        };
        let (signed, width) = match kind {
            [kind @ (b'i' | b'u'), width @ (b'1' | b'2' | b'4' | b'8')] => {
                (*kind == b'i', usize::from(width - b'0'))
            }
            b"b1" => (false, 1),
            _ => return None,
        };
        Some(Self {
            offset,
            width,
            signed,
            big: order == b'>',
        })
    }

    /// The number of a record.
    fn read(self, record: &[u8]) -> i128 {
        self.exact(self.bits(record))
    }

    /// A number in 64 bits: one of `u8` that is too large for that is below 0.
    fn bits(self, record: &[u8]) -> i64 {
        let mut bytes = [0; 8];
        let field = record.iter().skip(self.offset).take(self.width);
        for (to, from) in bytes.iter_mut().zip(field) {
            *to = *from;
        }
        if self.big {
            bytes[..self.width].reverse();
        }
        let value = i64::from_le_bytes(bytes);
        if self.signed {
            // Shifted up and down again, so that the sign fills the upper bits.
            let unused = 64 - 8 * self.width;
            value << unused >> unused
        } else {
            value
        }
    }

    /// The number that has these 64 bits.
    fn exact(self, bits: i64) -> i128 {
        if self.signed {
            bits.into()
        } else {
            bits.cast_unsigned().into()
        }
    }
}

/// A parser of the header, a Python literal, from left to right.
struct Literal<'a> {
    text: &'a str,
    at: usize,
    /// Whether they are records that are described.
    records: bool,
    comment: Option<&'a str>,
}

impl<'a> Literal<'a> {
    /// The whole header: the record and the number of events.
    fn header(&mut self) -> Result<(Shape, u64), String> {
        let (mut shape, mut order, mut events) = (None, None, None);
        self.expect("{")?;
        while !self.take("}") {
            let key = self.string()?;
            self.expect(":")?;
            match key {
                "descr" => {
                    shape = Some(if self.records {
                        Shape::Record(self.record()?)
                    } else {
                        Shape::Number(Field::parse(self.string()?, 0))
                    });
                }
                "fortran_order" => {
                    // The same for one dimension.
                    order = Some(self.take("True") || self.take("False"));
                }
                "shape" => {
                    self.expect("(")?;
                    events = Some(self.number()?);
                    self.take(",");
                    if !self.take(")") {
                        return Err("should have a shape of one dimension, (events,)".into());
                    }
                }
                other => return Err(format!("has an unknown key `{other}`")),
            }
            if !self.take(",") {
                self.expect("}")?;
                break;
            }
        }
        self.skip();
        if self.at < self.text.len() {
            return Err("goes on after its dictionary".into());
        }
        match (shape, order, events) {
            (Some(shape), Some(true), Some(events)) => Ok((shape, events)),
            _ => Err("should have `descr`, `fortran_order` (True or False) and `shape`".into()),
        }
    }

    /// A list of `('name', 'type')`.
    fn record(&mut self) -> Result<Record, String> {
        if !self.take("[") {
            return Err("should describe records with the fields t, x, y and p".into());
        }
        let [mut t, mut x, mut y, mut p, mut channel] = [None; 5];
        let mut width = 0_usize;
        let mut codes = Vec::new();
        while !self.take("]") {
            self.expect("(")?;
            let name = self.string()?;
            self.expect(",")?;
            let code = self.string()?;
            if !self.take(")") {
                return Err(format!(
                    "should have one number for `{name}` in each record"
                ));
            }
            codes.extend([name, code]);
            let padding = code
                .strip_prefix("|V")
                .filter(|_| name.is_empty())
                .and_then(|n| n.parse::<u16>().ok());
            if let Some(padding) = padding {
                width += usize::from(padding);
            } else {
                let slot = match name {
                    // The longer names are dv-processing's.
                    "t" | "timestamp" => &mut t,
                    "x" => &mut x,
                    "y" => &mut y,
                    "p" | "polarity" => &mut p,
                    "channel" => &mut channel,
                    _ => return Err(format!("has an unknown field `{name}`")),
                };
                let field = Field::parse(code, width)
                    .ok_or_else(|| format!("has `{code}` for `{name}`, which is no integer"))?;
                if slot.replace(field).is_some() {
                    return Err(format!("has the field `{name}` twice"));
                }
                width += field.width;
            }
            if width > LONGEST_RECORD {
                return Err("describes records that are too long".into());
            }
            if !self.take(",") {
                self.expect("]")?;
                break;
            }
        }
        let missing = |name| move || format!("has no field `{name}`");
        let code: String = codes.concat();
        Ok(Record {
            plain: code == "t<i8x<i2y<i2p|i1" || code == "t<i8x<i2y<i2pi1",
            width,
            t: t.ok_or_else(missing("t"))?,
            x: x.ok_or_else(missing("x"))?,
            y: y.ok_or_else(missing("y"))?,
            p: p.ok_or_else(missing("p"))?,
            channel,
        })
    }

    /// White space and comments; of the comments the last is kept.
    fn skip(&mut self) {
        loop {
            let rest = self.rest();
            let trimmed = rest.trim_ascii_start();
            self.at += rest.len() - trimmed.len();
            let Some(comment) = trimmed.strip_prefix('#') else {
                return;
            };
            let end = comment.find('\n').unwrap_or(comment.len());
            self.comment = Some(&comment[..end]);
            self.at += 1 + end;
        }
    }

    fn rest(&self) -> &'a str {
        self.text.get(self.at..).unwrap_or("")
    }

    fn take(&mut self, token: &str) -> bool {
        self.skip();
        let found = self.rest().starts_with(token);
        if found {
            self.at += token.len();
        }
        found
    }

    fn expect(&mut self, token: &str) -> Result<(), String> {
        if self.take(token) {
            Ok(())
        } else {
            Err(format!("cannot be read: expected `{token}`"))
        }
    }

    fn string(&mut self) -> Result<&'a str, String> {
        self.skip();
        let rest = self.rest();
        let inside = ['\'', '"']
            .into_iter()
            .find_map(|quote| rest.strip_prefix(quote)?.split_once(quote))
            .map(|(inside, _)| inside)
            .ok_or("cannot be read: expected a name in quotes")?;
        self.at += inside.len() + 2;
        Ok(inside)
    }

    fn number(&mut self) -> Result<u64, String> {
        self.skip();
        let rest = self.rest();
        let end = rest
            .find(|c: char| !c.is_ascii_digit())
            .unwrap_or(rest.len());
        let number = rest[..end]
            .parse()
            .map_err(|_| "should have a shape of one dimension, (events,)")?;
        self.at += end;
        Ok(number)
    }
}
