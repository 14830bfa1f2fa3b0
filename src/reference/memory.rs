//! The memory of a cell: what the drive is compared with, and how an event changes it.
//!
//! | rule | holds | distance `d` | when a cell fires |
//! |---|---|---|---|
//! | `raw-snap` | pixels, `M(x)` | `W * (u - M)` | `M(x) := u(x)` (Eq. 2-4 of So & Wetzstein, arXiv 2504.13457) |
//! | `raw-snap`, shared | pixels, one `M(x)` for all kinds | `W * (u - M)` | `M(x) := u(x)`, whichever kind fires at x |
//! | `filtered-snap` | the filtered signal | `W * u - M` | `M(x) := (W * u)(x)`: one shot a frame on a chip |
//! | `filtered-step` | the filtered signal | `W * u - M` | `M(x) += p N θ` (the released code, v2e) |
//! | `authors-pixel-step` | pixels | `W * u - W_m * M` | `M(x) += p N θ` (the released code's old rule) |
//!
//! At the first frame the memory is that frame (filtered, where it holds the filtered signal),
//! so a still scene is silent from its start.
//!
//! A memory that steps is kept as a base and whole numbers of steps,
//! `M = base + n_on θ_on - n_off θ_off`, so that it does not drift however many steps it takes. The
//! two products grow with the events and nearly cancel where the thresholds differ: see
//! [`apart`].
//!
//! A pixel memory that snaps can fire for ever on a still scene: firing at x sets the pixel's
//! own difference to 0, and if the neighbours' differences still add up to more than the
//! threshold, x fires again at each frame and nothing changes. [`Report::livelocked`] counts
//! the events that do.
//!
//! [`Report::livelocked`]: super::Report::livelocked

use multiversion::multiversion;

use super::drive;
use crate::{
    aligned::Aligned,
    number::{Number, Real},
    sensor::Overflowed,
};

/// The memories of the cells of a band of rows.
#[derive(Clone, Debug)]
pub(super) enum Memory<N: Number> {
    RawSnap {
        /// Empty where all channels share the band's picture.
        pixels: Vec<N::Held>,
        /// The distances at the frame before, to recognise cells that fire for ever.
        before: Vec<N::Held>,
    },
    FilteredSnap {
        filtered: Vec<N::Held>,
        /// The signal when the cell last fired, where the polarity is the pixel's own.
        pixels: Option<Vec<N::Held>>,
    },
    FilteredStep(Stepped<N>),
    PixelStep(Stepped<N>),
}

/// A memory that is moved by whole thresholds.
#[derive(Clone, Debug)]
pub(crate) struct Stepped<N: Number> {
    pub(super) base: Aligned<N::Held>,
    /// Number of ON steps less number of OFF steps.
    pub(super) net: Aligned<i32>,
    /// Number of OFF steps, where the two thresholds differ.
    pub(super) off: Option<Vec<f64>>,
}

impl<N: Number> Stepped<N> {
    /// A memory without steps.
    pub(crate) fn new(base: &[N::Held], equal_thresholds: bool) -> Self {
        let cells = base.len();
        Self {
            base: Aligned::from_slice(3, base),
            net: Aligned::new(4, 0, cells),
            off: (!equal_thresholds).then(|| vec![0.0; cells]),
        }
    }

    /// The memories of the cells in `range`.
    pub(crate) fn values(
        &self,
        number: &N,
        range: std::ops::Range<usize>,
        on: &[N::Real],
        off: &[N::Real],
        out: &mut [N::Held],
    ) {
        let (base, net) = (&self.base[range.clone()], &self.net[range.clone()]);
        let Some(steps) = &self.off else {
            return stepped(number, base, net, on, out);
        };
        let thresholds = on.iter().zip(off);
        let cells = base.iter().zip(net).zip(&steps[range]).zip(thresholds);
        for (out, (((&base, &net), &steps), (&on, &off))) in out.iter_mut().zip(cells) {
            *out = apart(number, base, (f64::from(net) + steps, steps), on, off);
        }
    }

    /// How many memories of the cells in `range` the format does not hold, which are `held` in it.
    pub(crate) fn overflowed(
        &self,
        number: &N,
        range: std::ops::Range<usize>,
        (on, off): (&[N::Real], &[N::Real]),
        held: &[N::Held],
    ) -> Overflowed {
        let reals = range.zip(on.iter().zip(off)).map(|(cell, (on, off))| {
            let steps = self.off.as_ref().map_or(0.0, |off| off[cell]);
            let ways = (f64::from(self.net[cell]) + steps, steps);
            number.value(self.base[cell]) + moved(ways, (on.to_f64(), off.to_f64()))
        });
        drive::held(number, held, &reals.collect::<Vec<_>>())
    }

    /// Moves the memories of the cells in `range` by `counts` steps; the error is the column of the
    /// first cell that has moved too many steps.
    pub(crate) fn take(
        &mut self,
        range: std::ops::Range<usize>,
        counts: &[i32],
    ) -> Result<(), usize> {
        if let Some(off) = &mut self.off {
            for (off, count) in off[range.clone()].iter_mut().zip(counts) {
                *off -= f64::from((*count).min(0));
            }
        }
        let net = &mut self.net[range];
        if take(net, counts) {
            return Ok(());
        }
        Err(net.iter().position(|net| room(*net) < 0).unwrap_or(0))
    }
}

/// The most steps that a memory may be away from its base; so few that `net` cannot overflow
/// unnoticed, whatever one interval adds.
pub(super) const MAX_STEPS: i32 = 1 << 30;

/// Below 0 if a memory is too many steps away, so that the sign bits of many can be checked at
/// once.
#[inline]
pub(super) fn room(net: i32) -> i32 {
    net.wrapping_add(MAX_STEPS)
}

/// `base + net θ_on`
#[inline]
pub(super) fn at<N: Number>(number: &N, base: N::Held, net: i32, on: N::Real) -> N::Held {
    number.hold_real(number.real(base) + N::Real::from_i32(net) * on)
}

/// `base + n_on θ_on - n_off θ_off`.
///
/// What is left of the two products is held, never they themselves: where the thresholds differ they
/// grow with the events and nearly cancel. Each threshold is taken in two parts, of which the first
/// has so few digits that its product with up to 2^31 steps is exact. So the error is that of a few
/// roundings of what is left, however many steps there were.
#[inline]
pub(super) fn apart<N: Number>(
    number: &N,
    base: N::Held,
    (n_on, n_off): (f64, f64),
    on: N::Real,
    off: N::Real,
) -> N::Held {
    let base = number.real(base);
    // Both are computed, so that a loop has no branch.
    let equal = base + N::Real::from_f64(n_on - n_off) * on;
    let moved = moved((n_on, n_off), (on.to_f64(), off.to_f64()));
    let apart = N::Real::from_f64(base.to_f64() + moved);
    number.hold_real(if on == off { equal } else { apart })
}

/// `n_on θ_on - n_off θ_off`.
#[inline]
fn moved((n_on, n_off): (f64, f64), (on, off): (f64, f64)) -> f64 {
    // The first 22 of 53 digits.
    let high = |threshold: f64| f64::from_bits(threshold.to_bits() & !((1 << 31) - 1));
    let (on_high, off_high) = (high(on), high(off));
    let coarse = n_on * on_high - n_off * off_high;
    let fine = n_on * (on - on_high) - n_off * (off - off_high);
    coarse + fine
}

#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn stepped<N: Number>(
    number: &N,
    base: &[N::Held],
    net: &[i32],
    on: &[N::Real],
    out: &mut [N::Held],
) {
    let cells = base.iter().zip(net).zip(on);
    for (out, ((&base, &net), &on)) in out.iter_mut().zip(cells) {
        *out = at(number, base, net, on);
    }
}

/// Adds the steps; returns whether all memories are within bounds.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn take(net: &mut [i32], counts: &[i32]) -> bool {
    let mut all = 0;
    for (net, &count) in net.iter_mut().zip(counts) {
        *net = net.wrapping_add(count);
        all |= room(*net);
    }
    all >= 0
}

/// The distances `d = S - M`: subtracted in the number format, then converted to reals.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
pub(crate) fn distance<N: Number>(
    number: &N,
    drive: &[N::Held],
    memory: &[N::Held],
    out: &mut [N::Real],
) {
    for (out, (&drive, &memory)) in out.iter_mut().zip(drive.iter().zip(memory)) {
        *out = number.real(number.sub(drive, memory));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::number::{F32, F64};

    const MILLIARD: i32 = 1_000_000_000;

    fn after<N: Number>(number: &N, steps: &[i32], on: f64, off: f64) -> f64 {
        let mut memory = Stepped::<N>::new(&[number.hold(0.5)], on == off);
        for &count in steps {
            memory.take(0..1, &[count]).unwrap();
        }
        let mut out = [N::ZERO];
        memory.values(
            number,
            0..1,
            &[N::Real::from_f64(on)],
            &[N::Real::from_f64(off)],
            &mut out,
        );
        number.value(out[0])
    }

    #[test]
    fn a_thousand_million_steps_do_not_drift() {
        let there_and_back = [MILLIARD, -MILLIARD, MILLIARD, -MILLIARD, 1];
        assert_eq!(after(&F64, &there_and_back, 0.2, 0.2), 0.7);
        assert_eq!(
            after(&F32, &[1_000_000, 1_000_000, -2_000_000, 1], 0.2, 0.2),
            f64::from(0.7f32)
        );
        // Adding one by one in single precision is off by a hundredth after a million.
        let naive = (0..1_000_000).fold(0f32, |m, _| m + 0.2);
        assert!((naive - 200_000.0).abs() > 1000.0);
        assert_eq!(after(&F64, &[1_000_000], 0.2, 0.2), 200_000.5);
    }

    #[test]
    fn unequal_thresholds_step_by_their_own() {
        assert!((after(&F64, &[3, -2, 1], 0.2, 0.3) - 0.7).abs() < 1e-15);
    }

    /// Up by one step and down by a hundred, a million times: the memory is back where it began.
    #[test]
    fn unequal_thresholds_do_not_drift_either() {
        let (on, off) = (0.4, 0.4 / 100.0);
        let turns: Vec<i32> = (0..1_000_000).flat_map(|_| [1, -100]).collect();
        // As whole numbers; 100 of the second are not exactly one of the first.
        let whole = |threshold: f64| (threshold * 2f64.powi(70)) as i128;
        let left = |on, off| 1_000_000 * (whole(on) - 100 * whole(off));
        let left = |on, off| left(on, off) as f64 / 2f64.powi(70);
        assert!((after(&F64, &turns, on, off) - 0.5 - left(on, off)).abs() < 1e-15);
        let [single_on, single_off] = [on, off].map(|threshold| f64::from(threshold as f32));
        let single = after(&F32, &turns, on, off) - 0.5;
        assert!(
            (single - left(single_on, single_off)).abs() < 1e-7,
            "{single}"
        );
    }

    #[test]
    fn what_cannot_be_counted_is_refused() {
        let mut memory = Stepped::<F64>::new(&[0.0; 3], true);
        memory.take(0..3, &[1, MILLIARD, -MILLIARD]).unwrap();
        assert_eq!(memory.take(0..3, &[1, -1, -MILLIARD]), Err(2));
        assert_eq!(memory.take(0..3, &[1, MILLIARD, MILLIARD]), Err(1));
    }
}
