//! Events as records of numpy: the bytes of a `.npy` of events, without its header.

use amacrine::{
    event::{Event, Polarity},
    plane::Size,
    unit::Micros,
};
use rayon::prelude::*;

/// Bytes of `t`, `x`, `y`, `p`.
const PLAIN: usize = 13;

/// Bytes of those and `channel`, of several kinds of cells.
const OF_KINDS: usize = PLAIN + 1;

/// Records that a thread writes at a time.
const BLOCK: usize = 1 << 14;

/// Bytes that are stored at once: a record, and what the next one overwrites.
const STORE: usize = 16;

/// Bytes of a record; of several kinds of cells it has a `channel`.
pub const fn width(channels: u8) -> usize {
    if channels > 1 { OF_KINDS } else { PLAIN }
}

/// Appends the records of some events; of several kinds of cells each has a `channel`.
pub fn append(events: &[Event], channels: u8, bytes: &mut Vec<u8>) {
    if channels > 1 {
        append_records::<OF_KINDS>(events, bytes);
    } else {
        append_records::<PLAIN>(events, bytes);
    }
}

/// Gives records of one kind of cells a `channel`, which is 0.
pub fn widen(bytes: &mut Vec<u8>) {
    let mut wide = Vec::with_capacity(bytes.len() / PLAIN * OF_KINDS);
    for record in bytes.as_chunks::<PLAIN>().0 {
        wide.extend_from_slice(record);
        wide.push(0);
    }
    *bytes = wide;
}

fn append_records<const WIDTH: usize>(events: &[Event], bytes: &mut Vec<u8>) {
    let start = bytes.len();
    bytes.resize(start + WIDTH * events.len(), 0);
    let blocks = bytes[start..].par_chunks_mut(WIDTH * BLOCK);
    blocks
        .zip(events.par_chunks(BLOCK))
        .for_each(|(bytes, events)| put_all::<WIDTH>(bytes, events));
}

fn put_all<const WIDTH: usize>(bytes: &mut [u8], events: &[Event]) {
    let Some((last, before)) = events.split_last() else {
        return;
    };
    let mut at = 0;
    for event in before {
        if let Some(place) = bytes.get_mut(at..).and_then(<[u8]>::first_chunk_mut) {
            *place = record(event);
        }
        at += WIDTH;
    }
    if let Some(place) = bytes.get_mut(at..at + WIDTH) {
        place.copy_from_slice(&record(last)[..WIDTH]);
    }
}

/// A record, and what stands behind it.
#[inline]
fn record(event: &Event) -> [u8; STORE] {
    let place = u128::from(event.x) << 64 | u128::from(event.y) << 80;
    let kind = u128::from(event.polarity.bit()) << 96 | u128::from(event.channel) << 104;
    (u128::from(event.t.0) | place | kind).to_le_bytes()
}

/// How records lie that come from numpy.
#[derive(Clone, Copy, Debug)]
pub struct Layout {
    /// Whether each has a `channel`.
    pub has_channels: bool,
    /// Whether its column and row have a sign.
    pub signed: bool,
}

/// What all events of some records are like.
#[derive(Clone, Copy, Debug)]
pub struct Scan {
    /// How many there are.
    pub events: usize,
    /// Times of the first and of the last one.
    pub span: (Micros, Micros),
    /// The latest time, in microseconds.
    pub latest: u64,
    /// The smallest sensor that holds them.
    pub reach: Size,
    /// One more than their largest channel.
    pub kinds: u8,
    /// The number of the first that is earlier than the one before it.
    pub backwards: Option<usize>,
}

impl Layout {
    /// Bytes of a record.
    pub const fn width(self) -> usize {
        if self.has_channels { OF_KINDS } else { PLAIN }
    }

    /// Looks through records; `None` where one is no event: a time, or a place that has a sign, below
    /// 0, a sign that is not 1, 0 or -1, or a channel of 255.
    pub fn scan(self, bytes: &[u8]) -> Option<Scan> {
        if self.has_channels {
            scan::<OF_KINDS>(bytes, self.signed)
        } else {
            scan::<PLAIN>(bytes, self.signed)
        }
    }

    /// The events of records that were looked through.
    pub fn parse(self, bytes: &[u8]) -> Vec<Event> {
        if self.has_channels {
            parse::<OF_KINDS>(bytes)
        } else {
            parse::<PLAIN>(bytes)
        }
    }
}

/// A record in one number, as [`record`] makes it.
#[inline]
fn wide<const WIDTH: usize>(record: &[u8; WIDTH]) -> u128 {
    // The time, and what is behind it: two numbers that overlap.
    let half = |bytes: Option<&[u8; 8]>| u64::from_le_bytes(*bytes.unwrap_or(&[0; 8]));
    let behind = half(record.last_chunk()) >> (8 * (STORE - WIDTH));
    u128::from(half(record.first_chunk())) | u128::from(behind) << 64
}

fn scan<const WIDTH: usize>(bytes: &[u8], signed: bool) -> Option<Scan> {
    let records = bytes.as_chunks::<WIDTH>().0;
    let (mut x, mut y, mut channel) = (0, 0, 0);
    let (mut good, mut ordered) = (true, true);
    let (mut last, mut latest) = (0, 0);
    for record in records {
        let wide = wide(record);
        let (t, sign) = (wide as u64, (wide >> 96) as u8);
        x = x.max((wide >> 64) as u16);
        y = y.max((wide >> 80) as u16);
        channel = channel.max((wide >> 104) as u8);
        // 255 is -1.
        good &= sign.wrapping_add(1) <= 2;
        ordered &= t >= last;
        latest = latest.max(t);
        last = t;
    }
    let most = if signed {
        i16::MAX.unsigned_abs()
    } else {
        u16::MAX
    };
    if !good || x.max(y) > most || channel == u8::MAX || i64::try_from(latest).is_err() {
        return None;
    }
    let time = |record: &[u8; WIDTH]| Micros(wide(record) as u64);
    let earlier = |pair: &[[u8; WIDTH]]| matches!(pair, [a, b] if time(b) < time(a));
    let backwards = if ordered {
        None
    } else {
        records.windows(2).position(earlier)
    };
    let some = usize::from(!records.is_empty());
    Some(Scan {
        events: records.len(),
        span: records
            .first()
            .map(time)
            .zip(records.last().map(time))
            .unwrap_or_default(),
        latest,
        reach: Size::new(usize::from(y) + some, usize::from(x) + some),
        kinds: channel + 1,
        backwards: backwards.map(|before| before + 1),
    })
}

fn parse<const WIDTH: usize>(bytes: &[u8]) -> Vec<Event> {
    let records = bytes.as_chunks::<WIDTH>().0.iter();
    let events = records.map(|record| {
        let wide = wide(record);
        Event {
            t: Micros(wide as u64),
            x: (wide >> 64) as u16,
            y: (wide >> 80) as u16,
            polarity: Polarity::of((wide >> 96) as u8 == 1),
            channel: (wide >> 104) as u8,
        }
    });
    events.collect()
}
