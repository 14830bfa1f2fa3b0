//! Notes in order of time: those of some bands, and those of all.

use std::ops::Range;

use multiversion::multiversion;

use super::{packed_event::PackedEvent, part::Part};

/// The notes of neighbouring bands by microsecond; those of one stay in the order in which they
/// were told.
#[derive(Clone, Debug, Default)]
pub(super) struct Sorted {
    /// The buffer is longer.
    packed: Vec<PackedEvent>,
    /// Where the notes of each microsecond end.
    ends: Vec<u32>,
}

impl Sorted {
    /// Sorts by counting what was told within so many microseconds.
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
        // With each note in its place, the next of its microsecond comes after it.
        for part in parts {
            for packed in part.packed() {
                let place = &mut next[packed.since() as usize];
                out[*place as usize] = *packed;
                *place += 1;
            }
        }
    }

    /// All notes.
    pub(super) fn packed(&self) -> &[PackedEvent] {
        &self.packed[self.within(0..self.ends.len())]
    }

    /// Where the notes of some microseconds are.
    pub(super) fn within(&self, microseconds: Range<usize>) -> Range<usize> {
        let end_before = |t: usize| t.checked_sub(1).map_or(0, |last| self.ends[last] as usize);
        end_before(microseconds.start)..end_before(microseconds.end)
    }
}

/// Notes that are copied at a time, whether there are as many or fewer.
const RUN: usize = 16;

/// Lays out the notes of all groups within some microseconds: for each microsecond those of one
/// group after those of the other.
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
                // As good as always: no branch depends on how many there are.
                (Some(out), Some(packed)) if run <= RUN => *out = *packed,
                _ => copy(&mut out[..run], &packed[..run]),
            }
            len += run;
            *from = end;
        }
    }
}

/// Copies a run that is rarely so long: apart, or the others would be copied by a call too.
#[cold]
#[inline(never)]
fn copy(to: &mut [PackedEvent], from: &[PackedEvent]) {
    to.copy_from_slice(from);
}
