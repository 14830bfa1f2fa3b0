//! Refractory: how long a cell is silent after an event.
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

use crate::event::Polarity;

use super::train::Train;

/// What a dead time leaves of a train.
///
/// `r` and `since` (the time from the last event to the earlier frame) are in units of the
/// pair's duration. `None` when all is lost.
pub(super) fn dead_time(train: Train, r: f64, since: f64) -> Option<Train> {
    if r <= 0.0 {
        return Some(train);
    }
    // A crossing that rounding puts a hair before the end of the dead time is kept.
    let r = r * (1.0 - 1e-9);
    let wait = r - since - train.first;
    let skip = if wait <= 0.0 {
        0
    } else if train.spacing > 0.0 {
        (wait / train.spacing).ceil() as u64
    } else {
        return None;
    };
    if skip >= train.count {
        return None;
    }
    let left = train.count - skip;
    let stride = if train.spacing > 0.0 {
        (r / train.spacing).ceil().max(1.0)
    } else {
        f64::INFINITY
    };
    let count = ((left - 1) as f64 / stride) as u64 + 1;
    Some(Train {
        count,
        first: train.first + train.spacing * skip as f64,
        spacing: if count > 1 {
            train.spacing * stride
        } else {
            0.0
        },
        ..train
    })
}

/// Whether a cell is awake for a stray event at `u`, given what the scene made it fire in this
/// pair and when it fired last before; all in units of the pair's duration.
///
/// It must not come within a dead time after an event, and gives way to an event of the scene
/// within a dead time after it.
pub(super) fn awake(u: f64, scene: Option<&Train>, before: f64, r: f64) -> bool {
    let r = r * (1.0 - 1e-9);
    let Some(train) = scene else {
        return u - before >= r;
    };
    // How many of the scene's events lie before.
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

/// The released simulator's events of one pair. Times in seconds; `since` is the time from
/// the last event to the earlier frame.
///
/// The operations are in the order of the published definition, so that the counts agree to
/// the last event.
pub(super) fn authors(d: f64, (on, off): (f64, f64), dt: f64, r: f64, since: f64) -> Option<Train> {
    let (polarity, distance, theta) = if d >= 0.0 {
        (Polarity::On, d, on)
    } else {
        (Polarity::Off, -d, off)
    };
    // What cannot reach the threshold is most of a scene; the sign of 0 is 0 in the code.
    if distance < 0.9 * theta - 2e-9 || distance == 0.0 {
        return None;
    }
    let alpha = dt / ((distance + 1e-9) / theta);
    let alpha_r = ((r / alpha).floor() + 1.0) * alpha;
    let beta_r = (((r - since) / alpha).floor() * alpha).max(0.0);
    if alpha_r > dt - beta_r {
        return None;
    }
    let count = ((dt - beta_r) / alpha_r).floor() as u64;
    (count > 0).then_some(Train {
        polarity,
        count,
        first: (beta_r + alpha_r) / dt,
        spacing: alpha_r / dt,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

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
            match dead_time(train, r, since) {
                None => prop_assert!(slow.is_empty()),
                Some(fast) => {
                    prop_assert_eq!(fast.count, slow.len() as u64);
                    for (i, t) in slow.iter().enumerate() {
                        prop_assert!((fast.first + fast.spacing * i as f64 - t).abs() < 1e-9);
                    }
                }
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

    const THETA: (f64, f64) = (0.2, 0.2);

    /// Facts about the released rule that were seen by running it.
    #[test]
    fn the_released_rule_has_its_quirks() {
        let (dt, idle) = (1.0 / 240.0, 1.0);
        // Refractory above the frame interval: it never fires.
        assert_eq!(authors(1.2001, THETA, dt, 0.005, idle), None);
        // A step of six thresholds under 1 ms gives three events.
        assert_eq!(authors(1.2001, THETA, dt, 0.001, idle).unwrap().count, 3);
        // Without a refractory period it counts thresholds, ties included.
        assert_eq!(authors(0.6, THETA, dt, 0.0, idle).unwrap().count, 3);
        assert_eq!(authors(0.0, THETA, dt, 0.0, idle), None);
    }
}
