//! Comma-separated text: the header `t,x,y,p`, then one event a line.
//!
//! `t` in whole microseconds, `p` 1 for ON and 0 for OFF. A packet of several channels has a
//! fifth column, `channel`. Written bare, so that `pandas.read_csv(path)`, `csv.DictReader`
//! and `numpy.genfromtxt(path, delimiter=',', names=True, dtype=int)` all take it as it is.
//!
//! Read with the columns in any order, `p` also as -1, and comments (`# …`); a comment
//! `# amacrine size=346x260` before the first event gives the size.

use std::io;

use super::{
    Fault,
    about::About,
    chunks::Chunks,
    entry::{Entry, Limits, Sign, Streams},
    fault::Stop,
    gate::Raw,
    line::{Line, Rows, Text, decimal, integer, shown},
    source::{Out, Sink},
};
use crate::event::Event;

/// The format's entry in the list of formats.
pub(super) const ENTRY: Entry = Entry {
    name: "csv",
    extension: "csv",
    limits: Limits::WIDE,
    readers: "pandas, numpy, Python's csv, faery",
    module: "pandas",
    python: "pandas.read_csv(path)",
    sign: Sign::Nothing,
    streams: Some(Streams {
        source: |_, chunks| Ok(Box::new(source(chunks))),
        sink: |head, _| Ok(Box::new(sink(head.channels > 1))),
    }),
    rewinds: false,
    remarks: false,
    ..Entry::PLAIN
};

/// A writer of events, with a column of channels or without.
pub(super) const fn sink(channels: bool) -> Writing {
    Writing {
        channels,
        text: Vec::new(),
    }
}

#[derive(Debug)]
pub(super) struct Writing {
    channels: bool,
    text: Vec<u8>,
}

impl Sink for Writing {
    fn start(&mut self, out: &mut dyn Out) -> io::Result<()> {
        out.write_all(if self.channels {
            b"t,x,y,p,channel\n"
        } else {
            b"t,x,y,p\n"
        })
    }

    fn put(&mut self, out: &mut dyn Out, events: &[Event]) -> io::Result<()> {
        self.text.clear();
        for e in events {
            decimal(&mut self.text, e.t.0);
            self.text.push(b',');
            decimal(&mut self.text, e.x.into());
            self.text.push(b',');
            decimal(&mut self.text, e.y.into());
            self.text.extend([b',', b'0' + e.polarity.bit()]);
            if self.channels {
                self.text.push(b',');
                decimal(&mut self.text, e.channel.into());
            }
            self.text.push(b'\n');
        }
        out.write_all(&self.text)
    }

    fn finish(&mut self, _: &mut dyn Out, _: &About) -> io::Result<()> {
        Ok(())
    }
}

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Column {
    T,
    X,
    Y,
    P,
    Channel,
}

impl Column {
    const ALL: [Self; 5] = [Self::T, Self::X, Self::Y, Self::P, Self::Channel];

    /// Puts the value of a field into its place.
    const fn put(self, value: i128, raw: &mut Raw) {
        match self {
            Self::T => raw.t = value,
            Self::X => raw.x = value,
            Self::Y => raw.y = value,
            Self::P => raw.p = value,
            Self::Channel => raw.channel = value,
        }
    }

    /// What dv-processing calls it.
    const fn alias(self) -> Option<&'static str> {
        match self {
            Self::T => Some("timestamp"),
            Self::P => Some("polarity"),
            Self::X | Self::Y | Self::Channel => None,
        }
    }

    const fn name(self) -> &'static str {
        match self {
            Self::T => "t",
            Self::X => "x",
            Self::Y => "y",
            Self::P => "p",
            Self::Channel => "channel",
        }
    }
}

/// Opens a file's stream of events.
pub(super) fn source(chunks: Chunks) -> Text<Csv> {
    Text::new(chunks, Csv::default())
}

/// What the header says.
#[derive(Debug, Default)]
pub(super) struct Csv {
    columns: Option<Vec<Column>>,
}

impl Rows for Csv {
    fn row(&mut self, line: &Line<'_>) -> Result<Option<Raw>, Stop> {
        match &self.columns {
            None => {
                self.columns = Some(header(line)?);
                Ok(None)
            }
            Some(columns) => match plain(line.text, columns) {
                None => event(line, columns).map(Some),
                raw => Ok(raw),
            },
        }
    }

    fn column(&self, line: &Line<'_>, name: &str) -> usize {
        let columns = self.columns.iter().flatten();
        let mut fields = line.text.split(|b| *b == b',').zip(columns);
        let field = fields.find(|(_, column)| column.name() == name);
        field.map_or(0, |(field, _)| line.column_of(field))
    }

    fn end(&self) -> Result<(), Stop> {
        if self.columns.is_some() {
            return Ok(());
        }
        let why = "found no line at all".into();
        let place = super::Place::Line { line: 1, column: 1 };
        Err(Stop::Fault(place, Fault::Header { why, way: NAMES }))
    }
}

/// What to do about a header that does not name the columns.
const NAMES: &str = "let the first line name the columns: t,x,y,p";

/// What to do about a first line that is no header, by what it looks like.
fn way(first: &[u8]) -> &'static str {
    let mut fields = first.split(|b| *b == b',').map(<[u8]>::trim_ascii);
    if first.contains(&b'\r') {
        return "end each line with \\n, or \\r\\n: a lone \\r, which some spreadsheets write, ends none (tr '\\r' '\\n' turns them)";
    }
    if fields.clone().all(|field| integer(field).is_some()) {
        "put a line before it that names the columns in their order: t,x,y,p, or x,y,p,t as Metavision has them"
    } else if fields.next() == Some(b"") {
        "leave the index out, as pandas does with `to_csv(path, index=False)`"
    } else if !first.contains(&b',') {
        "let commas stand between the columns, and the first line name them: t,x,y,p"
    } else {
        NAMES
    }
}

fn header(line: &Line<'_>) -> Result<Vec<Column>, Stop> {
    let mut columns = Vec::new();
    let way = way(line.text);
    for field in line.text.split(|b| *b == b',') {
        let name = field.trim_ascii();
        let stop = |why| line.stop(line.column_of(field), Fault::Header { why, way });
        let column = Column::ALL
            .into_iter()
            .find(|c| {
                c.name().as_bytes() == name || c.alias().is_some_and(|its| its.as_bytes() == name)
            })
            .ok_or_else(|| stop(format!("found `{}`", shown(name))))?;
        if columns.contains(&column) {
            return Err(stop(format!("found `{}` twice", column.name())));
        }
        columns.push(column);
    }
    for column in [Column::T, Column::X, Column::Y, Column::P] {
        if !columns.contains(&column) {
            let why = format!("`{}` is missing", column.name());
            return Err(line.stop(0, Fault::Header { why, way }));
        }
    }
    Ok(columns)
}

/// The event of a line of nothing but digits and commas, in one walk; else [`event`] says what is
/// wrong, or that nothing is.
fn plain(text: &[u8], columns: &[Column]) -> Option<Raw> {
    let (mut numbers, mut field, mut digits) = ([0u64; Column::ALL.len()], 0, 0);
    for byte in text {
        let digit = byte.wrapping_sub(b'0');
        if digit < 10 {
            // What overflows has too many digits.
            let number = numbers.get_mut(field)?;
            *number = number.wrapping_mul(10).wrapping_add(digit.into());
            digits += 1;
        } else if *byte == b',' && (1..=19).contains(&digits) {
            (field, digits) = (field + 1, 0);
        } else {
            return None;
        }
    }
    if field + 1 != columns.len() || !(1..=19).contains(&digits) {
        return None;
    }
    let mut raw = Raw::default();
    for (column, number) in columns.iter().zip(numbers) {
        column.put(number.into(), &mut raw);
    }
    Some(raw)
}

fn event(line: &Line<'_>, columns: &[Column]) -> Result<Raw, Stop> {
    let mut raw = Raw::default();
    let mut fields = line.text.split(|b| *b == b',');
    for (i, column) in columns.iter().enumerate() {
        let Some(field) = fields.next() else {
            let (want, got) = (columns.len(), i);
            return Err(line.stop(line.text.len(), Fault::Fields { want, got }));
        };
        let value = integer(field.trim_ascii()).ok_or_else(|| {
            let (name, found) = (column.name(), shown(field));
            line.stop(line.column_of(field), Fault::NotInteger { name, found })
        })?;
        column.put(value, &mut raw);
    }
    if let Some(extra) = fields.next() {
        let (want, got) = (columns.len(), columns.len() + 1 + fields.count());
        return Err(line.stop(line.column_of(extra), Fault::Fields { want, got }));
    }
    Ok(raw)
}
