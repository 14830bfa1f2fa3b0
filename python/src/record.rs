//! Events as records of numpy: the bytes of a `.npy` of events, without its header.

use amacrine::event::Event;
use rayon::prelude::*;

/// Bytes of `t`, `x`, `y`, `p`; of several kinds of cells one more, `channel`.
const PLAIN: usize = 13;

/// Records that a thread writes at a time.
const BLOCK: usize = 1 << 14;

/// Bytes that are stored at once: a record, and what the next one overwrites.
const STORE: usize = 16;

/// Appends the records of some events; of several kinds of cells each has a `channel`.
pub fn append(events: &[Event], channels: u8, bytes: &mut Vec<u8>) {
    if channels > 1 {
        append_records::<{ PLAIN + 1 }>(events, bytes);
    } else {
        append_records::<PLAIN>(events, bytes);
    }
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
        if let Some(place) = bytes.get_mut(at..at + STORE) {
            place.copy_from_slice(&record(event));
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
