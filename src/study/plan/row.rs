//! Row: the cells of one row and channel, the full model's and what the plainer ones may do.

use std::sync::Arc;

use crate::reference::Description;

use super::{
    cell::{Cell, Crossing, Pair},
    fate::{Cost, Decision, Fate},
    follow::Followed,
    perturbation::Perturbation,
};

/// What holds for all cells.
#[derive(Debug)]
pub(super) struct Rules {
    models: Vec<Perturbation>,
    /// For each channel the largest of each part of all models.
    largest: Perturbation,
    /// The dead time in seconds; 0 for none.
    dead: f64,
    /// An event that is off by more has lost its partner, in seconds.
    within: f64,
}

/// One row of one channel.
#[derive(Debug)]
pub(super) struct Row {
    rules: Arc<Rules>,
    cells: Vec<Cell>,
    equal: bool,
    /// For each model.
    beside: Vec<Beside>,
    sums: Followed,
    /// The crossings of a cell in a pair: when, whether it is an event, and how long after the
    /// last event.
    crossings: Vec<Crossing>,
}

/// One plainer model.
#[derive(Debug)]
struct Beside {
    fates: Vec<Fate>,
    /// Until when the two models may differ in which crossings are events.
    unsure: Vec<f64>,
    /// By how much the last event may be off, in seconds.
    slack: Vec<f64>,
    free: f64,
    dead: f64,
}

impl Rules {
    pub(super) fn of(description: &Description, models: &[Perturbation], within: f64) -> Arc<Self> {
        let channels = description.channels.len();
        let mut largest = Perturbation::none(channels);
        for model in models {
            for (drive, more) in largest.drive.iter_mut().zip(&model.drive) {
                *drive = drive.max(*more);
            }
            largest.relative = largest.relative.max(model.relative);
            largest.steps = largest.steps.max(model.steps);
            largest.threshold = largest.threshold.max(model.threshold);
            largest.tie = largest.tie.max(model.tie);
            largest.most = largest.most.min(model.most);
        }
        Arc::new(Self {
            models: models.to_vec(),
            largest,
            dead: description.refractory.us * 1e-6,
            within,
        })
    }
}

impl Row {
    /// The cells at the first frame: memory, drive, thresholds and leak.
    pub(super) fn new(
        rules: &Arc<Rules>,
        [base, drive, on, off, leak]: [Vec<f64>; 5],
        equal: bool,
    ) -> Self {
        let width = base.len();
        let beside = || Beside {
            fates: vec![Fate::Sure; width],
            unsure: vec![f64::NEG_INFINITY; width],
            slack: vec![0.0; width],
            free: 0.0,
            dead: 0.0,
        };
        let levels = on.iter().zip(off.iter().zip(&leak));
        let cells = base.iter().zip(&drive).zip(levels);
        Self {
            cells: cells
                .map(|((base, drive), (on, (off, leak)))| {
                    Cell::new([*base, *drive], [*on, *off], *leak)
                })
                .collect(),
            equal,
            beside: rules.models.iter().map(|_| beside()).collect(),
            rules: Arc::clone(rules),
            sums: Followed::new(),
            crossings: Vec::new(),
        }
    }

    /// One pair of frames, with the drive at the later one; how many events it makes.
    pub(super) fn advance(&mut self, pair: Pair, drive: &[f64], channel: usize) -> u64 {
        let mut events = 0;
        for (x, drive) in drive.iter().enumerate() {
            events += self.cell(pair, x, *drive, channel);
        }
        events
    }

    fn cell(&mut self, pair: Pair, x: usize, drive: f64, channel: usize) -> u64 {
        let Self {
            rules,
            cells,
            equal,
            beside,
            sums,
            crossings,
        } = self;
        let Some(cell) = cells.get_mut(x) else {
            return 0;
        };
        let memory = cell.memory(*equal);
        let fall = cell.leak * pair.elapsed.1;
        let to = (drive - memory) + fall;
        let from = (cell.before - memory) + cell.leak * pair.elapsed.0;
        cell.before = drive;
        let largest = &rules.largest;
        let near = cell.error(largest, channel, (memory, to, fall), 0.0);
        let (theta, other) = if to >= 0.0 {
            (cell.on, cell.off)
        } else {
            (cell.off, cell.on)
        };
        let part = 1.0 - largest.threshold;
        let quiet = near + to.abs() * (1.0 + largest.threshold + largest.tie) < theta * part
            && near < other * part;
        if quiet && cell.open == 0 {
            return 0;
        }
        let count = cell.count(to);
        let kept = cell.cross(pair, (from, to), count, rules.dead, crossings, sums);
        let all = count.unsigned_abs();
        let rise = if to >= 0.0 { to - from } else { from - to };
        for (model, beside) in rules.models.iter().zip(&mut *beside) {
            let sure = beside.fates[x].is_sure();
            let ahead = if sure { 0.0 } else { Fate::FURTHEST };
            let error = cell.error(model, channel, (memory, to, fall), ahead);
            let decision = Decision {
                on: cell.on,
                off: cell.off,
                error,
                threshold: model.threshold,
                tie: model.tie,
                equal: *equal,
            };
            let cost = beside.fates[x].decide(&decision, to, count, to - from);
            match (sure, beside.fates[x].is_sure()) {
                (true, false) => cell.open += 1,
                (false, true) => cell.open -= 1,
                _ => {}
            }
            // Where the line does not rise, an event may be anywhere in the pair.
            let part = (error + to.abs() * model.threshold) / rise;
            let part = if rise > 0.0 && part < 1.0 { part } else { 1.0 };
            let off = (part + model.time) * (pair.to - pair.from);
            beside.free += if off > rules.within {
                (all + cost.events) as f64
            } else {
                cost.alone as f64
            };
            if rules.dead > 0.0 {
                beside.dead += beside.awake(x, pair.to, off, rules, cost, (crossings, kept)) as f64;
            }
        }
        cell.net += count as i32;
        cell.offs -= count.min(0) as f64;
        for (model, beside) in rules.models.iter().zip(beside) {
            // Beyond what the format holds nothing can be said.
            if (cell.base + f64::from(cell.net) * cell.on).abs() > model.most {
                (beside.free, beside.dead) = (f64::INFINITY, f64::INFINITY);
            }
        }
        kept
    }

    /// Adds what its cells did.
    pub(super) fn add_to(&self, all: &mut Followed) {
        let sums = &self.sums;
        all.crossings += sums.crossings;
        all.events += sums.events;
        all.squares += sums.squares;
        all.longest = all.longest.max(sums.longest);
        all.closest = all.closest.min(sums.closest);
        all.chains.0 += sums.chains.0;
        all.chains.1 = all.chains.1.max(sums.chains.1);
        for cell in &self.cells {
            let crossed = f64::from(cell.net) + 2.0 * cell.offs;
            all.cells.0 += crossed * crossed;
            all.cells.1 = all.cells.1.max(crossed as u64);
        }
        for (change, beside) in all.changes.iter_mut().zip(&self.beside) {
            change.free += beside.free;
            change.dead += beside.dead;
        }
    }
}

impl Beside {
    /// Events without a partner where both models have their dead time, at most: of the cell in
    /// column `x`, in a pair of frames that ends at `end`, if crossings are off by at most `off`
    /// seconds.
    ///
    /// Two cells with the same crossings differ in their events only from where one decision
    /// may be different, until no crossing has come for a dead time: then both are ready.
    fn awake(
        &mut self,
        x: usize,
        end: f64,
        off: f64,
        rules: &Rules,
        cost: Cost,
        (crossings, kept): (&[Crossing], u64),
    ) -> u64 {
        let (unsure, slack) = (&mut self.unsure[x], &mut self.slack[x]);
        let hair = 1e-8 * rules.dead;
        if !cost.sure {
            *unsure = end + off + rules.dead + hair;
            *slack = off;
            return kept + cost.events;
        }
        let mut alone = 0;
        for Crossing { at, event, since } in crossings {
            let near = (since - rules.dead).abs() <= off + *slack + hair;
            if near || *at < *unsure + off {
                alone += 1;
                *unsure = unsure.max(at + off + rules.dead + hair);
            }
            if *event {
                *slack = off;
            }
        }
        if off > rules.within {
            kept + cost.events
        } else {
            alone
        }
    }
}
