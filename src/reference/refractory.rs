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

/// Cells that are worked on at a time.
const LANES: usize = 8;

/// How much further than their rounding quotients are kept from a whole number, where a product
/// with a reciprocal stands for a division.
const CLOSE: f64 = 1e-14;

/// Removes the events of a row of trains that a dead time of `seconds` loses; `fired` has the time
/// at which each cell last fired, in seconds.
///
/// Division takes most of the time. Cells that are silent need none, and whole numbers of spacings
/// are found by reciprocals where rounding cannot matter: the same bits as [`DeadTime::exact`].
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
pub(crate) fn dead_time<R: Real>(
    interval: Interval,
    seconds: f64,
    fired: &mut [f64],
    row: &mut TrainRow<R>,
) {
    let dt = interval.duration();
    let rule = DeadTime {
        from: interval.from,
        dt,
        per_dt: 1.0 / dt,
        // The tolerance keeps a crossing that rounding puts just before the end of the dead time.
        r: seconds / dt * (1.0 - 1e-9),
    };
    let cells = fired.len();
    let (counts, rest) = row.counts[..cells].as_chunks_mut::<LANES>();
    let (first, rest_first) = row.first[..cells].as_chunks_mut::<LANES>();
    let (spacing, rest_spacing) = row.spacing[..cells].as_chunks_mut::<LANES>();
    let (fired, rest_fired) = fired.as_chunks_mut::<LANES>();
    let places = first.iter_mut().zip(spacing);
    for ((counts, fired), (first, spacing)) in counts.iter_mut().zip(fired).zip(places) {
        let mut any = 0;
        for count in &*counts {
            any |= count.unsigned_abs();
        }
        if any == 0 {
            continue;
        }
        let done = if any == 1 {
            rule.single(counts, first, spacing, fired)
        } else {
            rule.quick(counts, first, spacing, fired)
        };
        if !done {
            rule.exact(counts, first, spacing, fired);
        }
    }
    rule.exact(rest, rest_first, rest_spacing, rest_fired);
}

/// A dead time in an interval.
#[derive(Clone, Copy)]
struct DeadTime {
    from: f64,
    dt: f64,
    /// `1 / dt`.
    per_dt: f64,
    /// The dead time, in intervals.
    r: f64,
}

// What is not inlined is not compiled for the wide vectors.
#[allow(clippy::inline_always)]
impl DeadTime {
    /// What is left of the dead time at the place of a train's first event, and how far that may
    /// be wrong.
    #[inline(always)]
    fn wait(self, fired: f64, place: f64) -> (f64, f64) {
        let since = (self.from - fired) * self.per_dt;
        let known = if since < 1e6 { since } else { 1e6 };
        (self.r - since - place, CLOSE * (1.0 + self.r + known))
    }

    /// Cells that fire once, or not: their event is kept or lost. Returns whether that is sure;
    /// otherwise nothing is done.
    #[inline(always)]
    fn single<R: Real>(
        self,
        counts: &mut [i32; LANES],
        first: &mut [R; LANES],
        spacing: &mut [R; LANES],
        fired: &mut [f64; LANES],
    ) -> bool {
        let mut sure = self.r < 1e6;
        let mut kept = [false; LANES];
        for x in 0..LANES {
            let (wait, close) = self.wait(fired[x], first[x].to_f64());
            sure &= wait.abs() > close || counts[x] == 0;
            kept[x] = wait < 0.0 && counts[x] != 0;
        }
        if !sure {
            return false;
        }
        for x in 0..LANES {
            let place = first[x].to_f64();
            let last = if place < 1.0 { place } else { 1.0 };
            let at = self.from + last * self.dt;
            fired[x] = if kept[x] { at } else { fired[x] };
            counts[x] = if kept[x] { counts[x] } else { 0 };
            spacing[x] = R::ZERO;
        }
        true
    }

    /// Any cells, of which none keeps some events and loses others between them. Returns whether
    /// they are such, and all is sure; otherwise nothing is done.
    #[inline(always)]
    fn quick<R: Real>(
        self,
        counts: &mut [i32; LANES],
        first: &mut [R; LANES],
        spacing: &mut [R; LANES],
        fired: &mut [f64; LANES],
    ) -> bool {
        let mut sure = self.r < 1e6;
        let (mut skips, mut keeps) = ([0.0; LANES], [0.0; LANES]);
        for x in 0..LANES {
            let (place, step) = (first[x].to_f64(), spacing[x].to_f64());
            let all = f64::from(counts[x]).abs();
            let (wait, close) = self.wait(fired[x], place);
            let per = 1.0 / step;
            let skip = ((wait + close) * per).ceil();
            let waits = wait > 0.0;
            let is_sure = wait.abs() > close && (!waits || ((wait - close) * per).ceil() == skip);
            let skip = if waits { skip } else { 0.0 };
            // Below one spacing nothing is lost between two events, and above all of them all is.
            let left = all - skip;
            let stride = self.r * per;
            let none = stride < 1.0 - CLOSE;
            let one = left <= 1.0 || stride > left - 1.0 + CLOSE * left;
            sure &= (is_sure && (none || one)) || all == 0.0;
            let kept = if none { left } else { 1.0 };
            (skips[x], keeps[x]) = (skip, if left > 0.0 { kept } else { 0.0 });
        }
        if !sure {
            return false;
        }
        for x in 0..LANES {
            let (place, step) = (first[x].to_f64(), spacing[x].to_f64());
            let (skip, kept) = (skips[x], keeps[x]);
            let place = place + if skip > 0.0 { step * skip } else { 0.0 };
            let step = if kept > 1.0 { step } else { 0.0 };
            let last = place + step * (kept - 1.0);
            let last = if last < 1.0 { last } else { 1.0 };
            let at = self.from + last * self.dt;
            fired[x] = if kept > 0.0 { at } else { fired[x] };
            counts[x] = if counts[x] < 0 { -kept } else { kept }.to_i32_in_range();
            (first[x], spacing[x]) = (R::from_f64(place), R::from_f64(step));
        }
        true
    }

    /// Any cells: the definition.
    ///
    /// Division by a spacing of 0, of a train that is one event, gives infinity, as it should. No
    /// branch depends on the cells, so that the loop is vectorised.
    #[inline(always)]
    fn exact<R: Real>(
        self,
        counts: &mut [i32],
        first: &mut [R],
        spacing: &mut [R],
        fired: &mut [f64],
    ) {
        let Self { from, dt, r, .. } = self;
        let cells = counts.len();
        let (first, spacing, fired) = (
            &mut first[..cells],
            &mut spacing[..cells],
            &mut fired[..cells],
        );
        for x in 0..cells {
            let (place, step) = (first[x].to_f64(), spacing[x].to_f64());
            let all = f64::from(counts[x]);
            let wait = r - (from - fired[x]) / dt - place;
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
            fired[x] = if kept > 0.0 {
                from + last * dt
            } else {
                fired[x]
            };
            counts[x] = if all < 0.0 { -kept } else { kept }.to_i32_in_range();
            (first[x], spacing[x]) = (R::from_f64(place), R::from_f64(step));
        }
    }
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
/// the counts agree to the last event. Cells too near to their memory to fire take none of them.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
pub(crate) fn authors<R: Real>(
    interval: Interval,
    r: f64,
    (on, off): (&[R], &[R]),
    distances: &[R],
    fired: &mut [f64],
    row: &mut TrainRow<R>,
) -> bool {
    let rule = Authors {
        from: interval.from,
        dt: interval.duration(),
        per_dt: 1.0 / interval.duration(),
        r,
    };
    let cells = distances.len();
    let (counts, rest) = row.counts[..cells].as_chunks_mut::<LANES>();
    let (first, rest_first) = row.first[..cells].as_chunks_mut::<LANES>();
    let (spacing, rest_spacing) = row.spacing[..cells].as_chunks_mut::<LANES>();
    let (fired, rest_fired) = fired[..cells].as_chunks_mut::<LANES>();
    let (on, rest_on) = on[..cells].as_chunks::<LANES>();
    let (off, rest_off) = off[..cells].as_chunks::<LANES>();
    let (distances, rest_distances) = distances.as_chunks::<LANES>();
    let mut room = 0;
    let seen = distances.iter().zip(on.iter().zip(off));
    let places = counts.iter_mut().zip(first.iter_mut().zip(spacing));
    for (((d, (on, off)), fired), (counts, (first, spacing))) in seen.zip(fired).zip(places) {
        let mut near = true;
        for x in 0..LANES {
            let distance = d[x].to_f64();
            let theta = if distance >= 0.0 { on[x] } else { off[x] }.to_f64();
            near &= distance.abs() + 1e-9 < theta * (1.0 - 1e-9);
        }
        if near {
            *counts = [0; LANES];
            continue;
        }
        let mut trains = (&mut *counts, &mut *first, &mut *spacing);
        if !rule.quick(d, (on, off), fired, &mut trains) {
            rule.exact(d, (on, off), fired, (&mut *counts, first, spacing));
        }
        for count in counts {
            room |= memory::MAX_STEPS - count.abs();
        }
    }
    let trains = (&mut *rest, rest_first, rest_spacing);
    rule.exact(rest_distances, (rest_on, rest_off), rest_fired, trains);
    for count in rest {
        room |= memory::MAX_STEPS - count.abs();
    }
    room >= 0
}

/// The released rule in an interval.
#[derive(Clone, Copy)]
struct Authors {
    from: f64,
    dt: f64,
    /// `1 / dt`.
    per_dt: f64,
    /// The refractory period, in seconds.
    r: f64,
}

// What is not inlined is not compiled for the wide vectors.
#[allow(clippy::inline_always)]
impl Authors {
    /// Cells that none is still silent of, with as few divisions as give the same bits. Returns
    /// whether they are such, and all is sure; otherwise nothing is done.
    #[inline(always)]
    fn quick<R: Real>(
        self,
        distances: &[R; LANES],
        (on, off): (&[R; LANES], &[R; LANES]),
        fired: &mut [f64; LANES],
        (counts, first, spacing): &mut (&mut [i32; LANES], &mut [R; LANES], &mut [R; LANES]),
    ) -> bool {
        let Self {
            from,
            dt,
            per_dt,
            r,
        } = self;
        let mut sure = true;
        let (mut wholes, mut steps) = ([0.0; LANES], [0.0; LANES]);
        for x in 0..LANES {
            let d = distances[x].to_f64();
            let theta = if d >= 0.0 { on[x] } else { off[x] }.to_f64();
            let distance = d.abs();
            let quotient = (distance + 1e-9) / theta;
            let alpha = dt / quotient;
            // How many alphas there are in the refractory period, and in what is left of it.
            let per = per_dt * quotient;
            let periods = (r * per * (1.0 + CLOSE)).floor();
            sure &= (r * per * (1.0 - CLOSE)).floor() == periods;
            let since = from - fired[x];
            sure &= (r - since) * per < 1.0 - 1e-9;
            sure &= quotient < 1e9;
            let alpha_r = (periods + 1.0) * alpha;
            let fires = distance > 0.0 && alpha_r <= dt;
            wholes[x] = if fires { (dt / alpha_r).floor() } else { 0.0 };
            steps[x] = alpha_r / dt;
        }
        if !sure {
            return false;
        }
        for x in 0..LANES {
            let (count, step) = (wholes[x], steps[x]);
            let last = step + step * (count - 1.0);
            let last = if last < 1.0 { last } else { 1.0 };
            let at = from + last * dt;
            fired[x] = if count > 0.0 { at } else { fired[x] };
            let is_on = distances[x] >= R::ZERO;
            counts[x] = if is_on { count } else { -count }.to_i32_in_range();
            (first[x], spacing[x]) = (R::from_f64(step), R::from_f64(step));
        }
        true
    }

    /// Any cells: the definition.
    #[inline(always)]
    fn exact<R: Real>(
        self,
        distances: &[R],
        (on, off): (&[R], &[R]),
        fired: &mut [f64],
        (counts, first, spacing): (&mut [i32], &mut [R], &mut [R]),
    ) {
        let Self { from, dt, r, .. } = self;
        let cells = distances.len();
        let (on, off, fired) = (&on[..cells], &off[..cells], &mut fired[..cells]);
        let (counts, first, spacing) = (
            &mut counts[..cells],
            &mut first[..cells],
            &mut spacing[..cells],
        );
        for x in 0..cells {
            let d = distances[x].to_f64();
            let theta = if d >= 0.0 { on[x] } else { off[x] }.to_f64();
            let distance = d.abs();
            let since = from - fired[x];
            let alpha = dt / ((distance + 1e-9) / theta);
            let alpha_r = ((r / alpha).floor() + 1.0) * alpha;
            let beta_r = ((r - since) / alpha).floor() * alpha;
            let beta_r = if beta_r > 0.0 { beta_r } else { 0.0 };
            // In the released code the sign of 0 is 0.
            let fires = distance > 0.0 && alpha_r <= dt - beta_r;
            let count = if fires {
                ((dt - beta_r) / alpha_r).floor()
            } else {
                0.0
            };
            let (place, step) = ((beta_r + alpha_r) / dt, alpha_r / dt);
            let last = place + step * (count - 1.0);
            let last = if last < 1.0 { last } else { 1.0 };
            fired[x] = if count > 0.0 {
                from + last * dt
            } else {
                fired[x]
            };
            let most = f64::from(memory::MAX_STEPS) + 1.0;
            // A NaN is not counted either.
            let counted = count < most && distance < f64::INFINITY;
            let count = if counted { count } else { most };
            counts[x] = if d >= 0.0 { count } else { -count }.to_i32_in_range();
            (first[x], spacing[x]) = (R::from_f64(place), R::from_f64(step));
        }
    }
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
        prop_oneof![Just(PAIR), (0.0f64..1e4, 1e-4f64..2.0).prop_map(|(from, dt)| Interval {
            index: 3,
            from,
            to: from + dt,
        })]
    }

    /// Trains, by cell, and the times at which their cells last fired.
    type Trains = (Vec<(i32, u32, u32)>, Vec<f64>);

    fn bits<R: Real>(row: &TrainRow<R>, fired: &[f64]) -> Vec<(i32, u64, u64, u64)> {
        let cells = row.counts.iter().enumerate().zip(fired);
        cells
            .map(|((x, count), fired)| match row.get(x) {
                None => (0, 0, 0, fired.to_bits()),
                Some(t) => (*count, t.first.to_bits(), t.spacing.to_bits(), fired.to_bits()),
            })
            .collect()
    }

    fn short_ways_of_dead_time<R: Real>(interval: Interval, r: f64, cells: &Trains) {
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
        let rule = DeadTime {
            from: interval.from,
            dt,
            per_dt: 1.0 / dt,
            r: r / dt * (1.0 - 1e-9),
        };
        let TrainRow { counts, first, spacing, .. } = &mut row;
        rule.exact(counts, first, spacing, &mut fired);
        assert_eq!(bits(&own, &own_fired), bits(&row, &fired));
    }

    fn short_ways_of_authors<R: Real>(interval: Interval, r: f64, distances: &[f64], since: &[f64]) {
        let dt = interval.duration();
        let cells = distances.len();
        let d: Vec<R> = distances.iter().map(|d| R::from_f64(*d)).collect();
        let (on, off) = (vec![R::from_f64(0.2); cells], vec![R::from_f64(0.15); cells]);
        let mut fired: Vec<f64> = since.iter().map(|at| interval.from - at * dt).collect();
        let (mut own, mut own_fired) = (TrainRow::<R>::new(cells), fired.clone());
        let counted = authors(interval, r, (&on, &off), &d, &mut own_fired, &mut own);
        let mut row = TrainRow::<R>::new(cells);
        let rule = Authors {
            from: interval.from,
            dt,
            per_dt: 1.0 / dt,
            r,
        };
        let TrainRow { counts, first, spacing, .. } = &mut row;
        rule.exact(&d, (&on, &off), &mut fired, (counts, first, spacing));
        assert_eq!(bits(&own, &own_fired), bits(&row, &fired));
        let most = memory::MAX_STEPS.unsigned_abs();
        assert_eq!(counted, row.counts.iter().all(|n| n.unsigned_abs() <= most));
    }

    proptest! {
        /// The short ways give the same bits, ties and cells that never fired among them.
        #[test]
        fn short_ways_are_the_definition(
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
                1..40,
            ),
            distances in proptest::collection::vec(
                prop_oneof![
                    -0.2f64..0.2, -2.0f64..2.0, Just(0.0), Just(0.6), Just(-0.3), Just(1e12),
                    Just(f64::NAN), Just(f64::INFINITY), Just(-0.15), Just(0.2),
                ],
                40,
            ),
            since in proptest::collection::vec(
                prop_oneof![
                    0.0f64..2.0, Just(f64::INFINITY), Just(1e7), Just(0.25),
                    (0u32..128).prop_map(|n| f64::from(n) / 64.0),
                ],
                40,
            ),
        ) {
            let n = cells.len();
            let trains = (cells, since[..n].to_vec());
            short_ways_of_dead_time::<f64>(interval, r, &trains);
            short_ways_of_dead_time::<f32>(interval, r, &trains);
            short_ways_of_authors::<f64>(interval, r, &distances[..n], &since[..n]);
            short_ways_of_authors::<f32>(interval, r, &distances[..n], &since[..n]);
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
