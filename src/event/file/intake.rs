//! Where events from outside become a packet: every rule that all formats share, once.

use super::{
    Fault, Format, Loaded,
    about::{About, within_reach},
};
use crate::{
    event::{Event, Packet, Polarity},
    plane::Size,
    unit::Micros,
};

/// An event as a file has it, before anything about it is believed.
#[derive(Clone, Copy, Debug, Default)]
pub struct Raw {
    /// Microseconds.
    pub t: i128,
    /// Column.
    pub x: i128,
    /// Row.
    pub y: i128,
    /// 1, 0 or -1.
    pub p: i128,
    /// Kind of cell.
    pub channel: i128,
}

/// A packet in the making.
#[derive(Debug)]
pub struct Intake {
    about: Option<About>,
    events: Vec<Event>,
    /// The smallest sensor that holds the events so far.
    reach: Size,
    /// One more than the largest channel so far.
    channels: u8,
}

impl Intake {
    /// Nothing yet.
    pub fn new() -> Self {
        Self {
            about: None,
            events: Vec::new(),
            reach: Size::new(0, 0),
            channels: 1,
        }
    }

    /// What the file says of itself; once, and before the first event.
    pub fn declare(&mut self, about: About) -> Result<(), Fault> {
        if self.about.is_some() || !self.events.is_empty() {
            return Err(Fault::About {
                why: "comes twice, or after the first event".into(),
            });
        }
        self.about = Some(about);
        Ok(())
    }

    /// The next event.
    pub fn take(&mut self, raw: Raw) -> Result<(), Fault> {
        let event = Event {
            t: time(raw.t)?,
            x: within("x", raw.x, u16::MAX)?,
            y: within("y", raw.y, u16::MAX)?,
            polarity: match raw.p {
                1 => Polarity::On,
                0 | -1 => Polarity::Off,
                found => return Err(Fault::Polarity { found }),
            },
            // One less than a byte holds, since their number is a byte too.
            channel: within("channel", raw.channel, u8::MAX - 1)?,
        };
        if let Some(last) = self.events.last() {
            in_order(last, &event)?;
        }
        let about = self.about.unwrap_or_default();
        on_sensor(&event, about.size, about.channels)?;
        self.reach.height = self.reach.height.max(event.y as usize + 1);
        self.reach.width = self.reach.width.max(event.x as usize + 1);
        self.channels = self.channels.max(event.channel + 1);
        self.events.push(event);
        Ok(())
    }

    /// The packet.
    pub fn finish(self) -> Loaded {
        let about = self.about.unwrap_or_default();
        let ends = self.events.first().zip(self.events.last());
        Loaded {
            size_known: about.size.is_some(),
            channels_known: about.channels.is_some(),
            packet: Packet {
                size: about.size.unwrap_or(self.reach),
                channels: about.channels.unwrap_or(self.channels),
                span: about
                    .span
                    .or(ends.map(|(a, b)| (a.t, b.t)))
                    .unwrap_or_default(),
                dropped: about.dropped.unwrap_or_default(),
                events: self.events,
            },
        }
    }
}

/// Whether `format` can hold `packet`; where not, the number of the first event that it cannot.
pub fn check(packet: &Packet, format: Format) -> Result<(), (usize, Fault)> {
    let largest = match format {
        Format::Csv | Format::Txt => u16::MAX,
        Format::Npy => super::npy::LARGEST,
    };
    within_reach(packet.size).map_err(|fault| (0, fault))?;
    if format == Format::Txt && packet.channels > 1 {
        let channels = packet.channels;
        return Err((0, Fault::NoChannels { channels, format }));
    }
    let mut last = None;
    for (i, event) in packet.events.iter().enumerate() {
        let checked = || {
            time(event.t.0.into())?;
            within("x", event.x.into(), largest)?;
            within("y", event.y.into(), largest)?;
            on_sensor(event, Some(packet.size), Some(packet.channels))?;
            last.map_or(Ok(()), |last| in_order(last, event))
        };
        checked().map_err(|fault| (i, fault))?;
        last = Some(event);
    }
    Ok(())
}

/// Files hold time in 64 bits with a sign.
fn time(t: i128) -> Result<Micros, Fault> {
    match i64::try_from(t).map(u64::try_from) {
        Ok(Ok(t)) => Ok(Micros(t)),
        _ => Err(Fault::Time { t }),
    }
}

/// A number from 0 to `limit`.
fn within<T>(name: &'static str, value: i128, limit: T) -> Result<T, Fault>
where
    T: TryFrom<i128> + PartialOrd + Into<u64> + Copy,
{
    T::try_from(value)
        .ok()
        .filter(|v| *v <= limit)
        .ok_or(Fault::Range {
            name,
            value,
            limit: limit.into(),
        })
}

fn in_order(last: &Event, event: &Event) -> Result<(), Fault> {
    if event.t < last.t {
        return Err(Fault::Backwards {
            before: last.t.0,
            now: event.t.0,
        });
    }
    Ok(())
}

fn on_sensor(event: &Event, size: Option<Size>, channels: Option<u8>) -> Result<(), Fault> {
    let &Event { x, y, channel, .. } = event;
    match size {
        Some(size) if x as usize >= size.width || y as usize >= size.height => {
            return Err(Fault::Outside { x, y, size });
        }
        _ => (),
    }
    match channels {
        Some(channels) if channel >= channels => Err(Fault::Channel { channel, channels }),
        _ => Ok(()),
    }
}
