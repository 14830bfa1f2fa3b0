//! The gate: checks that all formats share, between a file's events and the packet.

use super::{
    Fault, Format,
    about::{About, within_reach},
};
use crate::{
    event::{Event, Polarity},
    plane::Size,
    unit::Micros,
};

/// An event with fields as wide as a text or a table has them, before any check.
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

impl Raw {
    /// The event, if all fields are in range.
    pub fn event(self) -> Result<Event, Fault> {
        Ok(Event {
            t: time(self.t)?,
            x: within("x", self.x, u16::MAX)?,
            y: within("y", self.y, u16::MAX)?,
            polarity: match self.p {
                1 => Polarity::On,
                0 | -1 => Polarity::Off,
                found => return Err(Fault::Polarity { found }),
            },
            // One less than a byte holds, since their number is a byte too.
            channel: within("channel", self.channel, u8::MAX - 1)?,
        })
    }
}

/// The fields of an event in 64 bits, before any check.
#[derive(Clone, Copy, Debug)]
pub struct Numbers {
    /// Microseconds.
    pub t: i64,
    /// Column.
    pub x: i64,
    /// Row.
    pub y: i64,
    /// 1, 0 or -1.
    pub p: i64,
    /// Kind of cell.
    pub channel: i64,
}

impl Numbers {
    /// The event, if all fields are in range; [`Raw::event`] says which is not.
    #[inline]
    pub fn event(self) -> Option<Event> {
        // No branch on the sign: it is as often one as the other.
        if !(-1..=1).contains(&self.p) {
            return None;
        }
        Some(Event {
            t: Micros(self.t.try_into().ok()?),
            x: self.x.try_into().ok()?,
            y: self.y.try_into().ok()?,
            polarity: Polarity::of(self.p == 1),
            channel: { self.channel.try_into().ok() }.filter(|channel| *channel < u8::MAX)?,
        })
    }
}

/// Checks order, place and kind of events, and tracks their range.
#[derive(Clone, Debug)]
pub struct Gate {
    largest: (u16, u16),
    latest: u64,
    silence: u64,
    format: Option<Format>,
    /// Whether time may not run backwards.
    pub in_order: bool,
    /// What the file says about the sensor.
    pub about: About,
    /// Events so far.
    pub events: u64,
    /// Time of the first event, in any order of the earliest.
    pub first: Option<Micros>,
    /// Time of the last event, in any order of the latest; 0 before the first.
    pub last: Micros,
    /// The smallest sensor that holds the events so far.
    pub reach: Size,
    /// One more than the largest channel so far.
    pub channels: u8,
}

impl Gate {
    /// A gate for events that come out of a file.
    pub const fn reading() -> Self {
        Self {
            largest: (u16::MAX, u16::MAX),
            latest: i64::MAX.unsigned_abs(),
            silence: u64::MAX,
            format: None,
            in_order: true,
            about: About::NOTHING,
            events: 0,
            first: None,
            last: Micros(0),
            reach: Size::new(0, 0),
            channels: 1,
        }
    }

    /// A gate for events that go into a file of this format.
    pub fn writing(format: Format, about: About) -> Result<Self, Fault> {
        let limits = format.limits();
        if let Some(size) = about.size {
            within_reach(size)?;
            let (width, height) = (limits.x as usize + 1, limits.y as usize + 1);
            // Only what an address must reach counts where the format does not keep the size.
            if format.entry().few_bits_of_size && (size.width > width || size.height > height) {
                let most = Size { height, width };
                return Err(Fault::Large { size, most, format });
            }
        }
        match about.channels {
            Some(channels) if channels > 1 && !limits.channels => {
                return Err(Fault::NoChannels { channels, format });
            }
            _ => (),
        }
        Ok(Self {
            largest: (limits.x, limits.y),
            latest: limits.t,
            silence: limits.silence,
            format: Some(format),
            about,
            ..Self::reading()
        })
    }

    /// Checks the next events; the error has the index of the first bad one.
    pub fn admit(&mut self, events: &[Event]) -> Result<(), (usize, Fault)> {
        // First all at once, as they are almost always good; only then one by one.
        let mut last = self.before(events);
        let (mut x, mut y, mut channel, mut ordered, mut pause) = (0, 0, 0, true, 0);
        let (mut earliest, mut latest) = (u64::MAX, last);
        for e in events {
            (earliest, latest) = (earliest.min(e.t.0), latest.max(e.t.0));
            ordered &= e.t.0 >= last;
            pause = pause.max(e.t.0.wrapping_sub(last));
            last = e.t.0;
            x = x.max(e.x);
            y = y.max(e.y);
            channel = channel.max(e.channel);
        }
        let far = Event {
            t: Micros(latest),
            x,
            y,
            channel,
            polarity: Polarity::On,
        };
        let ordered = ordered || !self.in_order;
        if !ordered || pause > self.silence || (!events.is_empty() && self.fits(&far).is_err()) {
            let mut last = self.before(events);
            for (i, e) in events.iter().enumerate() {
                self.fits(e).map_err(|fault| (i, fault))?;
                self.follows(last, e.t.0).map_err(|fault| (i, fault))?;
                last = e.t.0;
            }
        }
        if !events.is_empty() {
            let first = self.first.map_or(earliest, |first| first.0.min(earliest));
            self.first = Some(Micros(first));
            self.last = Micros(latest);
            self.events += events.len() as u64;
            self.reach.height = self.reach.height.max(y as usize + 1);
            self.reach.width = self.reach.width.max(x as usize + 1);
            self.channels = self.channels.max(channel.saturating_add(1));
        }
        Ok(())
    }

    /// Times of the first and the last event.
    pub fn times(&self) -> Option<(Micros, Micros)> {
        self.first.map(|first| (first, self.last))
    }

    /// Checks the events against the remark, at the end of a file.
    pub fn complete(&self) -> Result<(), Fault> {
        let fault = self.about.disagreement(self.events, self.times());
        fault.map_or(Ok(()), Err)
    }

    /// The time before the next event.
    fn before(&self, events: &[Event]) -> u64 {
        match events.first() {
            // Its clock starts with the first event, and not at 0.
            Some(e)
                if self.events == 0 && self.format.is_some_and(|f| f.entry().clock_from_first) =>
            {
                e.t.0
            }
            _ => self.last.0,
        }
    }

    /// Checks that an event is on the sensor and in the format's range.
    fn fits(&self, event: &Event) -> Result<(), Fault> {
        let &Event { t, x, y, .. } = event;
        time(t.0.into())?;
        within("x", x.into(), self.largest.0)?;
        within("y", y.into(), self.largest.1)?;
        if let Some(format) = self.format.filter(|_| t.0 > self.latest) {
            let (t, limit) = (t.0, self.latest);
            return Err(Fault::Late { t, limit, format });
        }
        on_sensor(event, self.about.size, self.about.channels)
    }

    /// Checks the order, and the silence, between an event at `last` and one at `now`.
    fn follows(&self, last: u64, now: u64) -> Result<(), Fault> {
        if now < last && self.in_order {
            return Err(Fault::Backwards { before: last, now });
        }
        match self.format {
            Some(format) if now - last > self.silence => Err(Fault::Silence {
                from: last,
                to: now,
                limit: self.silence,
                format,
            }),
            _ => Ok(()),
        }
    }
}

/// Checks that a file has the column of kinds that its remark speaks of.
pub fn hold_kinds(about: Option<&About>, column: bool) -> Result<(), Fault> {
    match about.and_then(|about| about.channels) {
        Some(kinds) if kinds > 1 && !column => Err(Fault::Remark {
            stated: format!("{kinds} channels"),
            found: "no column `channel`".into(),
        }),
        _ => Ok(()),
    }
}

/// A time in the range that files hold, 63 bits.
fn time(t: i128) -> Result<Micros, Fault> {
    match i64::try_from(t).map(u64::try_from) {
        Ok(Ok(t)) => Ok(Micros(t)),
        _ => Err(Fault::Time { t }),
    }
}

/// Checks that a number is from 0 to `limit`.
pub fn within<T>(name: &'static str, value: i128, limit: T) -> Result<T, Fault>
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
        // One less than a byte holds, since their number is a byte too.
        None if channel == u8::MAX => Err(Fault::Range {
            name: "channel",
            value: channel.into(),
            limit: (u8::MAX - 1).into(),
        }),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn event(t: u64, x: u16, y: u16) -> Event {
        Event {
            t: Micros(t),
            x,
            y,
            polarity: Polarity::On,
            channel: 0,
        }
    }

    #[test]
    fn the_first_bad_event_is_named_whatever_is_wrong() {
        let about = About {
            size: Some(Size::new(5, 10)),
            channels: Some(1),
            ..About::NOTHING
        };
        let mut gate = Gate::writing(Format::Csv, about).unwrap();
        gate.admit(&[event(3, 9, 4), event(3, 0, 0)]).unwrap();
        assert_eq!((gate.events, gate.reach), (2, Size::new(5, 10)));
        let at = |events: &[Event]| gate.clone().admit(events).unwrap_err().0;
        assert_eq!(
            at(&[event(2, 0, 0)]),
            0,
            "before the last one of the block before"
        );
        assert_eq!(at(&[event(4, 0, 0), event(3, 0, 0), event(9, 0, 9)]), 1);
        assert_eq!(at(&[event(4, 0, 0), event(5, 0, 5), event(3, 0, 0)]), 1);
        assert_eq!(at(&[event(4, 0, 0), event(u64::MAX, 0, 0)]), 1);
    }

    #[test]
    fn formats_have_their_limits() {
        let about = |width, channels| About {
            size: Some(Size::new(480, width)),
            channels: Some(channels),
            ..About::NOTHING
        };
        assert!(Gate::writing(Format::Evt3, about(2048, 1)).is_ok());
        assert!(matches!(
            Gate::writing(Format::Evt3, about(2049, 1)),
            Err(Fault::Large { .. })
        ));
        assert!(matches!(
            Gate::writing(Format::Dat, about(640, 2)),
            Err(Fault::NoChannels { channels: 2, .. })
        ));
        let mut es = Gate::writing(Format::Es, about(640, 1)).unwrap();
        let limit = u64::from(u32::MAX);
        es.admit(&[event(limit, 0, 0)]).unwrap();
        assert!(es.admit(&[event(limit * 2 + 1, 0, 0)]).is_err());
        let mut dat = Gate::writing(Format::Dat, about(640, 1)).unwrap();
        assert!(matches!(
            dat.admit(&[event(1 << 32, 0, 0)]),
            Err((0, Fault::Late { .. }))
        ));
    }
}
