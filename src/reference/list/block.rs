//! Blocks: the cells of some columns of a row, and the notes of their events.

use multiversion::multiversion;

use crate::{bits, number::Real, reference::train::TrainRow};

use super::{packed_event::PackedEvent, time_quantiser::TimeQuantiser};

/// Columns that are worked on at a time.
const BLOCK: usize = 64;

/// Events of a cell that are written at a time, whether there are as many or fewer.
pub(super) const FEW: usize = 4;

/// Their numbers.
const LANES: [f64; FEW] = [0.0, 1.0, 2.0, 3.0];

/// What the events of each cell are made of, whether it fires or not.
struct Block {
    /// When its first one happens, as [`TimeQuantiser::since`].
    since: [f64; BLOCK],
    /// From one to the next, in microseconds.
    step: [f64; BLOCK],
    /// The note of an event at the clock's start.
    packed: [PackedEvent; BLOCK],
    /// How many there are.
    count: [u32; BLOCK],
}

/// Notes the events of a row of trains; `out` has room for [`FEW`] more than there are.
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
    let packed = PackedEvent::of(row.channel, row.y);
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
    /// Notes the events of some columns from that of `note` on; the room behind them. As good as
    /// no branch depends on how many events each cell has: mostly few.
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

    /// Event `i` of a cell.
    #[inline(always)]
    fn event(&self, x: usize, i: f64, quantiser: &TimeQuantiser) -> PackedEvent {
        self.packed[x].after(quantiser.whole(self.since[x] + self.step[x] * i))
    }

    /// The events of a cell after the first few, so many or a few more.
    #[inline(always)]
    fn more(&self, x: usize, quantiser: &TimeQuantiser, out: &mut [PackedEvent], count: usize) {
        let mut told = FEW as f64;
        let (fews, _) = out.as_chunks_mut::<FEW>();
        for few in fews.iter_mut().take(count.div_ceil(FEW)) {
            *few = LANES.map(|i| self.event(x, told + i, quantiser));
            told += FEW as f64;
        }
    }
}
