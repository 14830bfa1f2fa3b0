//! Cell: one of the full model, step by step as the reference has it.

use super::{fate::Decision, follow::Followed, perturbation::Perturbation};

/// Two frames, in seconds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair {
    pub(super) from: f64,
    pub(super) to: f64,
    /// Since the first frame.
    pub(super) elapsed: (f64, f64),
}

/// A cell of the full model.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    pub(super) base: f64,
    pub(super) on: f64,
    pub(super) off: f64,
    /// How far the memory falls in a second.
    pub(super) leak: f64,
    /// ON steps less OFF steps, and OFF steps.
    pub(super) net: i32,
    pub(super) offs: f64,
    pub(super) before: f64,
    /// Times of the last event and of the last crossing, in seconds.
    pub(super) fired: f64,
    pub(super) crossed: f64,
    /// The last crossings that are less than a dead time apart: how many, when the pair of
    /// frames of the last began, and for how many seconds before it a stray event could have
    /// changed which of them are events.
    pub(super) chain: u64,
    pub(super) began: f64,
    pub(super) exposed: f64,
    /// Models in which more than the cell's own state is possible.
    pub(super) open: u32,
}

/// Where its drive crosses a threshold.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crossing {
    pub(super) at: f64,
    pub(super) event: bool,
    pub(super) since: f64,
}

impl Cell {
    /// A cell at the first frame: memory and drive, ON and OFF threshold, leak.
    pub(super) const fn new([base, before]: [f64; 2], [on, off]: [f64; 2], leak: f64) -> Self {
        Self {
            base,
            on,
            off,
            leak,
            net: 0,
            offs: 0.0,
            before,
            fired: f64::NEG_INFINITY,
            crossed: f64::NEG_INFINITY,
            chain: 0,
            began: f64::NEG_INFINITY,
            exposed: 0.0,
            open: 0,
        }
    }

    /// As the reference has it, operation by operation.
    pub(super) fn memory(&self, equal: bool) -> f64 {
        let memory = self.base + f64::from(self.net) * self.on;
        if equal {
            memory
        } else {
            memory + self.offs * (self.on - self.off)
        }
    }

    /// As the reference counts: whole thresholds, ties among them.
    pub(super) fn count(&self, distance: f64) -> i64 {
        Decision::exact(self.on, self.off, self.on == self.off).count(distance)
    }

    /// `E` of `docs/fidelity.md`: how far the distance of a cell that is at most so many
    /// thresholds `ahead` can be off.
    pub(super) fn error(
        &self,
        model: &Perturbation,
        channel: usize,
        (memory, distance, fall): (f64, f64, f64),
        ahead: f64,
    ) -> f64 {
        let both = self.on + self.off;
        let ups = f64::from(self.net) + self.offs;
        let way = ups * self.on + self.offs * both;
        model.drive[channel]
            + model.relative * (memory.abs() + distance.abs() + 2.0 * fall + 2.0 * ahead * both)
            + model.steps * (way + 2.0 * ahead * both)
    }

    /// Where its line from one distance to another crosses the next `count` levels, and which
    /// crossings are events; how many are.
    pub(super) fn cross(
        &mut self,
        pair: Pair,
        (from, to): (f64, f64),
        count: i64,
        dead: f64,
        crossings: &mut Vec<Crossing>,
        sums: &mut Followed,
    ) -> u64 {
        crossings.clear();
        let (theta, start) = if to >= 0.0 {
            (self.on, from)
        } else {
            (self.off, -from)
        };
        let rise = to.abs() - start;
        let mut kept = 0;
        for i in 1..=count.unsigned_abs() {
            let place = (theta * i as f64 - start) / rise;
            // Where the line does not rise, the crossing is seen at the frame.
            let place = if rise > 0.0 && place < 1.0 {
                place.max(0.0)
            } else {
                1.0
            };
            let at = pair.from + place * (pair.to - pair.from);
            let since = at - self.fired;
            let event = since >= dead * (1.0 - 1e-9);
            if event {
                sums.closest = sums.closest.min(since);
                self.fired = at;
                kept += 1;
            }
            if at - self.crossed >= dead {
                self.chain = 0;
                self.exposed = (dead - (at - pair.from)).max(0.0);
            } else {
                self.exposed += pair.from - self.began;
            }
            (self.crossed, self.began) = (at, pair.from);
            self.chain += 1;
            sums.chains.0 += self.exposed;
            sums.chains.1 = sums.chains.1.max(self.chain);
            crossings.push(Crossing { at, event, since });
        }
        sums.crossings += count.unsigned_abs();
        sums.events += kept;
        sums.squares += (kept * kept) as f64;
        sums.longest = sums.longest.max(kept);
        kept
    }
}
