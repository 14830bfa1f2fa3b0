//! Blocks: the packed events of the cells in some columns of a row.

use multiversion::multiversion;

use crate::{bits, number::Real, reference::train::TrainRow};

use super::{packed_event::PackedEvent, time_quantiser::TimeQuantiser};

/// Columns of a block.
const BLOCK: usize = 64;

/// Events of a cell that are written at a time, however many it has.
pub(super) const FEW: usize = 4;

/// The numbers of these events.
const LANES: [f64; FEW] = [0.0, 1.0, 2.0, 3.0];

/// The parameters of each cell's events, whether it fires or not.
struct Block {
    /// Time of its first event, as [`TimeQuantiser::since`].
    since: [f64; BLOCK],
    /// The spacing of its events, in microseconds.
    step: [f64; BLOCK],
    /// Its packed event at the quantiser's start.
    packed: [PackedEvent; BLOCK],
    /// The number of its events.
    count: [u32; BLOCK],
}

/// Packs the events of a row of trains; `out` has room for [`FEW`] more than there are.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
pub(super) fn expand<R: Real>(
    row: &TrainRow<R>,
    quantiser: &TimeQuantiser,
    mut out: &mut [PackedEvent],
) {
    let (counts, first, spacing) = row.parts();
    let (blocks, rest) = counts.as_chunks();
    let (blocks_first, rest_first) = first.as_chunks();
    let (blocks_spacing, rest_spacing) = spacing.as_chunks();
    let packed = PackedEvent::new(row.channel, row.y);
    let mut block = Block {
        since: [0.0; BLOCK],
        step: [0.0; BLOCK],
        packed: [packed; BLOCK],
        count: [0; BLOCK],
    };
    let blocks = blocks.iter().zip(blocks_first.iter().zip(blocks_spacing));
    for (k, (counts, (first, spacing))) in blocks.enumerate() {
        let packed = packed.column(BLOCK * k, 0);
        out = block.expand((counts, first, spacing), packed, quantiser, out);
    }
    if rest.is_empty() {
        return;
    }
    let mut last = ([0; BLOCK], [R::ZERO; BLOCK], [R::ZERO; BLOCK]);
    last.0[..rest.len()].copy_from_slice(rest);
    last.1[..rest.len()].copy_from_slice(rest_first);
    last.2[..rest.len()].copy_from_slice(rest_spacing);
    let packed = packed.column(counts.len() - rest.len(), 0);
    block.expand((&last.0, &last.1, &last.2), packed, quantiser, out);
}

// What is not inlined is not compiled for the wide vectors.
#[allow(clippy::inline_always)]
impl Block {
    /// Packs the events of some columns, beginning with that of `packed`; returns the room behind
    /// them. Almost no branch depends on the number of events, as most cells have few.
    #[inline(always)]
    fn expand<'a, R: Real>(
        &mut self,
        (counts, first, spacing): (&[i32; BLOCK], &[R; BLOCK], &[R; BLOCK]),
        packed: PackedEvent,
        quantiser: &TimeQuantiser,
        mut out: &'a mut [PackedEvent],
    ) -> &'a mut [PackedEvent] {
        let mut fired = bits::packed(&counts.map(|count| u8::from(count != 0)));
        if fired == 0 {
            return out;
        }
        for (to, count) in self.count.iter_mut().zip(counts) {
            *to = count.unsigned_abs();
        }
        for (to, first) in self.since.iter_mut().zip(first) {
            *to = quantiser.since(first.to_f64());
        }
        for (to, spacing) in self.step.iter_mut().zip(spacing) {
            *to = quantiser.steps(spacing.to_f64());
        }
        for (x, (to, count)) in self.packed.iter_mut().zip(counts).enumerate() {
            *to = packed.column(x, *count);
        }
        while fired != 0 {
            let x = fired.trailing_zeros() as usize % BLOCK;
            fired &= fired - 1;
            let Some((few, _)) = out.split_first_chunk_mut::<FEW>() else {
                break;
            };
            *few = LANES.map(|i| self.event(x, i, quantiser));
            let count = self.count[x] as usize;
            if count > FEW {
                self.more(x, quantiser, &mut out[FEW..], count - FEW);
            }
            out = &mut out[count..];
        }
        out
    }

    /// Event `i` of cell `x`, packed.
    #[inline(always)]
    fn event(&self, x: usize, i: f64, quantiser: &TimeQuantiser) -> PackedEvent {
        self.packed[x].after(quantiser.whole(self.since[x] + self.step[x] * i))
    }

    /// Packs the events of a cell beyond the first few; may write a few more than there are.
    #[inline(always)]
    fn more(&self, x: usize, quantiser: &TimeQuantiser, out: &mut [PackedEvent], count: usize) {
        let mut written = FEW as f64;
        let (fews, _) = out.as_chunks_mut::<FEW>();
        for few in fews.iter_mut().take(count.div_ceil(FEW)) {
            *few = LANES.map(|i| self.event(x, written + i, quantiser));
            written += FEW as f64;
        }
    }
}
