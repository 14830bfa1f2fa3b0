//! Comma-separated text: the header `t,x,y,p`, then one event a line.
//!
//! `t` in whole microseconds, `p` 1 for ON and 0 for OFF. A packet of several channels has a
//! fifth column, `channel`. Written bare, so that `pandas.read_csv(path)`, `csv.DictReader`
//! and `numpy.genfromtxt(path, delimiter=',', names=True, dtype=int)` all take it as it is.
//!
//! Read with the columns in any order, `p` also as -1, and comments (`# …`); a comment
//! `# amacrine size=346x260` before the first event gives the size.

use std::io::{self, BufRead, Write};

use super::{
    Fault, Loaded,
    about::About,
    fault::Stop,
    intake::{Intake, Raw},
    line::{Line, Lines, integer, shown},
};
use crate::event::Packet;

/// Writes the events.
pub(super) fn write(out: &mut dyn Write, packet: &Packet) -> io::Result<()> {
    let channels = packet.channels > 1;
    out.write_all(if channels {
        b"t,x,y,p,channel\n"
    } else {
        b"t,x,y,p\n"
    })?;
    for e in &packet.events {
        write!(out, "{},{},{},{}", e.t.0, e.x, e.y, e.polarity.bit())?;
        if channels {
            write!(out, ",{}", e.channel)?;
        }
        out.write_all(b"\n")?;
    }
    Ok(())
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

/// Reads the events.
pub(super) fn read(input: &mut dyn BufRead) -> Result<Loaded, Stop> {
    let mut lines = Lines::new(input);
    let mut intake = Intake::new();
    let mut columns: Option<Vec<Column>> = None;
    while let Some(line) = lines.next()? {
        if let Some(comment) = line.comment() {
            let about = About::parse(&comment).map_err(|fault| line.stop(0, fault))?;
            if let Some(about) = about {
                intake.declare(about).map_err(|fault| line.stop(0, fault))?;
            }
            continue;
        }
        match &columns {
            None => columns = Some(header(&line)?),
            Some(columns) => {
                let raw = event(&line, columns)?;
                intake.take(raw).map_err(|fault| line.stop(0, fault))?;
            }
        }
    }
    if columns.is_none() {
        let why = "found no line at all".into();
        return Err(Stop::Fault(
            super::Place::Line { line: 1, column: 1 },
            Fault::Header { why },
        ));
    }
    Ok(intake.finish())
}

fn header(line: &Line<'_>) -> Result<Vec<Column>, Stop> {
    let mut columns = Vec::new();
    for field in line.text.split(|b| *b == b',') {
        let name = field.trim_ascii();
        let stop = |why| line.stop(line.column_of(field), Fault::Header { why });
        let column = Column::ALL
            .into_iter()
            .find(|c| c.name().as_bytes() == name)
            .ok_or_else(|| stop(format!("found `{}`", shown(name))))?;
        if columns.contains(&column) {
            return Err(stop(format!("found `{}` twice", column.name())));
        }
        columns.push(column);
    }
    for column in [Column::T, Column::X, Column::Y, Column::P] {
        if !columns.contains(&column) {
            let why = format!("`{}` is missing", column.name());
            return Err(line.stop(0, Fault::Header { why }));
        }
    }
    Ok(columns)
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
        match column {
            Column::T => raw.t = value,
            Column::X => raw.x = value,
            Column::Y => raw.y = value,
            Column::P => raw.p = value,
            Column::Channel => raw.channel = value,
        }
    }
    if let Some(extra) = fields.next() {
        let (want, got) = (columns.len(), columns.len() + 1 + fields.count());
        return Err(line.stop(line.column_of(extra), Fault::Fields { want, got }));
    }
    Ok(raw)
}
