//! Notes: events in 8 bytes, as they are told.

use multiversion::multiversion;

use crate::{
    bits,
    event::{Event, Polarity},
    number::Real,
    unit::Micros,
};

use super::{super::train::TrainRow, clock::Clock};

/// An event in 8 bytes, from the lowest bit on: 16 bits each for column and row, 8 for the
/// channel, one for the sign (1 is ON), 23 for the microseconds since the clock's start.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Note(u64);

/// An event of every channel and sign: copied from here, the two are written at once.
static KINDS: [Event; 512] = kinds();

const fn kinds() -> [Event; 512] {
    let mut kinds = [Event {
        t: Micros(0),
        x: 0,
        y: 0,
        polarity: Polarity::Off,
        channel: 0,
    }; 512];
    let mut kind = 0;
    while kind < 512 {
        kinds[kind].channel = kind as u8;
        if kind >= 256 {
            kinds[kind].polarity = Polarity::On;
        }
        kind += 1;
    }
    kinds
}

impl Note {
    /// Where the sign stands, and below it all of who fired.
    const SIGN: u32 = 40;
    /// Where the time stands, and how many bits it has.
    const TIME: u32 = 41;
    pub(super) const TIME_BITS: u32 = 64 - Self::TIME;

    /// At the clock's start, in column 0, and ON.
    pub(super) fn of(channel: usize, y: usize) -> Self {
        Self((y as u64) << 16 | (channel as u64) << 32 | 1 << Self::SIGN)
    }

    /// With a column, and the sign of a count.
    #[inline]
    pub(super) const fn column(self, x: usize, count: i32) -> Self {
        let off = (count as u32 >> 31) as u64;
        Self((self.0 + x as u64) ^ off << Self::SIGN)
    }

    /// What more bits there are in `since` than a time has are lost.
    #[inline]
    const fn after(self, since: u64) -> Self {
        Self(self.0.wrapping_add(since << Self::TIME))
    }

    #[inline]
    pub(super) const fn since(self) -> u64 {
        self.0 >> Self::TIME
    }

    #[inline]
    pub(super) fn at(self, t: Micros) -> Event {
        Event {
            t,
            x: self.0 as u16,
            y: (self.0 >> 16) as u16,
            ..KINDS[(self.0 >> 32) as usize % KINDS.len()]
        }
    }
}

/// Events of a train that are written at a time, whether there are as many or fewer.
pub(super) const FEW: usize = 4;

/// Notes the events of a row of trains; `out` has room for [`FEW`] more than there are.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
pub(super) fn expand<R: Real>(row: &TrainRow<R>, clock: &Clock, out: &mut [Note]) {
    let (counts, first, spacing) = row.parts();
    let mut len = 0;
    let (blocks, rest) = counts.as_chunks();
    let (blocks_first, rest_first) = first.as_chunks();
    let (blocks_spacing, rest_spacing) = spacing.as_chunks();
    let note = Note::of(row.channel, row.y);
    let blocks = blocks.iter().zip(blocks_first.iter().zip(blocks_spacing));
    for (block, (counts, (first, spacing))) in blocks.enumerate() {
        let note = note.column(BLOCK * block, 0);
        len += expand_block(counts, first, spacing, note, clock, &mut out[len..]);
    }
    let mut last = ([0; BLOCK], [R::ZERO; BLOCK], [R::ZERO; BLOCK]);
    last.0[..rest.len()].copy_from_slice(rest);
    last.1[..rest.len()].copy_from_slice(rest_first);
    last.2[..rest.len()].copy_from_slice(rest_spacing);
    let note = note.column(counts.len() - rest.len(), 0);
    expand_block(&last.0, &last.1, &last.2, note, clock, &mut out[len..]);
}

/// Trains that are expanded at a time.
const BLOCK: usize = 64;

/// Those of some columns; how many events they have. No branch depends on how many each has,
/// few as they mostly are.
#[expect(
    clippy::inline_always,
    reason = "what is not inlined is not compiled for the wide vectors"
)]
#[inline(always)]
fn expand_block<R: Real>(
    counts: &[i32; BLOCK],
    first: &[R; BLOCK],
    spacing: &[R; BLOCK],
    note: Note,
    clock: &Clock,
    out: &mut [Note],
) -> usize {
    let mut fired = fired(counts);
    let mut len = 0;
    while fired != 0 {
        let x = fired.trailing_zeros() as usize % BLOCK;
        fired &= fired - 1;
        let note = note.column(x, counts[x]);
        let (first, spacing) = (first[x].to_f64(), spacing[x].to_f64());
        let event = |i: usize| note.after(clock.low(first + spacing * i as f64));
        out[len..len + FEW].copy_from_slice(&std::array::from_fn::<_, FEW, _>(event));
        let count = counts[x].unsigned_abs() as usize;
        for i in FEW..count {
            out[len + i] = event(i);
        }
        len += count;
    }
    len
}

/// A bit for each count that is not 0.
#[expect(
    clippy::inline_always,
    reason = "what is not inlined is not compiled for the wide vectors"
)]
#[inline(always)]
fn fired(counts: &[i32; BLOCK]) -> u64 {
    bits::packed(&counts.map(|count| u8::from(count != 0)))
}
