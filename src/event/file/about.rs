//! The remark that a file of this program has about its packet: one comment beside the events.
//!
//! `amacrine size=346x260 channels=2 span=0..2000000 dropped=0,0 events=40000 times=12..1999950`
//! Times are in microseconds. `names=change,centre-on` may follow the channels: what each is called.
//! `dropped` counts events without a slot and over the limit and, if there are any, those lost to a
//! full queue and those merged. The last two are written when the file is whole: how many events it
//! has, and when the first and the last were. Each part may be left out. What is there must be true
//! of the file, see [`About::disagreement`].

use std::{fmt, fmt::Write as _, str::FromStr};

use super::Fault;
use crate::{
    event::{Dropped, Packet},
    plane::Size,
    unit::{self, Micros},
};

/// The word that the comment starts with.
pub(super) const NAME: &str = "amacrine";

/// The largest side of a sensor that 16-bit addresses reach.
const LARGEST_SIDE: usize = 1 << 16;

/// What the comment says.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct About {
    /// Size of the sensor.
    pub size: Option<Size>,
    /// Kinds of cells.
    pub channels: Option<u8>,
    /// What each kind is called; empty where the file does not say so.
    pub names: Vec<String>,
    /// Time span that was watched.
    pub span: Option<(Micros, Micros)>,
    /// Events that the sensor made and could not deliver.
    pub dropped: Option<Dropped>,
    /// How many events the file has.
    pub events: Option<u64>,
    /// Times of its first and its last event.
    pub times: Option<(Micros, Micros)>,
}

/// The length of the longest tail, the number of events and their times, in columns.
const TAIL: usize =
    " events=18446744073709551615 times=18446744073709551615..18446744073709551615".len();

/// Blanks for what is not known yet, in a remark that is written before the events.
pub(super) const BLANK: &str = match str::from_utf8(&[b' '; TAIL]) {
    Ok(blank) => blank,
    Err(_) => "",
};

impl About {
    /// The remark of a file that says nothing.
    pub const NOTHING: Self = Self {
        size: None,
        channels: None,
        names: Vec::new(),
        span: None,
        dropped: None,
        events: None,
        times: None,
    };

    /// All of a packet but its events.
    #[must_use]
    pub fn from_packet(packet: &Packet) -> Self {
        Self {
            size: Some(packet.size),
            channels: Some(packet.channels),
            names: packet.names.clone(),
            span: Some(packet.span),
            dropped: Some(packet.dropped),
            ..Self::NOTHING
        }
    }

    /// The remark in so many columns, blanks at the end; without what there is no room for, the
    /// last first.
    pub(super) fn within(self, columns: usize) -> String {
        let mut about = self;
        let drops: [fn(&mut Self); 5] = [
            |about| about.names.clear(),
            |about| about.times = None,
            |about| about.events = None,
            |about| about.dropped = None,
            |about| about.span = None,
        ];
        for drop in drops {
            if about.to_string().len() <= columns {
                break;
            }
            drop(&mut about);
        }
        let remark = about.to_string();
        format!("{remark:columns$}")
    }

    /// The first statement of the remark that the events contradict.
    pub(super) fn disagreement(
        &self,
        events: u64,
        times: Option<(Micros, Micros)>,
    ) -> Option<Fault> {
        let differ = |stated, found| Some(Fault::Remark { stated, found });
        if let Some(stated) = self.events.filter(|stated| *stated != events) {
            return differ(counted(stated), counted(events));
        }
        match (self.times, times) {
            (Some(stated), found) if Some(stated) != found => {
                let found = found.map_or_else(|| counted(0), ends);
                differ(ends(stated), found)
            }
            _ => None,
        }
    }

    /// Parses a comment (without its `#`); `None` when it is not a remark of this program.
    pub(super) fn parse(comment: &str) -> Result<Option<Self>, Fault> {
        let mut words = comment.split_ascii_whitespace();
        if words.next() != Some(NAME) {
            return Ok(None);
        }
        let mut about = Self::default();
        for word in words {
            about.read(word).ok_or_else(|| Fault::About {
                why: format!("has a part that cannot be read: `{word}`"),
            })?;
        }
        if let Some(size) = about.size {
            within_reach(size)?;
        }
        let kinds = about.channels.map_or(0, usize::from);
        if !about.names.is_empty() && about.names.len() != kinds {
            return Err(Fault::About {
                why: format!(
                    "names {} of cells of {kinds}",
                    crate::unit::counted(about.names.len(), "kind")
                ),
            });
        }
        Ok(Some(about))
    }

    /// One `key=value`.
    fn read(&mut self, word: &str) -> Option<()> {
        let (key, value) = word.split_once('=')?;
        match key {
            "size" if self.size.is_none() => {
                let (width, height) = two(value, "x")?;
                self.size = Some(Size { height, width });
            }
            "channels" if self.channels.is_none() => self.channels = Some(value.parse().ok()?),
            "names" if self.names.is_empty() => {
                let names = value.split(',').map(named);
                self.names = names.collect::<Option<_>>()?;
            }
            "span" if self.span.is_none() => {
                let (from, to) = two(value, "..")?;
                self.span = Some((Micros(from), Micros(to)));
            }
            "dropped" if self.dropped.is_none() => self.dropped = Some(dropped(value)?),
            "events" if self.events.is_none() => self.events = Some(value.parse().ok()?),
            "times" if self.times.is_none() => {
                let (first, last) = two(value, "..")?;
                self.times = Some((Micros(first), Micros(last)));
            }
            _ => return None,
        }
        Some(())
    }
}

/// The most bytes of a name in a remark.
const NAME_BYTES: usize = 64;

/// A name as it stands in a remark: letters and digits as they are, all else as `%` and two digits.
fn unnamed(name: &str) -> String {
    let mut word = String::new();
    for byte in name.bytes().take(NAME_BYTES) {
        if byte.is_ascii_alphanumeric() || matches!(byte, b'-' | b'_' | b'.') {
            word.push(byte.into());
        } else {
            // Writing to a string cannot fail.
            let _ = write!(word, "%{byte:02x}");
        }
    }
    word
}

/// The name that a word of a remark stands for. What was cut within a letter ends before it.
fn named(word: &str) -> Option<String> {
    let mut bytes = Vec::new();
    let mut rest = word.bytes();
    while let Some(byte) = rest.next() {
        if byte == b'%' {
            let digits = [rest.next()?, rest.next()?];
            let digits = str::from_utf8(&digits).ok()?;
            bytes.push(u8::from_str_radix(digits, 16).ok()?);
        } else {
            bytes.push(byte);
        }
    }
    let whole = match str::from_utf8(&bytes) {
        Ok(name) => name,
        Err(cut) => str::from_utf8(bytes.get(..cut.valid_up_to())?).ok()?,
    };
    Some(whole.to_owned())
}

/// A number of events in words.
fn counted(events: u64) -> String {
    match events {
        0 => "no event".into(),
        more => unit::counted(more, "event"),
    }
}

/// The times of the first and the last event in words.
fn ends((first, last): (Micros, Micros)) -> String {
    format!(
        "a first event at {} us and a last at {} us",
        first.0, last.0
    )
}

/// Two, four or five numbers: what only a readout drops may be left out.
fn dropped(text: &str) -> Option<Dropped> {
    let counts: Result<Vec<u64>, _> = text.split(',').map(str::parse).collect();
    let (no_slot, over_limit, queue_full, merged, unscanned) = match counts.ok()?[..] {
        [a, b] => (a, b, 0, 0, 0),
        [a, b, c, d] => (a, b, c, d, 0),
        [a, b, c, d, e] => (a, b, c, d, e),
        _ => return None,
    };
    Some(Dropped {
        no_slot,
        over_limit,
        queue_full,
        merged,
        unscanned,
    })
}

/// Two numbers with `between` in between.
fn two<T: FromStr>(text: &str, between: &str) -> Option<(T, T)> {
    let (a, b) = text.split_once(between)?;
    Some((a.parse().ok()?, b.parse().ok()?))
}

/// Checks that 16-bit addresses reach all pixels of a sensor.
pub(super) fn within_reach(size: Size) -> Result<(), Fault> {
    if size.height > LARGEST_SIDE || size.width > LARGEST_SIDE {
        return Err(Fault::SizeLimit { size });
    }
    Ok(())
}

impl fmt::Display for About {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(NAME)?;
        if let Some(size) = self.size {
            write!(f, " size={size}")?;
        }
        if let Some(channels) = self.channels {
            write!(f, " channels={channels}")?;
        }
        if !self.names.is_empty() {
            let names: Vec<String> = self.names.iter().map(|name| unnamed(name)).collect();
            write!(f, " names={}", names.join(","))?;
        }
        if let Some((from, to)) = self.span {
            write!(f, " span={}..{}", from.0, to.0)?;
        }
        if let Some(d) = self.dropped {
            write!(f, " dropped={},{}", d.no_slot, d.over_limit)?;
            if (d.queue_full, d.merged, d.unscanned) != (0, 0, 0) {
                write!(f, ",{},{}", d.queue_full, d.merged)?;
            }
            if d.unscanned != 0 {
                write!(f, ",{}", d.unscanned)?;
            }
        }
        if let Some(events) = self.events {
            write!(f, " events={events}")?;
        }
        if let Some((first, last)) = self.times {
            write!(f, " times={}..{}", first.0, last.0)?;
        }
        Ok(())
    }
}
