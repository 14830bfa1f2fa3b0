//! Buffers in which lists are made, kept from interval to interval.

use rayon::prelude::*;

use crate::{event::Event, unit::Micros};

use super::{
    packed_event::PackedEvent,
    part::Part,
    sorted::{Sliced, sort},
    time_quantiser::TimeQuantiser,
};

/// With fewer events one thread is faster than several.
const ENOUGH: usize = 1 << 12;

/// Events in a microsecond, on average, from which on several threads sort.
const DENSE: usize = 4;

/// So many events, and where they go, stay in a core's own cache while they are sorted. Tests see
/// with fewer what many become.
const CACHED: usize = if cfg!(test) { 1 << 14 } else { 1 << 18 };

/// Slices are this long on average: one is sorted and passed on while it is in that cache.
const SLICE: usize = CACHED / 8;

/// At most so many slices: each is written to at a place of its own.
const SLICES: usize = 512;

/// Neighbouring bands whose events go into slices together have about so many: when they are read
/// again they are in that cache.
const GROUP: usize = CACHED / 4;

/// The events of all bands, and the buffers in which they are sorted.
#[derive(Clone, Debug, Default)]
pub struct Buffers {
    pub(super) parts: Vec<Part>,
    /// The events of neighbouring bands by slice of time.
    groups: Vec<Sliced>,
    /// Sorted events; the buffer is longer.
    sorted: Vec<PackedEvent>,
    /// The places of the next events of each microsecond.
    next: Vec<u32>,
}

impl Buffers {
    /// Appends the events of all bands in order of time: all at once, or a slice of time after the
    /// other, or all slices on several threads.
    pub(super) fn in_order(&mut self, quantiser: TimeQuantiser, events: &mut Vec<Event>) {
        let Self {
            parts,
            groups,
            sorted,
            next,
        } = self;
        let microseconds = quantiser.microseconds();
        let total = parts.iter().map(|part| part.packed().len()).sum();
        let runs = parts.iter().map(Part::packed);
        if microseconds > 4 * total {
            let all = of_length(sorted, total);
            let mut rest = &mut *all;
            for run in runs {
                let (out, after) = rest.split_at_mut(run.len());
                out.copy_from_slice(run);
                rest = after;
            }
            all.sort_by_key(|packed| packed.since());
            return quantiser.emit(all, events);
        }
        let threads = if total < ENOUGH || total < DENSE * microseconds {
            1
        } else {
            rayon::current_num_threads()
        };
        if threads == 1 && total <= CACHED {
            let all = of_length(sorted, total);
            sort(runs, 0, microseconds, next, all, |packed| packed);
            return quantiser.emit(all, events);
        }
        // The events of each group of bands go into slices of time; then each slice is sorted.
        let wanted = (total / SLICE).clamp(8 * threads, SLICES);
        let shift = microseconds.div_ceil(wanted).next_power_of_two().ilog2();
        let slices = microseconds.div_ceil(1 << shift);
        let wanted = (total / GROUP).max(threads);
        let together = parts.len().div_ceil(wanted);
        groups.resize_with(parts.len().div_ceil(together), Sliced::default);
        let parts = parts.par_chunks(together).zip(&mut *groups);
        parts.for_each(|(parts, group)| group.sort(parts, slices, shift));
        let groups = &*groups;
        let runs = |slice| groups.iter().map(move |group: &Sliced| group.slice(slice));
        let lengths = (0..slices).map(|slice| runs(slice).map(<[PackedEvent]>::len).sum());
        if threads == 1 {
            for (slice, length) in lengths.enumerate() {
                let out = of_length(sorted, length);
                sort(
                    runs(slice),
                    slice << shift,
                    1 << shift,
                    next,
                    out,
                    |packed| packed,
                );
                quantiser.emit(out, events);
            }
            return;
        }
        let start = events.len();
        events.resize(start + total, PackedEvent::default().at(Micros(0)));
        let mut rest = &mut events[start..];
        let mut jobs = Vec::with_capacity(slices);
        for (slice, length) in lengths.enumerate() {
            let (out, after) = rest.split_at_mut(length);
            rest = after;
            jobs.push((slice, out));
        }
        let event = |packed| quantiser.event(packed);
        jobs.into_par_iter()
            .for_each_init(Vec::new, |next, (slice, out)| {
                sort(runs(slice), slice << shift, 1 << shift, next, out, event);
            });
    }
}

/// So many events of a buffer, which grows where it is shorter.
fn of_length(buffer: &mut Vec<PackedEvent>, length: usize) -> &mut [PackedEvent] {
    if buffer.len() < length {
        buffer.resize(length, PackedEvent::default());
    }
    &mut buffer[..length]
}
