//! Fate: what may become of one cell of the plainer model, followed beside the full one.
//!
//! A memory that steps is where it began and whole steps: `a` up, `b` down. The plainer cell's
//! steps are never guessed: all that are possible are followed, as differences from the full
//! cell's. As long as there is only one possibility, and it is the full cell's own, the cell's
//! events are the same. Where a distance is so near a threshold that the plainer model may
//! decide otherwise, both are followed, until they come together again, as they do when the
//! light goes on. What is possible in a pair of frames and most unlike the full cell is what
//! the bound counts.

use crate::number::Real;

/// Possibilities that are followed. A cell with more is lost.
const MOST: usize = 8;

/// How far one possibility is from the full cell: more ON steps, more OFF steps.
type Ahead = (i32, i32);

/// What is possible at a frame.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) enum Fate {
    /// The full cell's own state and nothing else.
    #[default]
    Sure,
    /// The full cell's own state, or one of these.
    Among(Vec<Ahead>),
    /// Nothing is known but that the memory is within a threshold of the drive.
    Lost,
}

/// How the plainer cell decides, in the unit of the drive.
#[derive(Clone, Copy, Debug)]
pub(super) struct Decision {
    /// ON and OFF thresholds of the full cell.
    pub(super) on: f64,
    pub(super) off: f64,
    /// By how much the distance can be off.
    pub(super) error: f64,
    /// By how much a threshold can be off, as a part of it.
    pub(super) threshold: f64,
    /// What counts as a tie.
    pub(super) tie: f64,
    /// Whether an ON step and an OFF step are of one size, in both models.
    pub(super) equal: bool,
}

/// What a pair of frames may have cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Cost {
    /// Events of either model without a partner in the other, at most.
    pub(super) alone: u64,
    /// Events of the plainer model, at most.
    pub(super) events: u64,
    /// Whether the plainer cell certainly did what the full one did, from the same state.
    pub(super) sure: bool,
}

impl Decision {
    /// The full cell's own.
    pub(super) const fn exact(on: f64, off: f64, equal: bool) -> Self {
        Self {
            on,
            off,
            error: 0.0,
            threshold: 0.0,
            tie: f64::TIE,
            equal,
        }
    }

    /// Thresholds that a distance counts, with its sign, at least and at most.
    fn counts(&self, distance: f64) -> (i64, i64) {
        let off = (self.error + distance.abs() * self.threshold) / (1.0 - self.threshold);
        (self.count(distance - off), self.count(distance + off))
    }

    /// As the reference counts, with this tie.
    pub(super) fn count(&self, distance: f64) -> i64 {
        let theta = if distance >= 0.0 { self.on } else { self.off };
        let quotient = distance.abs() / theta;
        let whole = (quotient + (quotient * self.tie).min(0.5)).floor() as i64;
        if distance >= 0.0 { whole } else { -whole }
    }
}

impl Fate {
    /// No possibility is more thresholds of either sign ahead: such a cell is lost.
    pub(super) const FURTHEST: f64 = 64.0;

    /// Whether only the full cell's own state is possible.
    pub(super) const fn is_sure(&self) -> bool {
        matches!(self, Self::Sure)
    }

    /// One pair of frames, at whose end the full cell's distance is `distance` before it takes
    /// `taken` steps. `change` is what the drive has changed by, for a cell that is lost.
    pub(super) fn decide(
        &mut self,
        decision: &Decision,
        distance: f64,
        taken: i64,
        change: f64,
    ) -> Cost {
        let (least, most) = decision.counts(distance);
        let own = (least.min(taken), most.max(taken));
        if self.is_sure() && own == (taken, taken) {
            return Cost {
                alone: 0,
                events: taken.unsigned_abs(),
                sure: true,
            };
        }
        if *self == Self::Lost {
            return lost(decision, taken, change);
        }
        let mut states = vec![(0, 0)];
        if let Self::Among(others) = self {
            states.extend(others.iter().copied());
        }
        let mut next: Vec<Ahead> = Vec::new();
        let mut cost = Cost::default();
        for ahead in states {
            let (on, off) = (f64::from(ahead.0), f64::from(ahead.1));
            let there = distance - on * decision.on + off * decision.off;
            let (least, most) = if ahead == (0, 0) {
                own
            } else {
                decision.counts(there)
            };
            if most - least > MOST as i64 || next.len() > MOST {
                *self = Self::Lost;
                return lost(decision, taken, change);
            }
            for steps in least..=most {
                cost.alone = cost.alone.max(decision.alone(ahead, taken, steps));
                cost.events = cost.events.max(steps.unsigned_abs());
                let state = decision.named((
                    ahead.0 + (steps.max(0) - taken.max(0)) as i32,
                    ahead.1 + (steps.min(0).abs() - taken.min(0).abs()) as i32,
                ));
                if f64::from(state.0.abs().max(state.1.abs())) > Self::FURTHEST {
                    *self = Self::Lost;
                    return lost(decision, taken, change);
                }
                if state != (0, 0) && !next.contains(&state) {
                    next.push(state);
                }
            }
        }
        *self = if next.is_empty() {
            Self::Sure
        } else if next.len() > MOST {
            Self::Lost
        } else {
            Self::Among(next)
        };
        cost
    }
}

impl Decision {
    /// One name for each state: where the steps are of one size, only their difference counts.
    const fn named(&self, ahead: Ahead) -> Ahead {
        if self.equal {
            (ahead.0 - ahead.1, 0)
        } else {
            ahead
        }
    }

    /// Events without a partner where the full cell takes `taken` steps and one that is `ahead`
    /// of it takes `steps`.
    ///
    /// Steps of one direction are crossings of levels. Where the levels of the two are the same
    /// ones, those that both cross have a partner.
    fn alone(&self, ahead: Ahead, taken: i64, steps: i64) -> u64 {
        let all = taken.unsigned_abs() + steps.unsigned_abs();
        if ahead == (0, 0) && taken == steps {
            return 0;
        }
        // How far ahead in the direction of the steps, and against it.
        let (along, against) = if taken > 0 {
            (ahead.0, ahead.1)
        } else {
            (ahead.1, ahead.0)
        };
        let (along, against) = if self.equal {
            (along - against, 0)
        } else {
            (along, against)
        };
        if taken.signum() != steps.signum() || against != 0 {
            return all;
        }
        // Levels 1 to |taken|, and along + 1 to along + |steps|.
        let (start, end) = (i64::from(along), i64::from(along) + steps.abs());
        let both = taken.abs().min(end) - start.max(0);
        all - 2 * both.max(0).unsigned_abs()
    }
}

/// A cell of which nothing is known: its memory was within a threshold of the drive.
fn lost(decision: &Decision, taken: i64, change: f64) -> Cost {
    let Decision {
        on,
        off,
        error,
        threshold,
        ..
    } = *decision;
    let most = change.abs() + 2.0 * error + on.max(off) * (1.0 + threshold);
    let least = on.min(off) * (1.0 - threshold).max(0.01);
    let events = (most / least * (1.0 + decision.tie)).floor() as u64;
    Cost {
        alone: taken.unsigned_abs() + events,
        events,
        sure: false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The plainer cell itself, with one error of its distance at each frame.
    fn run(decision: &Decision, drives: &[f64], errors: &[f64]) -> Vec<i64> {
        let (mut on, mut off) = (0.0, 0.0);
        let mut counts = Vec::new();
        for (drive, error) in drives.iter().zip(errors) {
            let memory = on * decision.on - off * decision.off;
            let count = decision.count(drive - memory + error * decision.error);
            on += count.max(0) as f64;
            off += count.min(0).abs() as f64;
            counts.push(count);
        }
        counts
    }

    proptest! {
        /// Whatever the errors are, the counts differ by no more than what the fate allows.
        #[test]
        fn no_cell_is_off_by_more(
            steps in proptest::collection::vec(-0.7f64..0.7, 1..40),
            errors in proptest::collection::vec(-1.0f64..1.0, 40),
            error in proptest::sample::select(vec![1e-6, 1e-3, 0.03, 0.3]),
            equal: bool,
            rough: bool,
        ) {
            let off = if equal { 0.2 } else { 0.13 };
            let decision = Decision { on: 0.2, off, error, threshold: 0.0, tie: 1e-12, equal };
            let mut drive = 0.0;
            let drives: Vec<f64> = steps.iter().map(|step| {
                // Rough drives stand near thresholds again and again.
                drive += if rough { (step * 10.0).round() / 10.0 } else { *step };
                drive
            }).collect();
            let full = run(&Decision { error: 0.0, ..decision }, &drives, &errors);
            let plain = run(&decision, &drives, &errors);
            let (mut fate, mut memory) = (Fate::Sure, 0.0);
            let (mut bound, mut change) = (0, 0);
            let mut before = 0.0;
            for ((drive, full), plain) in drives.iter().zip(&full).zip(&plain) {
                let cost = fate.decide(&decision, drive - memory, *full, drive - before);
                memory += if *full > 0 { *full as f64 * 0.2 } else { *full as f64 * off };
                before = *drive;
                bound += cost.alone;
                change += (full - plain).unsigned_abs();
                prop_assert!(plain.unsigned_abs() <= cost.events);
                prop_assert!((full - plain).unsigned_abs() <= cost.alone);
                prop_assert!(!cost.sure || full == plain);
            }
            prop_assert!(change <= bound);
        }
    }

    #[test]
    fn a_near_miss_comes_together_again() {
        let decision = Decision {
            on: 1.0,
            off: 1.0,
            error: 0.01,
            threshold: 0.0,
            tie: 0.0,
            equal: true,
        };
        let mut fate = Fate::Sure;
        assert_eq!(fate.decide(&decision, 0.995, 0, 0.995).alone, 1);
        assert!(!fate.is_sure());
        // The light goes on: both have crossed one.
        assert_eq!(fate.decide(&decision, 1.5, 1, 0.505).alone, 1);
        assert!(fate.is_sure());
        assert!(fate.decide(&decision, 0.5, 0, 0.0).sure);
    }
}
