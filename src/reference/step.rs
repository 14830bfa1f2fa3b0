//! A row of cells whose memory steps, in one pass: distance, events, times, memory, as
//! [`super::memory`] and [`super::fire`] define them, cell by cell.
//!
//! Separate passes would give the same, and take half as long again: each is either all loads and
//! stores or all division. Only the conversion of whole numbers to integers is a pass of its own:
//! nearly always all are so small that a short way suffices.

use std::ops::Range;

use multiversion::{multiversion, target::target_cfg_f};

use crate::number::{Number, Real};

use super::{
    fire,
    memory::{self, Stepped},
    train::TrainRow,
};

/// The input of a row of cells.
pub(crate) struct Seen<'a, N: Number> {
    /// The drive at the later frame.
    pub(crate) drive: &'a [N::Held],
    pub(crate) on: &'a [N::Real],
    pub(crate) off: &'a [N::Real],
    /// Reciprocals of the two thresholds.
    pub(crate) per: (&'a [N::Real], &'a [N::Real]),
    /// How far the leak lowers each memory in a second; empty without leak.
    pub(crate) leak: &'a [N::Real],
    /// The times of the two frames, in seconds since the first.
    pub(crate) elapsed: (f64, f64),
}

impl<N: Number> Stepped<N> {
    /// Advances the cells in `range` from the drive `before` to the present one, which replaces it:
    /// counts the thresholds crossed and moves the memories; also when they were crossed, if
    /// `times` are wanted. Returns the number of events; the error is the column of the first cell
    /// that crossed too many.
    pub(crate) fn cross(
        &mut self,
        number: &N,
        range: Range<usize>,
        before: &mut [N::Held],
        seen: &Seen<'_, N>,
        times: bool,
        (row, scratch): (&mut TrainRow<N::Real>, &mut [N::Real]),
    ) -> Result<u64, usize> {
        let steps = Steps {
            base: &self.base[range.clone()],
            net: &self.net[range.clone()],
            off: self
                .off
                .as_mut()
                .map_or(&mut [], |off| &mut off[range.clone()]),
        };
        let parts = Parts {
            times,
            leak: !seen.leak.is_empty(),
            off: !steps.off.is_empty(),
        };
        let small = step(number, steps, before, seen, row, scratch, parts);
        let net = &mut self.net[range];
        let counted = if small {
            count::<N::Real, true>(scratch, &mut row.counts, net)
        } else {
            count::<N::Real, false>(scratch, &mut row.counts, net)
        };
        counted.ok_or_else(|| {
            let column = net.iter().position(|net| memory::room(*net) < 0);
            column.unwrap_or(0)
        })
    }
}

/// The memories of a row.
struct Steps<'a, N: Number> {
    base: &'a [N::Held],
    net: &'a [i32],
    off: &'a mut [f64],
}

/// What a step has besides counts and memories.
#[derive(Clone, Copy)]
struct Parts {
    /// When thresholds were crossed.
    times: bool,
    leak: bool,
    /// Counts of OFF steps of their own.
    off: bool,
}

/// Computes into `whole` how many thresholds each cell crossed; returns whether all are small.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn step<N: Number>(
    number: &N,
    steps: Steps<'_, N>,
    before: &mut [N::Held],
    seen: &Seen<'_, N>,
    row: &mut TrainRow<N::Real>,
    whole: &mut [N::Real],
    parts: Parts,
) -> bool {
    // Only where vectors are wide is there a loop for each.
    if target_cfg_f!(all(target_arch = "x86_64", not(target_feature = "avx2"))) {
        return step_with(number, steps, before, seen, row, whole, parts);
    }
    macro_rules! with {
        ($times:literal, $leak:literal, $off:literal) => {{
            let parts = Parts {
                times: $times,
                leak: $leak,
                off: $off,
            };
            step_with(number, steps, before, seen, row, whole, parts)
        }};
    }
    match (parts.times, parts.leak, parts.off) {
        (false, false, false) => with!(false, false, false),
        (false, false, true) => with!(false, false, true),
        (false, true, false) => with!(false, true, false),
        (false, true, true) => with!(false, true, true),
        (true, false, false) => with!(true, false, false),
        (true, false, true) => with!(true, false, true),
        (true, true, false) => with!(true, true, false),
        (true, true, true) => with!(true, true, true),
    }
}

/// The same; where `parts` is known it is a loop of those parts alone.
#[allow(clippy::inline_always, clippy::needless_pass_by_value)]
#[inline(always)]
fn step_with<N: Number>(
    number: &N,
    steps: Steps<'_, N>,
    before: &mut [N::Held],
    seen: &Seen<'_, N>,
    row: &mut TrainRow<N::Real>,
    whole: &mut [N::Real],
    Parts {
        times,
        leak: leaks,
        off: counts_off,
    }: Parts,
) -> bool {
    let cells = seen.drive.len();
    // All slices have one length, so that the loop has no bounds checks.
    let (drive, on, off) = (seen.drive, &seen.on[..cells], &seen.off[..cells]);
    let (per_on, per_off) = (&seen.per.0[..cells], &seen.per.1[..cells]);
    let (base, net, before) = (
        &steps.base[..cells],
        &steps.net[..cells],
        &mut before[..cells],
    );
    let leak = &seen.leak[..if leaks { cells } else { 0 }];
    let off_steps = &mut steps.off[..if counts_off { cells } else { 0 }];
    let whole = &mut whole[..cells];
    let (first, spacing) = (&mut row.first[..cells], &mut row.spacing[..cells]);
    let fallen = (
        N::Real::from_f64(seen.elapsed.0),
        N::Real::from_f64(seen.elapsed.1),
    );
    let mut most = N::Real::ZERO;
    for x in 0..cells {
        // Without a count of OFF steps the two thresholds are equal.
        let (on, off) = (on[x], if counts_off { off[x] } else { on[x] });
        let memory = if counts_off {
            let steps = (f64::from(net[x]) + off_steps[x], off_steps[x]);
            memory::apart(number, base[x], steps, on, off)
        } else {
            memory::at(number, base[x], net[x], on)
        };
        let mut to = number.real(number.sub(drive[x], memory));
        if leaks {
            to = to + leak[x] * fallen.1;
        }
        let per_on = per_on[x];
        let count = fire::whole(to, per_on, if counts_off { per_off[x] } else { per_on });
        most = most.max_nonnegative(count);
        let count = count.mul_sign(to);
        if times {
            let mut from = number.real(number.sub(before[x], memory));
            if leaks {
                from = from + leak[x] * fallen.0;
            }
            (first[x], spacing[x]) = fire::place(from, to, on, off);
        }
        before[x] = drive[x];
        whole[x] = count;
        if counts_off {
            let count = count.to_f64();
            off_steps[x] -= if count < 0.0 { count } else { 0.0 };
        }
    }
    most < N::Real::IN_RANGE
}

/// Converts whole numbers to integer counts, small ones by a shorter way, and moves the memories;
/// returns the number of events, if all could be counted.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn count<R: Real, const SMALL: bool>(
    whole: &[R],
    counts: &mut [i32],
    net: &mut [i32],
) -> Option<u64> {
    let (mut room, mut few, mut any) = (0, 0u32, 0);
    for (&whole, (count, net)) in whole.iter().zip(counts.iter_mut().zip(net)) {
        *count = if SMALL {
            whole.to_i32_in_range()
        } else {
            whole.to_f64().to_i32_in_range()
        };
        *net = net.wrapping_add(*count);
        room |= memory::room(*net);
        few = few.wrapping_add(count.unsigned_abs());
        any |= count.unsigned_abs();
    }
    // Nearly always their sum fits: a row has at most 2^16 cells.
    let events = if any < 1 << 15 {
        few.into()
    } else {
        counts.iter().map(|n| u64::from(n.unsigned_abs())).sum()
    };
    (room >= 0).then_some(events)
}
