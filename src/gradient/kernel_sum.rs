//! The gradient of a kernel: `dL/dW(k) = sum over x of h(x) u(x + k)`, with `h = dL/dS`.

use multiversion::multiversion;

use crate::reference::signal::{BLOCK, Padded};

use super::float::Float;

/// The sums of one kernel, a vector of partial sums for each weight.
///
/// A row of `h` is read once for five columns of the kernel: five sums stay in registers, and there
/// are two operations and one load for each weight and pixel. Partial sums are folded into double
/// precision after each frame of a piece, so that single precision loses little.
#[derive(Clone, Debug)]
pub(super) struct KernelSum<R> {
    rows: usize,
    columns: usize,
    lanes: Vec<R>,
    /// The whole sums, row by row of the kernel.
    pub(super) total: Vec<f64>,
}

/// Columns of a kernel that are summed at a time.
const COLUMNS: usize = 5;

/// Sums of a column that are taken side by side: so many that five of them fill ten vector registers.
const fn lanes<R>() -> usize {
    64 / size_of::<R>()
}

impl<R: Float> KernelSum<R> {
    pub(super) fn new((rows, columns): (usize, usize)) -> Self {
        Self {
            rows,
            columns,
            lanes: vec![R::ZERO; rows * columns * lanes::<R>()],
            total: vec![0.0; rows * columns],
        }
    }

    /// Adds row `y` of so many columns: `h` is 0 beyond the last one, up to a whole block.
    pub(super) fn add(&mut self, signal: &Padded<R>, (y, width): (usize, usize), h: &[R]) {
        debug_assert!(h.len().is_multiple_of(BLOCK));
        let h = &h[..width.next_multiple_of(lanes::<R>())];
        let (source, stride) = signal.from(y, (self.rows / 2, self.columns / 2));
        let own = self.columns * lanes::<R>();
        for (row, sums) in self.lanes.chunks_exact_mut(own).enumerate() {
            let source = &source[row * stride..];
            for (part, sums) in sums.chunks_mut(COLUMNS * lanes::<R>()).enumerate() {
                let source = &source[part * COLUMNS..];
                if size_of::<R>() > 4 {
                    add_columns::<R, 8>(h, source, sums);
                } else {
                    add_columns::<R, 16>(h, source, sums);
                }
            }
        }
    }

    /// Folds the partial sums.
    pub(super) fn fold(&mut self) {
        for (total, lanes) in self
            .total
            .iter_mut()
            .zip(self.lanes.chunks_mut(lanes::<R>()))
        {
            for lane in lanes {
                *total += lane.to_f64();
                *lane = R::ZERO;
            }
        }
    }
}

fn add_columns<R: Float, const LANES: usize>(h: &[R], source: &[R], sums: &mut [R]) {
    let sums = sums.as_chunks_mut().0;
    match sums.len() {
        1 => add_some::<R, LANES, 1>(h, source, sums),
        2 => add_some::<R, LANES, 2>(h, source, sums),
        3 => add_some::<R, LANES, 3>(h, source, sums),
        4 => add_some::<R, LANES, 4>(h, source, sums),
        _ => add_some::<R, LANES, 5>(h, source, sums),
    }
}

// Not for 512-bit vectors: there LLVM gathers and scatters the sums of single precision, which takes
// three times as long as AVX2.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn add_some<R: Float, const LANES: usize, const TAPS: usize>(
    h: &[R],
    source: &[R],
    sums: &mut [[R; LANES]],
) {
    let Some(sums) = sums.first_chunk_mut::<TAPS>() else {
        return;
    };
    let mut local = *sums;
    let mut at = 0;
    while at + LANES <= h.len() && at + LANES + TAPS - 1 <= source.len() {
        let (h, source) = (&h[at..at + LANES], &source[at..at + LANES + TAPS - 1]);
        for tap in 0..TAPS {
            for lane in 0..LANES {
                local[tap][lane] = local[tap][lane] + h[lane] * source[tap + lane];
            }
        }
        at += LANES;
    }
    *sums = local;
}
