//! The best plan that a given effort finds: plans that need no search first, then beam searches
//! of growing width.

use rayon::prelude::*;

use super::{
    beam::{Heuristic, Task, search},
    plan_table::listed,
};
use crate::{
    compile::{
        codegen::{
            instruction_set::Buses,
            register_allocation::{Allocated, RegisterFile, allocate},
        },
        construction::{
            border_safe::border_safe_plans,
            scale::scale,
            separable::{Factor, compose, factors},
            tour::{NODES, Room, tours},
            walk::walks,
        },
        intermediate::{
            linear_form::LinearForm,
            plan::{Plan, StoreErrors, Trace, Value, values_made},
        },
    },
    order::Order,
    rng::{GOLDEN, Hash},
    stop::Stop,
};

/// Goals, and the resources for them.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::compile) struct Problem {
    pub(in crate::compile) goals: Vec<LinearForm>,
    /// The input, in units of which every weight is a whole number.
    pub(in crate::compile) unit: i64,
    /// The registers that may be used.
    pub(in crate::compile) registers: RegisterFile,
    /// The words that may be used.
    pub(in crate::compile) buses: Buses,
    /// Right up to the border, if it can be had.
    pub(in crate::compile) border: bool,
    /// Seed of the heuristics.
    pub(in crate::compile) seed: u64,
    /// States that may be looked at.
    pub(in crate::compile) states: u64,
    /// Where nothing may saturate: the range of the input, and the errors of the chip.
    pub(in crate::compile) limits: Option<Limits>,
    /// Whether the fewest words are all that is sought, so that a plan of the table of them ends it.
    pub(in crate::compile) shortest: bool,
    /// Whether to give up.
    pub(in crate::compile) stop: Stop,
}

/// The range of an input and of a register, and the errors of the chip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::compile) struct Limits {
    /// The lowest and highest input, LSB.
    pub(in crate::compile) input: (f64, f64),
    /// What remains of an odd number of halvings, which are done in pairs and one more: whether the
    /// input is negated.
    pub(in crate::compile) odd: bool,
    /// The lowest and highest value of a register, LSB.
    pub(in crate::compile) register: (f64, f64),
    pub(in crate::compile) errors: StoreErrors,
}

impl Limits {
    /// How often the input must be halved, if that helps, for nothing to saturate, transfer
    /// errors included.
    pub(in crate::compile) fn halvings(self, plan: &Plan, trace: &Trace, unit: i64) -> Option<u32> {
        let (low, high) = self.input;
        let largest = low.abs().max(high.abs());
        let mut dark = 0.0;
        for bits in 0..24 {
            if bits > 0 {
                dark = self.errors.stored(dark, true);
            }
            if self.odd && bits % 2 == 0 {
                continue;
            }
            // An odd number of halvings leaves the negated input, for which a plan of its own is
            // made.
            let input = if self.odd || bits % 2 == 0 {
                (low, high)
            } else {
                (-largest, largest)
            };
            let scale = fine(unit) * 2f64.powi(bits);
            // The negated input may be stored on the way.
            let halved = bits == 0 || largest <= self.register.1;
            if halved && self.fits_scaled((plan, trace), (input, dark), scale) {
                return Some(bits as u32);
            }
        }
        None
    }

    /// Whether nothing saturates as it is, transfer errors included.
    pub(in crate::compile) fn fits(self, plan: &Plan, trace: &Trace, unit: i64) -> bool {
        self.fits_scaled((plan, trace), (self.input, 0.0), fine(unit))
    }

    /// The same for an input of this range and constant, `scale` units of the trace large.
    fn fits_scaled(
        self,
        (plan, trace): (&Plan, &Trace),
        ((low, high), dark): ((f64, f64), f64),
        scale: f64,
    ) -> bool {
        let (lowest, highest) = self.register;
        let fits = |(form, dark): (&LinearForm, f64)| {
            let (low, high) = form.bounds(low, high);
            // Both with the errors and without: neither may be what prevents saturation.
            low / scale + dark.min(0.0) >= lowest && high / scale + dark.max(0.0) <= highest
        };
        let darks = plan.dark(dark, self.errors);
        trace.stored.iter().zip(darks).all(fits)
    }
}

/// The unit of a trace, in which every half of a plan is a whole number.
pub(in crate::compile) fn fine(unit: i64) -> f64 {
    unit as f64 * FINE as f64
}

/// A plan with its registers.
#[derive(Clone, Debug)]
pub(in crate::compile) struct Solved {
    pub(in crate::compile) plan: Plan,
    pub(in crate::compile) allocated: Allocated,
    pub(in crate::compile) border: bool,
    /// Whether with some number of halvings of the input nothing saturates, errors of the chip
    /// included.
    pub(in crate::compile) holds: bool,
    pub(in crate::compile) seen: u64,
}

/// How much finer the units of a trace are, so that every half of a plan is a whole number.
pub(in crate::compile) const FINE: i64 = 1 << 20;

impl Problem {
    /// The shortest plan that was found.
    pub(in crate::compile) fn solve(&self) -> Option<Solved> {
        self.searched(|_| 0, &mut Vec::new())
    }

    /// The shortest plan that was found, and all others that were met on the way, a little longer
    /// ones among them: which of them errs least on the chip is for others to say.
    pub(in crate::compile) fn solve_all(&self) -> (Option<Solved>, Vec<Solved>) {
        let mut all = Vec::new();
        let best = self.searched(slack, &mut all);
        (best, all)
    }

    /// Searches for plans of at most `slack` words more than the best before them.
    fn searched(&self, slack: fn(usize) -> usize, all: &mut Vec<Solved>) -> Option<Solved> {
        let mut best = self.base();
        all.extend(best.clone());
        if let [goal] = &self.goals[..]
            && let Some(proved) = listed(goal, self.unit).and_then(|plan| self.finish(plan))
            && better(&proved, best.as_ref(), self.border)
        {
            // No search can make it shorter.
            if self.shortest && self.is_sound(&proved) {
                return Some(proved);
            }
            all.push(proved.clone());
            best = Some(proved);
        }
        let mut seen = 0;
        let mut width = 4;
        for round in 0.. {
            let left = self.states.saturating_sub(seen);
            let is_over = left == 0 || self.stop.is_asked();
            if is_over || best.as_ref().is_some_and(|b| b.allocated.words.is_empty()) {
                break;
            }
            let (more, found) = self.round(round, width, (best.as_ref(), slack), left);
            seen += more;
            for solved in found {
                all.push(solved.clone());
                if better(&solved, best.as_ref(), self.border) {
                    best = Some(solved);
                }
            }
            if more == 0 {
                break;
            }
            // As wide as what is left allows, and at most twice as wide as before.
            let left = self.states.saturating_sub(seen);
            let affordable = left as u128 * width as u128 / u128::from(more);
            width = (2 * width).min((affordable as usize).max(4));
        }
        // What tours find counts where it is shorter, so that nothing becomes longer by them.
        let (more, toured) = self.toured(best.as_ref());
        seen += more;
        for solved in toured {
            if better(&solved, best.as_ref(), self.border) {
                best = Some(solved.clone());
            }
            all.push(solved);
        }
        best.map(|best| Solved { seen, ..best })
    }

    /// Whether a plan is what was asked for: right at the border if it must be, and nothing
    /// saturates.
    const fn is_sound(&self, solved: &Solved) -> bool {
        (solved.border || !self.border) && solved.holds
    }

    /// What the beam searches for.
    const fn task(
        &self,
        goals: Vec<LinearForm>,
        unit: i64,
        registers: usize,
        over_input: Option<usize>,
    ) -> Task {
        Task {
            goals,
            unit,
            registers,
            over_input,
            border: self.border,
            stop: self.stop,
        }
    }

    /// Tours that are preferred to the best of what was found, with a third more of the effort at
    /// most.
    fn toured(&self, best: Option<&Solved>) -> (u64, Vec<Solved>) {
        let order = self.order();
        let last = order.last().and_then(|goal| self.registers.into.get(*goal));
        let room = Room {
            registers: self.registers.all.len(),
            order: &order,
            over_input: last == Some(&self.registers.input),
            stop: self.stop,
        };
        let below = best.filter(|best| self.is_sound(best));
        let below = below.map(|best| best.allocated.words.len());
        let budget = self.states.saturating_mul(NODES) / 3;
        let limits = (below.unwrap_or(usize::MAX), budget);
        let (nodes, plans) = tours(&self.goals, self.unit, room, limits);
        let solved = plans.into_iter().filter_map(|plan| self.finish(plan));
        let words = |solved: &Solved| solved.allocated.words.len();
        let shorter = solved.filter(|new| {
            better(new, best, self.border) && below.is_none_or(|below| words(new) < below)
        });
        (nodes.div_ceil(NODES), shorter.collect())
    }

    /// Several searches of one beam width, in parallel.
    fn round(
        &self,
        round: u64,
        width: usize,
        (best, slack): (Option<&Solved>, fn(usize) -> usize),
        left: u64,
    ) -> (u64, Vec<Solved>) {
        let below = { best.filter(|best| self.is_sound(best)) }.map_or(usize::MAX, |best| {
            let words = best.allocated.words.len();
            words.saturating_add(slack(words))
        });
        let below = below.min(2048);
        let heuristics: Vec<Heuristic> = (0..SEARCHES)
            .map(|i| heuristic(self.seed, width, round * SEARCHES + i))
            .collect();
        let into = &self.registers.into;
        let over = into.iter().position(|it| *it == self.registers.input);
        let task = self.task(
            self.goals.clone(),
            self.unit,
            self.registers.all.len(),
            over,
        );
        let mut tries: Vec<_> = heuristics.iter().map(|tried| (&task, *tried)).collect();
        // All elsewhere, and the goal over the input brought there last.
        let elsewhere = Task {
            over_input: None,
            ..task.clone()
        };
        if task.over_input.is_some() && self.goals.len() > 1 {
            tries.extend(heuristics.iter().map(|tried| (&elsewhere, *tried)));
        }
        let share = left / 2 + 1;
        let found: Vec<_> = tries
            .par_iter()
            .map(|(task, heuristic)| {
                let found = search(task, *heuristic, below, share);
                (found.seen, found.plan.and_then(|plan| self.finish(plan)))
            })
            .collect();
        let mut seen = found.iter().map(|(seen, _)| seen).sum();
        let mut solved: Vec<Solved> = found.into_iter().filter_map(|(_, s)| s).collect();
        if self.goals.len() > 1 && seen < left {
            let (more, plan) = self.in_turn(&heuristics, (left - seen) / 2);
            seen += more;
            solved.extend(plan.and_then(|plan| self.finish(plan)));
        }
        if let (true, [goal]) = (round < FACTORED, &self.goals[..])
            && let Some(parts) = factors(goal, self.unit)
        {
            let (more, plan) = self.factored(parts, &heuristics, left.saturating_sub(seen) / 2);
            seen += more;
            solved.extend(plan.and_then(|plan| self.finish(plan)));
        }
        (seen, solved)
    }

    /// Searches for a separable kernel: the row's filter, then the column's.
    fn factored(
        &self,
        parts: [Factor; 2],
        heuristics: &[Heuristic],
        left: u64,
    ) -> (u64, Option<Plan>) {
        let found = parts.map(|(goal, unit)| {
            let task = self.task(vec![goal], unit, self.registers.all.len(), None);
            let tries = heuristics.par_iter();
            let found: Vec<_> = tries
                .map(|t| search(&task, *t, 2048, left / 2 + 1))
                .collect();
            let seen: u64 = found.iter().map(|found| found.seen).sum();
            let plans = found.into_iter().filter_map(|found| found.plan);
            (seen, plans.min_by_key(|plan| plan.words.len()))
        });
        let [(a, row), (b, column)] = found;
        let plan = row
            .zip(column)
            .and_then(|(row, column)| compose(&row, &column));
        (a + b, plan)
    }

    /// Searches for one goal after the other; the input is kept for the next, and the goal that
    /// replaces the input comes last.
    fn in_turn(&self, heuristics: &[Heuristic], left: u64) -> (u64, Option<Plan>) {
        let order = self.order();
        let tasks: Vec<(Task, usize)> = order
            .iter()
            .enumerate()
            .map(|(done, &goal)| {
                let last = done + 1 == order.len();
                let mut goals = vec![self.goals[goal].clone()];
                if !last {
                    goals.push(LinearForm::unit(self.unit));
                }
                let over = last && self.registers.into[goal] == self.registers.input;
                let registers = self.registers.all.len().saturating_sub(done);
                let task = self.task(goals, self.unit, registers, over.then_some(0));
                (task, goal)
            })
            .collect();
        let share = left / tasks.len() as u64 + 1;
        let runs: Vec<(usize, Heuristic)> = (0..tasks.len())
            .flat_map(|task| heuristics.iter().map(move |heuristic| (task, *heuristic)))
            .collect();
        let found: Vec<_> = runs
            .par_iter()
            .map(|(task, heuristic)| search(&tasks[*task].0, *heuristic, 2048, share))
            .collect();
        let seen = found.iter().map(|f| f.seen).sum();
        let mut parts = Vec::new();
        for (i, (_, goal)) in tasks.iter().enumerate() {
            let own = runs.iter().zip(&found).filter(|((task, _), _)| *task == i);
            let plans = own.filter_map(|(_, found)| found.plan.clone());
            let Some(plan) = plans.min_by_key(|plan| plan.words.len()) else {
                return (seen, None);
            };
            parts.push((*goal, plan));
        }
        (seen, Some(self.joined(parts)))
    }

    /// The goal over the input comes last.
    fn order(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.goals.len()).collect();
        order.order_by_key(|goal| self.registers.into[*goal] == self.registers.input);
        order
    }

    /// Plans of single goals, one after the other.
    fn joined(&self, parts: Vec<(usize, Plan)>) -> Plan {
        let mut whole = Plan {
            words: Vec::new(),
            goals: vec![0; self.goals.len()],
        };
        let mut next: Value = 0;
        for (goal, part) in parts {
            let renamed = |value: Value| if value == 0 { 0 } else { value + next };
            let made = values_made(&part.words);
            for mut word in part.words {
                for value in &mut word.values {
                    *value = renamed(*value);
                }
                whole.words.push(word);
            }
            whole.goals[goal] = part.goals.first().map_or(0, |value| renamed(*value));
            next += made;
        }
        whole
    }

    /// The plan to beat: without any search, one goal after the other.
    fn base(&self) -> Option<Solved> {
        let mut parts = Vec::new();
        for (done, goal) in self.order().into_iter().enumerate() {
            let registers = self.registers.all.len().saturating_sub(done);
            let room = (registers, done + 1 < self.goals.len());
            let plain = |kind| self.plain(kind, (&self.goals[goal], self.unit), room);
            let outward = self.border.then(|| plain(border_safe_plans));
            let plan = outward.flatten().or_else(|| plain(walks));
            parts.push((goal, plan?));
        }
        self.finish(self.joined(parts))
    }

    /// Whether nothing saturates for some number of halvings.
    fn holds(&self, plan: &Plan, trace: &Trace, unit: i64) -> bool {
        let halvings = |limits: Limits| limits.halvings(plan, trace, unit);
        self.limits.is_none_or(|limits| halvings(limits).is_some())
    }

    /// The shortest of the plans that need no search and fit into `registers`; one within the
    /// limits is preferred.
    fn plain(
        &self,
        kind: fn(&LinearForm, i64) -> Vec<Plan>,
        (goal, unit): (&LinearForm, i64),
        (registers, input_is_kept): (usize, bool),
    ) -> Option<Plan> {
        let least = |mut plans: Vec<Plan>, unit: i64| {
            plans.retain(|plan| plan.pressure(input_is_kept) <= registers && self.buses.have(plan));
            plans.order_by_key(|plan| plan.words.len());
            let holds = |plan: &&Plan| {
                let trace = plan.trace(unit * FINE);
                trace.is_some_and(|trace| self.holds(plan, &trace, unit))
            };
            plans.iter().find(holds).or(plans.first()).cloned()
        };
        let mut plans = kind(goal, unit);
        plans.extend(scale(goal, unit));
        if let Some(parts) = factors(goal, unit) {
            let [row, column] = parts.map(|(part, unit)| least(kind(&part, unit), unit));
            if let (Some(row), Some(column)) = (row, column) {
                plans.extend(compose(&row, &column));
            }
        }
        least(plans, unit)
    }

    /// Allocates registers; `None` where there are too few, or the chip does not have the words. The
    /// plan is verified once more by its trace.
    pub(in crate::compile) fn finish(&self, plan: Plan) -> Option<Solved> {
        if !self.buses.have(&plan) {
            return None;
        }
        let trace = plan.trace(self.unit.checked_mul(FINE)?)?;
        for (goal, value) in self.goals.iter().zip(&plan.goals) {
            if trace.values.get(*value)? != &goal.times(FINE) {
                debug_assert!(false, "a plan makes something else");
                return None;
            }
        }
        let allocated = allocate(&plan, &self.registers)?;
        Some(Solved {
            allocated,
            border: trace.border,
            holds: self.holds(&plan, &trace, self.unit),
            plan,
            seen: 0,
        })
    }
}

/// Words that a plan may be longer than the shortest for its signal's sake.
pub(in crate::compile) const fn slack(words: usize) -> usize {
    if words / 4 > 2 { words / 4 } else { 2 }
}

/// Whether a plan is preferred: right at the border where that is asked, without saturation,
/// then shorter, then with fewer registers.
fn better(new: &Solved, old: Option<&Solved>, border: bool) -> bool {
    let Some(old) = old else { return true };
    let key = |solved: &Solved| {
        let pressure = solved.allocated.live.iter().map(Vec::len).max();
        let short = border && !solved.border;
        (short, !solved.holds, solved.allocated.words.len(), pressure)
    };
    key(new) < key(old)
}

/// Rounds in which separable kernels are also searched by their factors, which is quick.
const FACTORED: u64 = 4;

/// Searches in parallel, each with a heuristic of its own.
const SEARCHES: u64 = 4;

/// Heuristic number `i` of a seed: random weights.
fn heuristic(seed: u64, width: usize, i: u64) -> Heuristic {
    let key = Hash::raw(seed ^ (width as u64) << 32 ^ i.wrapping_mul(GOLDEN));
    let mut draws = (1..).map(|n| key.nth(n).bits());
    // 24 bits: what an `f32` holds.
    let mut next = || (draws.next().unwrap_or_default() >> 40) as f32 / (1u64 << 24) as f32;
    Heuristic {
        width,
        digit: 0.3 + next(),
        place: 0.4 + 0.9 * next(),
        level: 0.3 + next(),
        value: 0.2 + 2.0 * next(),
        related: i.is_multiple_of(2),
        split: (i / 2 + i / 4).is_multiple_of(2),
    }
}
