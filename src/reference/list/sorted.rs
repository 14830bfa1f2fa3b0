//! Packed events in order of time, by stable counting sorts.

use super::{packed_event::PackedEvent, part::Part};

/// Sorts the events of some runs, whose times lie in `since..since + microseconds`, and writes what
/// `to` makes of each to `out`; those of one microsecond stay in the order in which they came.
/// `next` is a buffer.
pub(super) fn sort<'a, T>(
    runs: impl Iterator<Item = &'a [PackedEvent]> + Clone,
    since: usize,
    microseconds: usize,
    next: &mut Vec<u32>,
    out: &mut [T],
    to: impl Fn(PackedEvent) -> T,
) {
    next.clear();
    next.resize(microseconds, 0);
    for packed in runs.clone().flatten() {
        next[packed.since() as usize - since] += 1;
    }
    starts(next);
    // Each event moves the place of the next one of its microsecond.
    for packed in runs.flatten() {
        let place = &mut next[packed.since() as usize - since];
        out[*place as usize] = to(*packed);
        *place += 1;
    }
}

/// Makes of numbers the sums of those before them.
fn starts(numbers: &mut [u32]) {
    let mut sum = 0;
    for number in numbers {
        sum += std::mem::replace(number, sum);
    }
}

/// The packed events of neighbouring bands by slice of time; those of one slice stay in the order
/// in which they came.
#[derive(Clone, Debug, Default)]
pub(super) struct Sliced {
    /// The events; the buffer is longer.
    packed: Vec<PackedEvent>,
    /// The end of each slice's events.
    ends: Vec<u32>,
}

impl Sliced {
    /// Sorts the events of `parts` into so many slices of 2^`shift` microseconds each.
    pub(super) fn sort(&mut self, parts: &[Part], slices: usize, shift: u32) {
        let total = parts.iter().map(|part| part.packed().len()).sum();
        if self.packed.len() < total {
            self.packed.resize(total, PackedEvent::default());
        }
        let (out, next) = (&mut self.packed[..total], &mut self.ends);
        next.clear();
        next.resize(slices, 0);
        let slice = |packed: &PackedEvent| (packed.since() >> shift) as usize;
        for packed in parts.iter().flat_map(Part::packed) {
            next[slice(packed)] += 1;
        }
        starts(next);
        for packed in parts.iter().flat_map(Part::packed) {
            let place = &mut next[slice(packed)];
            out[*place as usize] = *packed;
            *place += 1;
        }
    }

    /// The events of a slice.
    pub(super) fn slice(&self, slice: usize) -> &[PackedEvent] {
        let before = slice.checked_sub(1).map_or(0, |last| self.ends[last]);
        &self.packed[before as usize..self.ends[slice] as usize]
    }
}
