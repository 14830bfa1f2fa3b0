//! Buffers in which lists are made, kept from interval to interval.

use rayon::prelude::*;

use super::{
    packed_event::PackedEvent,
    part::Part,
    sorted::{Sliced, sort},
};

/// With fewer events one thread is faster than several.
pub(super) const ENOUGH: usize = 1 << 12;

/// Events in a microsecond, on average, from which on several threads sort.
const DENSE: usize = 4;

/// So many events, and where they go, stay in a core's own cache while they are sorted.
const CACHED: usize = 1 << 16;

/// Slices are this long on average: short, as events may come in bursts.
const SLICE: usize = CACHED / 4;

/// At most so many slices: each is written to at a place of its own.
const SLICES: usize = 512;

/// The events of all bands, and the buffers in which they are sorted.
#[derive(Clone, Debug, Default)]
pub struct Buffers {
    pub(super) parts: Vec<Part>,
    /// The events of neighbouring bands by slice of time, a group for each thread.
    groups: Vec<Sliced>,
    /// The sorted events of all bands; the buffer is longer.
    sorted: Vec<PackedEvent>,
    /// The places of the next events of each microsecond.
    next: Vec<u32>,
}

impl Buffers {
    /// Sorts the events of all bands, which lie within so many microseconds.
    pub(super) fn sorted(&mut self, microseconds: usize) -> &[PackedEvent] {
        let total = self.parts.iter().map(|part| part.packed().len()).sum();
        if self.sorted.len() < total {
            self.sorted.resize(total, PackedEvent::default());
        }
        let all = &mut self.sorted[..total];
        let runs = self.parts.iter().map(Part::packed);
        if microseconds > 4 * total {
            let mut rest = &mut *all;
            for run in runs {
                let (out, after) = rest.split_at_mut(run.len());
                out.copy_from_slice(run);
                rest = after;
            }
            all.sort_by_key(|packed| packed.since());
            return all;
        }
        let threads = if total < ENOUGH || total < DENSE * microseconds {
            1
        } else {
            rayon::current_num_threads()
        };
        if threads == 1 && total <= CACHED {
            sort(runs, 0, microseconds, &mut self.next, all);
            return all;
        }
        // Each thread puts its bands' events into slices of time; then each slice is sorted.
        let wanted = (total / SLICE).clamp(4 * threads, SLICES);
        let shift = microseconds.div_ceil(wanted).next_power_of_two().ilog2();
        let slices = microseconds.div_ceil(1 << shift);
        let group = self.parts.len().div_ceil(threads);
        self.groups
            .resize_with(self.parts.len().div_ceil(group), Sliced::default);
        let parts = self.parts.par_chunks(group).zip(&mut self.groups);
        parts.for_each(|(parts, group)| group.sort(parts, slices, shift));
        let groups = &self.groups;
        let runs = |slice| groups.iter().map(move |group: &Sliced| group.slice(slice));
        let mut rest = &mut *all;
        let mut jobs = Vec::with_capacity(slices);
        for slice in 0..slices {
            let len = runs(slice).map(<[PackedEvent]>::len).sum();
            let (out, after) = rest.split_at_mut(len);
            rest = after;
            jobs.push((slice, out));
        }
        jobs.into_par_iter()
            .for_each_init(Vec::new, |next, (slice, out)| {
                sort(runs(slice), slice << shift, 1 << shift, next, out);
            });
        all
    }
}
