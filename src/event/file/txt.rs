//! Plain text as in the Event Camera Dataset (Mueggler et al. 2017, `events.txt`): one event
//! a line, `t x y p`, time in seconds.
//!
//! Written with nine decimals, because readers that truncate (evlib) would otherwise lose a
//! microsecond. Read to the nearest microsecond. There is no place for a channel.

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
    name: "txt",
    extension: "txt",
    limits: Limits {
        channels: false,
        ..Limits::WIDE
    },
    readers: "numpy, pandas, eventcv",
    module: "numpy",
    python: "numpy.loadtxt(path)",
    sign: Sign::Nothing,
    streams: Some(Streams {
        source: |_, chunks| Ok(Box::new(source(chunks))),
        sink: |_, _| Ok(Box::new(sink())),
    }),
    rewinds: false,
    remarks: false,
    ..Entry::PLAIN
};

/// A writer of events.
pub(super) fn sink() -> Writing {
    Writing::default()
}

#[derive(Debug, Default)]
pub(super) struct Writing {
    text: Vec<u8>,
}

impl Sink for Writing {
    fn start(&mut self, _: &mut dyn Out) -> io::Result<()> {
        Ok(())
    }

    fn put(&mut self, out: &mut dyn Out, events: &[Event]) -> io::Result<()> {
        self.text.clear();
        for e in events {
            let (seconds, micros) = (e.t.0 / 1_000_000, e.t.0 % 1_000_000);
            decimal(&mut self.text, seconds);
            self.text.push(b'.');
            // Six digits with their zeros: those of a number that has seven, without its first.
            let point = self.text.len();
            decimal(&mut self.text, 1_000_000 + micros);
            self.text.remove(point);
            self.text.extend(b"000 ");
            decimal(&mut self.text, e.x.into());
            self.text.push(b' ');
            decimal(&mut self.text, e.y.into());
            self.text.extend([b' ', b'0' + e.polarity.bit(), b'\n']);
        }
        out.write_all(&self.text)
    }

    fn finish(&mut self, _: &mut dyn Out, _: &About) -> io::Result<()> {
        Ok(())
    }
}

/// Opens a file's stream of events.
pub(super) fn source(chunks: Chunks) -> Text<Txt> {
    Text::new(chunks, Txt)
}

/// Its lines need no state.
#[derive(Debug)]
pub(super) struct Txt;

impl Rows for Txt {
    fn row(&mut self, line: &Line<'_>) -> Result<Option<Raw>, Stop> {
        event(line).map(Some)
    }
}

fn event(line: &Line<'_>) -> Result<Raw, Stop> {
    let fields: Vec<&[u8]> = line
        .text
        .split(u8::is_ascii_whitespace)
        .filter(|field| !field.is_empty())
        .collect();
    let [t, x, y, p] = fields[..] else {
        let got = fields.len();
        if line.is_first() && got == 2 && fields.iter().all(|field| integer(field).is_some()) {
            return Err(line.stop(0, Fault::Size));
        }
        return Err(line.stop(0, Fault::Fields { want: 4, got }));
    };
    let whole = |name, field| {
        integer(field).or_else(|| float(field)).ok_or_else(|| {
            let found = shown(field);
            line.stop(line.column_of(field), Fault::NotInteger { name, found })
        })
    };
    Ok(Raw {
        t: micros(t).ok_or_else(|| {
            let found = shown(t);
            line.stop(line.column_of(t), Fault::NotSeconds { found })
        })?,
        x: whole("x", x)?,
        y: whole("y", y)?,
        p: whole("p", p)?,
        channel: 0,
    })
}

/// Parses a whole number that is written as floats are, as `numpy.savetxt` writes them.
fn float(text: &[u8]) -> Option<i128> {
    let number: f64 = std::str::from_utf8(text).ok()?.parse().ok()?;
    (number.fract() == 0.0 && number.abs() < 1e15).then_some(number as i128)
}

/// Parses decimal seconds, rounded to the nearest microsecond.
///
/// Done on the digits: a day in `f64` seconds is exact to less than a microsecond, a century
/// is not.
fn micros(text: &[u8]) -> Option<i128> {
    let text = std::str::from_utf8(text).ok()?;
    let (whole, fraction) = text.split_once('.').unwrap_or((text, ""));
    if !text.contains(['e', 'E']) && fraction.bytes().all(|b| b.is_ascii_digit()) {
        let mut sum = integer(whole.as_bytes())? * 1_000_000;
        let sign = if whole.starts_with('-') { -1 } else { 1 };
        let mut unit = 100_000;
        for digit in fraction.bytes().take(6) {
            sum += sign * unit * i128::from(digit - b'0');
            unit /= 10;
        }
        let up = fraction.as_bytes().get(6).is_some_and(|d| *d >= b'5');
        return Some(if up { sum + sign } else { sum });
    }
    // With an exponent, as numpy.savetxt writes it.
    let seconds: f64 = text.parse().ok()?;
    seconds.is_finite().then(|| (seconds * 1e6).round() as i128)
}
