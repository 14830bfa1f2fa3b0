//! Buffers in which lists are made, kept from interval to interval.

use rayon::prelude::*;

use super::{
    packed_event::PackedEvent,
    part::Part,
    sorted::{Sorted, merge},
};

/// With fewer events one thread is faster than several.
pub(super) const ENOUGH: usize = 1 << 12;

/// Events in a microsecond, on average, from which on merging takes less time than sorting in
/// groups saves.
const DENSE: usize = 4;

/// The events of all bands, and the buffers in which they are sorted.
#[derive(Clone, Debug, Default)]
pub struct Buffers {
    pub(super) parts: Vec<Part>,
    /// The sorted events of neighbouring bands, a group for each thread; or one group of all.
    groups: Vec<Sorted>,
    /// The sorted events of all bands; the buffer is longer.
    merged: Vec<PackedEvent>,
}

impl Buffers {
    /// Sorts the events of all bands, which lie within so many microseconds.
    pub(super) fn sorted(&mut self, microseconds: usize) -> &[PackedEvent] {
        let total = self.parts.iter().map(|part| part.packed().len()).sum();
        if microseconds > 4 * total {
            self.merged.clear();
            let packed = self.parts.iter().flat_map(Part::packed);
            self.merged.extend(packed);
            self.merged.sort_by_key(|packed| packed.since());
            return &self.merged;
        }
        let threads = if total < ENOUGH || total < DENSE * microseconds {
            1
        } else {
            rayon::current_num_threads()
        };
        let group = self.parts.len().div_ceil(threads);
        let groups = self.parts.len().div_ceil(group);
        self.groups.resize_with(groups, Sorted::default);
        if groups == 1 {
            self.groups[0].sort(&self.parts, microseconds);
            return self.groups[0].packed();
        }
        let parts = self.parts.par_chunks(group).zip(&mut self.groups);
        parts.for_each(|(parts, group)| group.sort(parts, microseconds));
        if self.merged.len() < total {
            self.merged.resize(total, PackedEvent::default());
        }
        let (groups, all) = (&self.groups[..], &mut self.merged[..total]);
        let mut rest = &mut *all;
        let share = microseconds.div_ceil(threads);
        let mut jobs = Vec::with_capacity(threads);
        for since in (0..microseconds).step_by(share) {
            let until = (since + share).min(microseconds);
            let packed = groups.iter().map(|group| group.within(since..until).len());
            let (out, after) = rest.split_at_mut(packed.sum());
            rest = after;
            jobs.push((since..until, out));
        }
        let jobs = jobs.into_par_iter();
        jobs.for_each(|(range, out)| merge(groups, range, out));
        all
    }
}
