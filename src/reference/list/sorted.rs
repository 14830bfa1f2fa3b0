//! Packed events in order of time, by a counting sort, and their merge.

use std::ops::Range;

use multiversion::multiversion;

use super::{packed_event::PackedEvent, part::Part};

/// The packed events of neighbouring bands by microsecond; those of one microsecond stay in the
/// order in which they came.
#[derive(Clone, Debug, Default)]
pub(super) struct Sorted {
    /// The sorted events; the buffer is longer.
    packed: Vec<PackedEvent>,
    /// The end of each microsecond's events.
    ends: Vec<u32>,
}

impl Sorted {
    /// Counting sort of the events of `parts`, which lie within so many microseconds.
    pub(super) fn sort(&mut self, parts: &[Part], microseconds: usize) {
        let total = parts.iter().map(|part| part.packed().len()).sum();
        if self.packed.len() < total {
            self.packed.resize(total, PackedEvent::default());
        }
        let (out, next) = (&mut self.packed[..total], &mut self.ends);
        next.clear();
        next.resize(microseconds, 0);
        for part in parts {
            for packed in part.packed() {
                next[packed.since() as usize] += 1;
            }
        }
        let mut sum = 0;
        for place in &mut *next {
            sum += std::mem::replace(place, sum);
        }
        // Each event moves the place of the next one of its microsecond.
        for part in parts {
            for packed in part.packed() {
                let place = &mut next[packed.since() as usize];
                out[*place as usize] = *packed;
                *place += 1;
            }
        }
    }

    /// All events.
    pub(super) fn packed(&self) -> &[PackedEvent] {
        &self.packed[self.within(0..self.ends.len())]
    }

    /// The indices of the events of some microseconds.
    pub(super) fn within(&self, microseconds: Range<usize>) -> Range<usize> {
        let end_before = |t: usize| t.checked_sub(1).map_or(0, |last| self.ends[last] as usize);
        end_before(microseconds.start)..end_before(microseconds.end)
    }
}

/// Events that are copied at a time, however many there are.
const RUN: usize = 16;

/// Merges the events of all groups within some microseconds: in each microsecond one group after
/// the other.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
pub(super) fn merge(groups: &[Sorted], microseconds: Range<usize>, out: &mut [PackedEvent]) {
    let starts = |group: &Sorted| group.within(microseconds.clone()).start;
    let mut from: Vec<usize> = groups.iter().map(starts).collect();
    let mut len = 0;
    for microsecond in microseconds {
        for (group, from) in groups.iter().zip(&mut from) {
            let end = group.ends[microsecond] as usize;
            let run = end - *from;
            let (out, packed) = (&mut out[len..], &group.packed[*from..]);
            match (out.first_chunk_mut::<RUN>(), packed.first_chunk()) {
                // Nearly always right, and no branch then depends on how many there are.
                (Some(out), Some(packed)) if run <= RUN => *out = *packed,
                _ => copy(&mut out[..run], &packed[..run]),
            }
            len += run;
            *from = end;
        }
    }
}

/// Copies a long run. It is a function of its own so that short ones are not copied by a call.
#[cold]
#[inline(never)]
fn copy(to: &mut [PackedEvent], from: &[PackedEvent]) {
    to.copy_from_slice(from);
}
