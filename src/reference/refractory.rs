//! Refractory periods: how long a cell is silent after an event.
//!
//! Two rules, named apart because they count differently:
//!
//! - **`dead-time`**: after an event at `t`, crossings in `[t, t + r)` are lost. The memory
//!   moves through them all the same, as in ESIM, so nothing is made up for later. Crossings
//!   are equally spaced, so of those after the first kept one, every `ceil(r / spacing)`-th
//!   is kept: no loop.
//! - **`authors`**: the supplement of So & Wetzstein (arXiv 2504.13457) as their released
//!   simulator computes it. With `Δ` the time between frames, `d` the distance from memory,
//!   and `α = Δ θ / (|d| + 1e-9)`:
//!
//! ```text
//! α_r = (floor(r / α) + 1) α                                     from event to event
//! β_r = max(0, floor((r - (t_{n-1} - t_last)) / α) α)            before the first
//! N   = floor((Δ - β_r) / α_r)   if α_r ≤ Δ - β_r, else 0        events, at t_{n-1} + β_r + i α_r
//! ```
//!
//! Its line starts at the memory (`d0 = 0`), an idle cell's first event waits a whole
//! refractory period, and the memory moves only by the events that were kept, so that the
//! rest comes out later, even on a still scene. It is here to agree with published numbers.

use multiversion::multiversion;

use crate::number::Real;

use super::{
    memory,
    train::{Interval, Train, TrainRow},
};

/// Cells that are worked on at a time: few, so that hardly a block has one that a dead time concerns.
const BLOCK: usize = 16;

/// Removes the events of a row of trains that a dead time of `seconds` loses; `fired` has the time
/// at which each cell last fired, in seconds.
#[multiversion(targets(
    "x86_64+avx2+avx512f+avx512bw+avx512dq+avx512vl",
    "x86_64+avx2",
    "aarch64+neon"
))]
pub(crate) fn dead_time<R: Real>(
    interval: Interval,
    seconds: f64,
    fired: &mut [f64],
    row: &mut TrainRow<R>,
) {
    let places = row
        .first
        .chunks_mut(BLOCK)
        .zip(row.spacing.chunks_mut(BLOCK));
    let blocks = row.counts.chunks_mut(BLOCK).zip(fired.chunks_mut(BLOCK));
    for ((counts, fired), (first, spacing)) in blocks.zip(places) {
        let mut any = 0;
        for count in &*counts {
            any |= *count;
        }
        if any == 0 {
            continue;
        }
        let trains = (&*counts, &*first, &*spacing);
        if loses(interval, seconds, fired, trains) {
            lose(interval, seconds, fired, (counts, first, spacing));
        } else {
            keep(interval, fired, (counts, first, spacing));
        }
    }
}

/// Whether a dead time might lose an event of a block of cells, told without a division: with a
/// margin above what rounding does to [`lose`].
#[expect(
    clippy::inline_always,
    reason = "what is not inlined is not compiled for the wide vectors"
)]
#[inline(always)]
fn loses<R: Real>(
    interval: Interval,
    seconds: f64,
    fired: &[f64],
    (counts, first, spacing): (&[i32], &[R], &[R]),
) -> bool {
    let (from, dt) = (interval.from, interval.duration());
    let (r, margin) = (seconds / dt, seconds * 1e-12);
    let cells = fired.len().min(BLOCK);
    let (fired, counts) = (&fired[..cells], &counts[..cells]);
    let (first, spacing) = (&first[..cells], &spacing[..cells]);
    let mut any = 0;
    for x in 0..cells {
        let (place, step) = (first[x].to_f64(), spacing[x].to_f64());
        let waits = from - fired[x] < (r - place) * dt + margin;
        let dense = step < r;
        let count = counts[x].unsigned_abs();
        any |= u64::from(waits && count > 0) | u64::from(dense && count > 1);
    }
    any != 0
}

/// What [`lose`] does where nothing is lost.
#[expect(clippy::inline_always, reason = "as above")]
#[inline(always)]
fn keep<R: Real>(
    interval: Interval,
    fired: &mut [f64],
    (counts, first, spacing): (&[i32], &[R], &mut [R]),
) {
    let (from, dt) = (interval.from, interval.duration());
    let cells = fired.len().min(BLOCK);
    let (fired, counts) = (&mut fired[..cells], &counts[..cells]);
    let (first, spacing) = (&first[..cells], &mut spacing[..cells]);
    let mut last_fired = [0.0; BLOCK];
    for x in 0..cells {
        let (place, step) = (first[x].to_f64(), spacing[x].to_f64());
        let (kept, before) = (f64::from(counts[x]).abs(), fired[x]);
        let step = if kept > 1.0 { step } else { 0.0 };
        let last = place + step * (kept - 1.0);
        let last = if last < 1.0 { last } else { 1.0 };
        let at = from + last * dt;
        last_fired[x] = if kept > 0.0 { at } else { before };
        spacing[x] = R::from_f64(step);
    }
    fired.copy_from_slice(&last_fired[..cells]);
}

/// [`dead_time`] of a block of cells.
///
/// Division by a spacing of 0, of a train that is one event, gives infinity, as it should. No
/// branch depends on the cells, and what may stay is not stored at its own place at once, so that
/// the loop is vectorised and has no masked stores, which are slow.
#[expect(clippy::inline_always, reason = "as above")]
#[inline(always)]
fn lose<R: Real>(
    interval: Interval,
    seconds: f64,
    fired: &mut [f64],
    (counts, first, spacing): (&mut [i32], &mut [R], &mut [R]),
) {
    let (from, dt) = (interval.from, interval.duration());
    // The tolerance keeps a crossing that rounding puts just before the end of the dead time.
    let r = seconds / dt * (1.0 - 1e-9);
    let cells = fired.len().min(BLOCK);
    let (fired, counts) = (&mut fired[..cells], &mut counts[..cells]);
    let (first, spacing) = (&mut first[..cells], &mut spacing[..cells]);
    let mut last_fired = [0.0; BLOCK];
    for x in 0..cells {
        let (place, step) = (first[x].to_f64(), spacing[x].to_f64());
        let (all, before) = (f64::from(counts[x]), fired[x]);
        let wait = r - (from - before) / dt - place;
        let skip = if wait > 0.0 {
            (wait / step).ceil()
        } else {
            0.0
        };
        let stride = (r / step).ceil();
        let stride = if stride > 1.0 { stride } else { 1.0 };
        let left = all.abs() - skip;
        let kept = ((left - 1.0) / stride).floor() + 1.0;
        let kept = if left > 0.0 { kept } else { 0.0 };
        let place = place + if skip > 0.0 { step * skip } else { 0.0 };
        let step = if kept > 1.0 { step * stride } else { 0.0 };
        let last = place + step * (kept - 1.0);
        let last = if last < 1.0 { last } else { 1.0 };
        let at = from + last * dt;
        last_fired[x] = if kept > 0.0 { at } else { before };
        counts[x] = if all < 0.0 { -kept } else { kept }.to_i32_in_range();
        (first[x], spacing[x]) = (R::from_f64(place), R::from_f64(step));
    }
    fired.copy_from_slice(&last_fired[..cells]);
}

/// Whether a noise event at `u` survives, given the scene's events of the cell in this interval and
/// the time at which it last fired before; all in units of the interval.
///
/// It must not come within a dead time after an event, and gives way to an event of the scene
/// within a dead time after it.
pub(super) fn awake(u: f64, scene: Option<&Train>, before: f64, r: f64) -> bool {
    let r = r * (1.0 - 1e-9);
    let Some(train) = scene else {
        return u - before >= r;
    };
    // Number of the scene's events before it.
    let passed = if u < train.first {
        0
    } else if train.spacing > 0.0 {
        (((u - train.first) / train.spacing) as u64 + 1).min(train.count)
    } else {
        train.count
    };
    let last = match passed {
        0 => before,
        n => before.max(train.at(n - 1)),
    };
    u - last >= r && (passed == train.count || train.at(passed) - u >= r)
}

/// The released simulator's trains of a row, from the distances of its cells. Returns whether all
/// could be counted. `fired` has the time at which each cell last fired, in seconds.
///
/// The operations are in the order of the published definition, in double precision, so that
/// the counts agree to the last event. Blocks of cells too near to their memory to fire take none
/// of them.
#[multiversion(targets(
    "x86_64+avx2+avx512f+avx512bw+avx512dq+avx512vl",
    "x86_64+avx2",
    "aarch64+neon"
))]
pub(crate) fn authors<R: Real>(
    interval: Interval,
    r: f64,
    (on, off): (&[R], &[R]),
    distances: &[R],
    fired: &mut [f64],
    row: &mut TrainRow<R>,
) -> bool {
    let cells = distances.len();
    let mut room = 0;
    for start in (0..cells).step_by(BLOCK) {
        let block = start..(start + BLOCK).min(cells);
        let distances = &distances[block.clone()];
        let thresholds = (&on[block.clone()], &off[block.clone()]);
        let counts = &mut row.counts[block.clone()];
        let mut reach = 0;
        for ((d, on), off) in distances.iter().zip(thresholds.0).zip(thresholds.1) {
            let (d, on, off) = (d.to_f64(), on.to_f64(), off.to_f64());
            let theta = if d >= 0.0 { on } else { off };
            let near = d.abs() + 1e-9 < theta * (1.0 - 1e-9);
            reach |= u64::from(!near);
        }
        if reach == 0 {
            counts.fill(0);
            continue;
        }
        let fired = &mut fired[block.clone()];
        let (first, spacing) = (&mut row.first[block.clone()], &mut row.spacing[block]);
        let trains = (&mut *counts, first, spacing);
        release(interval, r, thresholds, distances, fired, trains);
        for count in counts {
            room |= memory::MAX_STEPS - count.abs();
        }
    }
    room >= 0
}

/// [`authors`] of a block of cells; loads and stores as in [`lose`].
#[expect(
    clippy::inline_always,
    reason = "what is not inlined is not compiled for the wide vectors"
)]
#[inline(always)]
fn release<R: Real>(
    interval: Interval,
    r: f64,
    (on, off): (&[R], &[R]),
    distances: &[R],
    fired: &mut [f64],
    (counts, first, spacing): (&mut [i32], &mut [R], &mut [R]),
) {
    let (from, dt) = (interval.from, interval.duration());
    let cells = distances.len().min(BLOCK);
    let (on, off, fired) = (&on[..cells], &off[..cells], &mut fired[..cells]);
    let (counts, first, spacing) = (
        &mut counts[..cells],
        &mut first[..cells],
        &mut spacing[..cells],
    );
    let mut last_fired = [0.0; BLOCK];
    for x in 0..cells {
        let (d, before) = (distances[x].to_f64(), fired[x]);
        let (on, off) = (on[x].to_f64(), off[x].to_f64());
        let theta = if d >= 0.0 { on } else { off };
        let distance = d.abs();
        let since = from - before;
        let alpha = dt / ((distance + 1e-9) / theta);
        let alpha_r = ((r / alpha).floor() + 1.0) * alpha;
        let beta_r = ((r - since) / alpha).floor() * alpha;
        let beta_r = if beta_r > 0.0 { beta_r } else { 0.0 };
        // In the released code the sign of 0 is 0.
        let count = ((dt - beta_r) / alpha_r).floor();
        let fires = distance > 0.0 && alpha_r <= dt - beta_r;
        let count = if fires { count } else { 0.0 };
        let (place, step) = ((beta_r + alpha_r) / dt, alpha_r / dt);
        let last = place + step * (count - 1.0);
        let last = if last < 1.0 { last } else { 1.0 };
        let at = from + last * dt;
        last_fired[x] = if count > 0.0 { at } else { before };
        let most = f64::from(memory::MAX_STEPS) + 1.0;
        // A NaN is not counted either.
        let counted = count < most && distance < f64::INFINITY;
        let count = if counted { count } else { most };
        counts[x] = if d >= 0.0 { count } else { -count }.to_i32_in_range();
        (first[x], spacing[x]) = (R::from_f64(place), R::from_f64(step));
    }
    fired.copy_from_slice(&last_fired[..cells]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::event::Polarity;
    use proptest::prelude::*;

    /// A second between the frames.
    const PAIR: Interval = Interval {
        index: 0,
        from: 0.0,
        to: 1.0,
    };

    /// The slow twin: one crossing after the other.
    fn one_by_one(train: Train, r: f64, since: f64) -> Vec<f64> {
        let mut last = -since;
        let mut kept = Vec::new();
        for i in 0..train.count {
            let t = train.first + train.spacing * i as f64;
            if t - last >= r * (1.0 - 1e-9) {
                kept.push(t);
                last = t;
            }
        }
        kept
    }

    proptest! {
        /// Where a block loses nothing, what is not divided gives the same bits.
        #[test]
        fn blocks_that_lose_nothing_are_the_same(
            cells in prop::collection::vec((-3i32..4, 0.0f64..1.0, 0.0f64..0.4, -0.5f64..3.0), 1..40),
            r in prop::sample::select(vec![0.001, 0.02, 0.2, 0.7]),
        ) {
            let mut row = TrainRow::<f32>::new(cells.len());
            let mut fired = Vec::new();
            for (x, (count, place, spacing, since)) in cells.iter().enumerate() {
                (row.counts[x], row.first[x], row.spacing[x]) = (*count, *place as f32, *spacing as f32);
                fired.push(if *since < 0.0 { f64::NEG_INFINITY } else { -since });
            }
            let (mut slow, mut slow_fired) = (row.clone(), fired.clone());
            dead_time(PAIR, r, &mut fired, &mut row);
            for start in (0..cells.len()).step_by(BLOCK) {
                let block = start..(start + BLOCK).min(cells.len());
                let trains = (
                    &mut slow.counts[block.clone()],
                    &mut slow.first[block.clone()],
                    &mut slow.spacing[block.clone()],
                );
                lose(PAIR, r, &mut slow_fired[block], trains);
            }
            prop_assert_eq!(&row.counts, &slow.counts);
            prop_assert_eq!(fired, slow_fired);
            for x in 0..cells.len() {
                prop_assert_eq!(row.get(x), slow.get(x));
            }
        }

        #[test]
        fn every_nth_crossing_is_kept(count in 1u64..200, place in 0.0f64..1.0, r in 0.0f64..2.0, since in 0.0f64..2.0) {
            let spacing = 0.9 / count as f64;
            let train = Train { polarity: Polarity::On, count, first: 0.1 * place, spacing };
            let slow = one_by_one(train, r, since);
            let mut row = TrainRow::<f64>::new(1);
            row.set(0, Some(train));
            let mut fired = [-since];
            dead_time(PAIR, r, &mut fired, &mut row);
            prop_assert!((fired[0] - slow.last().unwrap_or(&-since)).abs() < 1e-9);
            prop_assert_eq!(row.counts[0], slow.len() as i32);
            let fast = row.get(0);
            for (i, t) in slow.iter().enumerate() {
                prop_assert!((fast.unwrap().at(i as u64) - t).abs() < 1e-9);
            }
        }
    }

    proptest! {
        /// The slow twin: every event of the scene is looked at.
        #[test]
        fn strays_keep_their_distance(u in 0.0f64..1.0, count in 1u64..9, first in 0.0f64..0.5, spacing in 0.0f64..0.1, before in -1.0f64..0.0, r in 0.0f64..0.5) {
            let train = Train { polarity: Polarity::On, count, first, spacing };
            let far = |t: f64| if t <= u { u - t >= r } else { t - u >= r };
            let scene = (0..count).map(|i| train.at(i));
            let want = u - before >= r && scene.clone().all(far);
            // Ties are left to rounding.
            prop_assume!(scene.chain([before]).all(|t| ((u - t).abs() - r).abs() > 1e-6));
            prop_assert_eq!(awake(u, Some(&train), before, r), want);
            prop_assert_eq!(awake(u, None, before, r), u - before >= r);
        }
    }

    /// A second or so between frames, some cells just before or after the end of a dead time.
    fn pairs() -> impl Strategy<Value = Interval> {
        prop_oneof![
            Just(PAIR),
            (0.0f64..1e4, 1e-4f64..2.0).prop_map(|(from, dt)| Interval {
                index: 3,
                from,
                to: from + dt,
            })
        ]
    }

    /// Trains, by cell, and the times at which their cells last fired.
    type Trains = (Vec<(i32, u32, u32)>, Vec<f64>);

    fn bits<R: Real>(row: &TrainRow<R>, fired: &[f64]) -> Vec<(i32, u64, u64, u64)> {
        let cells = row.counts.iter().enumerate().zip(fired);
        cells
            .map(|((x, count), fired)| match row.get(x) {
                None => (0, 0, 0, fired.to_bits()),
                Some(t) => (
                    *count,
                    t.first.to_bits(),
                    t.spacing.to_bits(),
                    fired.to_bits(),
                ),
            })
            .collect()
    }

    fn left_out_of_dead_time<R: Real>(interval: Interval, r: f64, cells: &Trains) {
        let dt = interval.duration();
        let mut row = TrainRow::<R>::new(cells.0.len());
        for (x, (count, first, spacing)) in cells.0.iter().enumerate() {
            row.counts[x] = *count;
            row.first[x] = R::from_f64(f64::from(*first) / 64.0);
            row.spacing[x] = R::from_f64(f64::from(*spacing) / 1024.0);
        }
        let mut fired: Vec<f64> = cells.1.iter().map(|at| interval.from - at * dt).collect();
        let (mut own, mut own_fired) = (row.clone(), fired.clone());
        dead_time(interval, r, &mut own_fired, &mut own);
        // Each cell by itself, silent ones too.
        for (x, fired) in fired.chunks_mut(1).enumerate() {
            let (counts, first) = (&mut row.counts[x..=x], &mut row.first[x..=x]);
            lose(interval, r, fired, (counts, first, &mut row.spacing[x..=x]));
        }
        assert_eq!(bits(&own, &own_fired), bits(&row, &fired));
    }

    fn left_out_of_authors<R: Real>(interval: Interval, r: f64, distances: &[f64], since: &[f64]) {
        let dt = interval.duration();
        let cells = distances.len();
        let d: Vec<R> = distances.iter().map(|d| R::from_f64(*d)).collect();
        let (on, off) = (
            vec![R::from_f64(0.2); cells],
            vec![R::from_f64(0.15); cells],
        );
        let mut fired: Vec<f64> = since.iter().map(|at| interval.from - at * dt).collect();
        let (mut own, mut own_fired) = (TrainRow::<R>::new(cells), fired.clone());
        let counted = authors(interval, r, (&on, &off), &d, &mut own_fired, &mut own);
        let mut row = TrainRow::<R>::new(cells);
        for (x, fired) in fired.chunks_mut(1).enumerate() {
            let (counts, first) = (&mut row.counts[x..=x], &mut row.first[x..=x]);
            let trains = (counts, first, &mut row.spacing[x..=x]);
            let thresholds = (&on[x..=x], &off[x..=x]);
            release(interval, r, thresholds, &d[x..=x], fired, trains);
        }
        assert_eq!(bits(&own, &own_fired), bits(&row, &fired));
        let most = memory::MAX_STEPS.unsigned_abs();
        assert_eq!(counted, row.counts.iter().all(|n| n.unsigned_abs() <= most));
    }

    proptest! {
        /// What is silent may be left out: the same bits as cell by cell.
        #[test]
        fn silent_cells_may_be_left_out(
            interval in pairs(),
            r in prop_oneof![
                Just(0.0), Just(0.25), Just(1e-3), Just(5.0), 0.0f64..3.0, Just(1e7),
                (0u32..64).prop_map(|n| f64::from(n) / 64.0),
            ],
            cells in proptest::collection::vec(
                (
                    prop_oneof![Just(0), Just(0), Just(1), Just(-1), -4i32..4, -300i32..300],
                    0u32..=64,
                    prop_oneof![Just(0u32), 1u32..400],
                ),
                1..200,
            ),
            distances in proptest::collection::vec(
                prop_oneof![
                    -0.2f64..0.2, -2.0f64..2.0, Just(0.0), Just(0.6), Just(-0.3), Just(1e12),
                    Just(f64::NAN), Just(f64::INFINITY), Just(-0.15), Just(0.2),
                ],
                200,
            ),
            since in proptest::collection::vec(
                prop_oneof![
                    0.0f64..2.0, Just(f64::INFINITY), Just(1e7), Just(0.25),
                    (0u32..128).prop_map(|n| f64::from(n) / 64.0),
                ],
                200,
            ),
        ) {
            let n = cells.len();
            let trains = (cells, since[..n].to_vec());
            left_out_of_dead_time::<f64>(interval, r, &trains);
            left_out_of_dead_time::<f32>(interval, r, &trains);
            left_out_of_authors::<f64>(interval, r, &distances[..n], &since[..n]);
            left_out_of_authors::<f32>(interval, r, &distances[..n], &since[..n]);
        }
    }

    /// How many events the released rule makes of a distance, at 240 frames a second.
    fn released(d: f64, r: f64) -> Option<i32> {
        let interval = Interval {
            index: 0,
            from: 1.0,
            to: 1.0 + 1.0 / 240.0,
        };
        let mut row = TrainRow::new(1);
        authors(interval, r, (&[0.2], &[0.2]), &[d], &mut [0.0], &mut row).then_some(row.counts[0])
    }

    /// Facts about the released rule that were seen by running it.
    #[test]
    fn the_released_rule_has_its_quirks() {
        // Refractory above the frame interval: it never fires.
        assert_eq!(released(1.2001, 0.005), Some(0));
        // A step of six thresholds under 1 ms gives three events.
        assert_eq!(released(1.2001, 0.001), Some(3));
        assert_eq!(released(-1.2001, 0.001), Some(-3));
        // Without a refractory period it counts thresholds, ties included.
        assert_eq!(released(0.6, 0.0), Some(3));
        assert_eq!(released(0.0, 0.0), Some(0));
        assert_eq!(released(1e12, 0.0), None);
    }
}
