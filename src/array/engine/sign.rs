//! Where the bus is above zero.

use std::ops::Range;

use super::{
    super::{RowOps, Undecided, bits::cut},
    operation::{Border, BusInput},
    runs::PIECE,
    view::View,
};
use crate::bits::packed;

/// Words of bits that are made together.
const BATCH: usize = 16;

/// Bus inputs of a bus that is worked on many pixels at once, at most.
const FEW: usize = 3;

/// Sets the bits of these rows where the bus is above zero; `bits` are theirs alone.
///
/// # Errors
/// In domains that have no answer.
#[inline(never)]
pub(super) fn sign_bits<D: RowOps>(
    domain: &D,
    view: &View<'_, '_, D::Cell>,
    bus_inputs: &[BusInput],
    border: Border,
    bits: &mut [u64],
    rows: Range<usize>,
) -> Result<(), Undecided> {
    let decided = match bus_inputs.len() {
        1..=FEW => few(domain, view, bus_inputs, border, bits, rows),
        _ => all(domain, view, bus_inputs, bits, rows.start, rows),
    };
    if decided {
        Ok(())
    } else {
        Err(Undecided { operation: "where" })
    }
}

/// With few bus inputs; whether the domain has an answer.
fn few<D: RowOps>(
    domain: &D,
    view: &View<'_, '_, D::Cell>,
    bus_inputs: &[BusInput],
    border: Border,
    bits: &mut [u64],
    rows: Range<usize>,
) -> bool {
    let width = view.size.width;
    let top = rows.start;
    let inner = border.inside(view.size, &rows);
    let mut decided = true;
    if inner != rows {
        decided &= all(domain, view, bus_inputs, bits, top, rows.start..inner.start);
        decided &= all(domain, view, bus_inputs, bits, top, inner.end..rows.end);
    }
    if inner.is_empty() {
        return decided;
    }
    let (inputs, count) = (padded(bus_inputs), bus_inputs.len());
    let words = width.div_ceil(64);
    let even = width.is_multiple_of(64);
    if even && border.left + border.right == 0 {
        let bits = &mut bits[(inner.start - top) * words..][..inner.len() * words];
        if in_words(domain, view, bus_inputs, bits, inner.start) {
            return decided;
        }
    }
    let run = if even { inner.len() } else { 1 };
    // Many at once: bytes that were just written are slow to read in another width.
    let mut bytes = [0; 64 * BATCH];
    for y in inner.clone().step_by(run) {
        let starts = view.starts(&inputs, view.cell(y, 0), (0, 0));
        let (first, last) = (border.left, run * width - border.right);
        let bits = &mut bits[(y - top) * words..][..run * words];
        for (batch, bits) in bits.chunks_mut(BATCH).enumerate() {
            let from = 64 * BATCH * batch;
            let bytes = &mut bytes[..64 * bits.len()];
            // What needs something from off the array is done afterwards.
            let (begin, end) = (from.max(first), (from + bytes.len()).min(last).max(from));
            let sources = view.sources(&inputs, &starts, begin, end - begin);
            decided &= domain.positives(&sources[..count], &mut bytes[begin - from..end - from]);
            let blocks = bytes.as_chunks::<64>().0;
            for (word, bytes) in bits.iter_mut().zip(blocks) {
                *word = packed(bytes);
            }
        }
        cut(bits, width);
    }
    for x in (0..border.left).chain(width - border.right..width) {
        for y in inner.clone() {
            let row = &mut bits[(y - top) * words..];
            decided &= one(domain, view, bus_inputs, row, y, x);
        }
    }
    decided
}

/// Few bus inputs, at least one: the last again and again behind them. So what follows is compiled
/// once, not for each number of them.
fn padded(bus_inputs: &[BusInput]) -> [BusInput; FEW] {
    std::array::from_fn(|k| bus_inputs[k.min(bus_inputs.len() - 1)])
}

/// Whole words from a row on, where nothing is asked for that lies off the array; whether the
/// domain makes words.
fn in_words<D: RowOps>(
    domain: &D,
    view: &View<'_, '_, D::Cell>,
    bus_inputs: &[BusInput],
    bits: &mut [u64],
    y: usize,
) -> bool {
    let (inputs, count) = (padded(bus_inputs), bus_inputs.len());
    let starts = view.starts(&inputs, view.cell(y, 0), (0, 0));
    let mut pieces = bits.chunks_mut(PIECE / 64).enumerate();
    pieces.all(|(k, bits)| {
        let sources = view.sources(&inputs, &starts, PIECE * k, 64 * bits.len());
        domain.positive_words(&sources[..count], bits)
    })
}

/// Every pixel of these rows, one by one.
#[cold]
#[inline(never)]
fn all<D: RowOps>(
    domain: &D,
    view: &View<'_, '_, D::Cell>,
    bus_inputs: &[BusInput],
    bits: &mut [u64],
    top: usize,
    rows: Range<usize>,
) -> bool {
    let width = view.size.width;
    let mut decided = true;
    for y in rows {
        let row = &mut bits[(y - top) * width.div_ceil(64)..];
        for x in 0..width {
            decided &= one(domain, view, bus_inputs, row, y, x);
        }
    }
    decided
}

/// One pixel; whether the domain has an answer.
fn one<D: RowOps>(
    domain: &D,
    view: &View<'_, '_, D::Cell>,
    bus_inputs: &[BusInput],
    row: &mut [u64],
    y: usize,
    x: usize,
) -> bool {
    let answer = domain.positive(&view.sum(domain, bus_inputs, y, x));
    let mask = 1 << (x % 64);
    let word = &mut row[x / 64];
    *word = if answer == Some(true) {
        *word | mask
    } else {
        *word & !mask
    };
    answer.is_some()
}
