//! Events as records of numpy: the bytes of a `.npy` of events, without its header.

use amacrine::event::Event;
use rayon::prelude::*;

/// Bytes of `t`, `x`, `y`, `p`.
const PLAIN: usize = 13;

/// Records that a thread writes at a time.
const BLOCK: usize = 1 << 14;

/// Appends the records of some events; of several kinds of cells each has a `channel`.
pub fn append(events: &[Event], channels: u8, bytes: &mut Vec<u8>) {
    let several = channels > 1;
    let width = PLAIN + usize::from(several);
    let start = bytes.len();
    bytes.resize(start + width * events.len(), 0);
    let blocks = bytes[start..].par_chunks_mut(width * BLOCK);
    blocks
        .zip(events.par_chunks(BLOCK))
        .for_each(|(bytes, events)| {
            if several {
                let records = bytes.as_chunks_mut::<{ PLAIN + 1 }>().0;
                for (record, event) in records.iter_mut().zip(events) {
                    if let Some((plain, [channel])) = record.split_first_chunk_mut() {
                        put(plain, event);
                        *channel = event.channel;
                    }
                }
            } else {
                let records = bytes.as_chunks_mut().0;
                for (record, event) in records.iter_mut().zip(events) {
                    put(record, event);
                }
            }
        });
}

fn put(record: &mut [u8; PLAIN], event: &Event) {
    record[..8].copy_from_slice(&event.t.0.to_le_bytes());
    record[8..10].copy_from_slice(&event.x.to_le_bytes());
    record[10..12].copy_from_slice(&event.y.to_le_bytes());
    record[12] = event.polarity.bit();
}
