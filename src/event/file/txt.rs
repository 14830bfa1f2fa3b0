//! Plain text as in the Event Camera Dataset (Mueggler et al. 2017, `events.txt`): one event
//! a line, `t x y p`, time in seconds.
//!
//! Written with nine decimals, because readers that truncate (evlib) would otherwise lose a
//! microsecond. Read to the nearest microsecond. There is no place for a channel.

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
    for e in &packet.events {
        let (seconds, micros) = (e.t.0 / 1_000_000, e.t.0 % 1_000_000);
        writeln!(
            out,
            "{seconds}.{micros:06}000 {} {} {}",
            e.x,
            e.y,
            e.polarity.bit()
        )?;
    }
    Ok(())
}

/// Reads the events.
pub(super) fn read(input: &mut dyn BufRead) -> Result<Loaded, Stop> {
    let mut lines = Lines::new(input);
    let mut intake = Intake::new();
    while let Some(line) = lines.next()? {
        if let Some(comment) = line.comment() {
            let about = About::parse(&comment).map_err(|fault| line.stop(0, fault))?;
            if let Some(about) = about {
                intake.declare(about).map_err(|fault| line.stop(0, fault))?;
            }
            continue;
        }
        let raw = event(&line)?;
        intake.take(raw).map_err(|fault| line.stop(0, fault))?;
    }
    Ok(intake.finish())
}

fn event(line: &Line<'_>) -> Result<Raw, Stop> {
    let fields: Vec<&[u8]> = line
        .text
        .split(u8::is_ascii_whitespace)
        .filter(|field| !field.is_empty())
        .collect();
    let [t, x, y, p] = fields[..] else {
        let got = fields.len();
        return Err(line.stop(0, Fault::Fields { want: 4, got }));
    };
    let whole = |name, field| {
        integer(field).ok_or_else(|| {
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

/// Decimal seconds as the nearest microsecond.
///
/// Done on the digits: a day in `f64` seconds is exact to less than a microsecond, a century
/// is not.
fn micros(text: &[u8]) -> Option<i128> {
    let text = std::str::from_utf8(text).ok()?;
    let (whole, fraction) = text.split_once('.').unwrap_or((text, ""));
    if fraction.bytes().all(|b| b.is_ascii_digit()) {
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
