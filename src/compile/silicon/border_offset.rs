//! Constant errors at the rim of the array, where a filter reads registers that no word stores to.
//!
//! Off the array every register holds the edge value, whatever is run, while on it each store adds
//! its transfer error. A filter that reads across the border therefore has another constant in its
//! result there than in the middle, and where nothing takes constants out, the rim fires in every
//! frame. It does not where what is moved is as constant on the array as off it:
//!
//! - what is read from a neighbour (`bus(A, XE)`) must hold the edge value in the dark, so the word
//!   that stored it reads the [register of one transfer error](super::offset_cancellation) too;
//! - what is stored into a neighbour (`bus(XE, A)`) is one transfer error in the rim, which
//!   pixels off the array put there, and so must it be elsewhere: such a word does not read it.
//!
//! Which words read it is chosen here for the same constant in all places, and a small one. A row of
//! cells across the array along each axis has all that counts, but for the corners.

use super::offset_cancellation::{Reads, greedy, room};
use crate::compile::intermediate::{
    linear_form::step,
    plan::{Plan, Store, StoreErrors, Word, values_made},
};

/// Plans in the dark, at every distance from the border.
pub(in crate::compile) struct Rim {
    /// Cells of a row: one off the array at either end.
    row: usize,
    errors: StoreErrors,
    /// What registers hold off the array, LSB.
    edge: f64,
}

/// A row along x, then one along y.
type Cells = [f64];

/// What a run in the dark leaves.
#[derive(Clone)]
struct Dark {
    /// Of each value of the plan, one after the other: what it is in all cells.
    values: Vec<f64>,
    /// Of each word, what is in NEWS before it, and after the last.
    news: Vec<f64>,
    /// The middle of what each word stored.
    stored: Vec<f64>,
}

/// What a change of one word does: all is affine, so it is the same after any other change.
struct Change {
    result: Vec<f64>,
    stored: Vec<f64>,
}

impl Rim {
    /// For results that reach so many pixels far.
    pub(in crate::compile) fn new(reach: usize, errors: StoreErrors, edge: f64) -> Self {
        Self {
            row: 2 * reach.max(1) + 3,
            errors,
            edge,
        }
    }

    const fn cells(&self) -> usize {
        2 * self.row
    }

    fn on(&self) -> impl Iterator<Item = usize> {
        [1, self.row + 1]
            .into_iter()
            .flat_map(|from| from..from + self.row - 2)
    }

    /// The cell that lies a step from one on the array: by how many numbers.
    const fn beside(&self, at: usize, (dy, dx): (i16, i16)) -> usize {
        let by = if at < self.row { dx } else { dy };
        at.wrapping_add_signed(by as isize)
    }

    const fn middle(&self) -> usize {
        self.row / 2
    }

    /// Before the first word.
    fn start(&self, plan: &Plan) -> Dark {
        let room = (plan.words.len() + 1) * self.cells();
        let mut dark = Dark {
            values: Vec::with_capacity(room),
            news: Vec::with_capacity(room),
            stored: Vec::with_capacity(plan.words.len()),
        };
        dark.values.resize(self.cells(), self.edge);
        dark.news.resize(self.cells(), self.edge);
        for at in self.on() {
            dark.values[at] = 0.0;
        }
        dark
    }

    /// Runs a word, which may read the constant too.
    fn run(&self, word: &Word, read: bool, dark: &mut Dark) {
        let cells = self.cells();
        let Dark {
            values,
            news,
            stored,
        } = dark;
        let sources = word.views.len() + word.values.len() + usize::from(read);
        let splits = word.splits();
        let constant = if read {
            self.errors.stored(0.0, false)
        } else {
            0.0
        };
        let now = news.len() - cells;
        // By the pixel whose bus it is; all off the array do the same.
        let outside = self.errors.stored(sources as f64 * self.edge, splits);
        let mut all = [outside; MOST_CELLS];
        for at in self.on() {
            let mut sum = constant;
            for view in &word.views {
                sum += news[now + self.beside(at, step(*view))];
            }
            for value in &word.values {
                sum += values[value * cells + at];
            }
            all[at] = self.errors.stored(sum, splits);
        }
        let mut put = |into: &mut Vec<f64>, (dy, dx): (i16, i16)| {
            let from = into.len();
            into.resize(from + cells, self.edge);
            for at in self.on() {
                into[from + at] = all[self.beside(at, (-dy, -dx))];
            }
            stored.push(into[from + self.middle()]);
        };
        match word.store {
            Store::Register => put(values, (0, 0)),
            Store::News(to) => put(news, step(to)),
            Store::Both(to) => {
                put(values, (0, 0));
                put(news, step(to));
                stored.pop();
            }
        }
        if matches!(word.store, Store::Register) {
            news.extend_from_within(now..);
        }
    }

    fn all(&self, plan: &Plan, reads: &[bool]) -> Dark {
        let mut dark = self.start(plan);
        for (word, read) in plan.words.iter().zip(reads) {
            self.run(word, *read, &mut dark);
        }
        dark
    }

    fn result<'a>(&self, plan: &Plan, dark: &'a Dark) -> &'a Cells {
        let goal = plan.goals.first().copied().unwrap_or(0);
        &dark.values[goal * self.cells()..][..self.cells()]
    }

    /// How much a value differs from place to place, and what it is in the middle, as a cost: what
    /// it is in the middle can be taken out behind the filter.
    fn cost(&self, value: impl Fn(usize) -> f64) -> f64 {
        let middle = value(self.middle());
        let (mut most, mut sum) = (0.0f64, 0.0);
        for at in self.on() {
            let apart = (value(at) - middle).abs();
            most = most.max(apart);
            sum += apart;
        }
        most + SUM * sum + MIDDLE * middle.abs()
    }

    /// Which words read the constant, of those that can in so many registers.
    pub(in crate::compile) fn levelled(&self, plan: &Plan, registers: usize) -> Reads {
        if self.cells() > MOST_CELLS {
            return greedy(plan, self.errors);
        }
        let pressures = plan.pressures(false);
        let open: Vec<bool> = { plan.words.iter().zip(pressures) }
            .map(|(word, pressure)| room(word) && pressure < registers)
            .collect();
        let (cost, reads) = self.descended(plan, self.straight(plan, &open), &open);
        if cost < ENOUGH {
            return reads;
        }
        let greedy = greedy(plan, self.errors);
        let greedy = greedy.iter().zip(&open).map(|(read, open)| *read && *open);
        let (other, found) = self.descended(plan, greedy.collect(), &open);
        if other < cost { found } else { reads }
    }

    /// A first choice, word by word: what leaves each as constant as it is off the array.
    fn straight(&self, plan: &Plan, open: &[bool]) -> Reads {
        let cells = self.cells();
        let mut dark = self.start(plan);
        let mut reads = vec![false; plan.words.len()];
        for (at, word) in plan.words.iter().enumerate() {
            let (before, mut with) = (dark.clone(), dark.clone());
            self.run(word, false, &mut dark);
            if !open[at] {
                continue;
            }
            self.run(word, true, &mut with);
            let cost = |dark: &Dark| match word.store {
                Store::Register => {
                    let own = &dark.values[before.values.len()..];
                    self.cost(|at| own[at])
                }
                Store::News(_) | Store::Both(_) => {
                    let news = &dark.news[dark.news.len() - cells..];
                    // As it is read, up to the next that is stored there.
                    let mut last = false;
                    let later = { plan.words[at + 1..].iter() }
                        .take_while(|word| !std::mem::replace(&mut last, word.writes_news()));
                    let seen = later.flat_map(|word| &word.views);
                    seen.map(|view| self.cost(|at| news[self.beside(at, step(*view))]))
                        .sum()
                }
            };
            if cost(&with) < cost(&dark) {
                (reads[at], dark) = (true, with);
            }
        }
        reads
    }

    /// What becomes of a result where a word is changed.
    fn change(&self, plan: &Plan, (reads, dark): (&[bool], &Dark), at: usize) -> Change {
        let cells = self.cells();
        let values = 1 + values_made(&plan.words[..at]);
        let mut other = Dark {
            values: dark.values[..values * cells].to_vec(),
            news: dark.news[at * cells..][..cells].to_vec(),
            stored: dark.stored[..at].to_vec(),
        };
        self.run(&plan.words[at], !reads[at], &mut other);
        for (word, read) in plan.words.iter().zip(reads).skip(at + 1) {
            self.run(word, *read, &mut other);
        }
        let less = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect();
        Change {
            result: less(self.result(plan, &other), self.result(plan, dark)),
            stored: less(&other.stored, &dark.stored),
        }
    }

    /// A choice changed word by word, or in pairs, as long as that helps; and its cost.
    fn descended(&self, plan: &Plan, mut reads: Reads, open: &[bool]) -> (f64, Reads) {
        let dark = self.all(plan, &reads);
        let mut result = self.result(plan, &dark).to_vec();
        let mut stored = dark.stored.clone();
        let most = |stored: &dyn Fn(usize) -> f64| {
            let all = (0..plan.words.len()).map(|at| stored(at).abs());
            ON_THE_WAY * all.fold(0.0, f64::max)
        };
        let mut cost = self.cost(|at| result[at]) + most(&|at| stored[at]);
        if cost < ENOUGH {
            return (cost, reads);
        }
        let open: Vec<usize> = (0..open.len()).filter(|at| open[*at]).collect();
        let mut changes: Vec<Change> = { open.iter() }
            .map(|at| self.change(plan, (&reads, &dark), *at))
            .collect();
        for _ in 0..ROUNDS {
            let (mut least, mut best) = (cost - LEAST, None);
            for (i, change) in changes.iter().enumerate() {
                let own = self.cost(|at| result[at] + change.result[at]);
                if own >= least {
                    continue;
                }
                let own = own + most(&|at| stored[at] + change.stored[at]);
                if own < least {
                    (least, best) = (own, Some((i, None)));
                }
            }
            if best.is_none() {
                for (i, a) in changes.iter().enumerate() {
                    for (j, b) in changes.iter().enumerate().skip(i + 1) {
                        let own = self.cost(|at| result[at] + a.result[at] + b.result[at]);
                        if own >= least {
                            continue;
                        }
                        let own = own + most(&|at| stored[at] + a.stored[at] + b.stored[at]);
                        if own < least {
                            (least, best) = (own, Some((i, Some(j))));
                        }
                    }
                }
            }
            let Some((first, second)) = best else { break };
            cost = least;
            for i in [Some(first), second].into_iter().flatten() {
                reads[open[i]] = !reads[open[i]];
                let change = &mut changes[i];
                // To be taken back.
                let both = result.iter_mut().zip(&mut change.result);
                for (own, change) in both.chain(stored.iter_mut().zip(&mut change.stored)) {
                    *own += *change;
                    *change = -*change;
                }
            }
            if cost < ENOUGH {
                break;
            }
        }
        (cost, reads)
    }
}

/// The most cells of both rows: kernels that reach 7 pixels.
const MOST_CELLS: usize = 34;

/// What all differences weigh beside the largest.
const SUM: f64 = 0.1;

/// What a constant of the middle weighs beside a difference.
const MIDDLE: f64 = 0.5;

/// What a constant on the way weighs.
const ON_THE_WAY: f64 = 0.05;

/// A cost of which a threshold sees nothing, LSB.
const ENOUGH: f64 = 3.0;

/// The least that a change must gain, LSB.
const LEAST: f64 = 1e-6;

/// The most changes.
const ROUNDS: usize = 32;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compile::{
        construction::border_safe::border_safe_plans, intermediate::random_form::forms,
        silicon::offset_cancellation::steadied,
    };
    use proptest::prelude::*;

    const ERRORS: StoreErrors = StoreErrors {
        transfer: 20.0,
        division: 2.0,
    };

    /// How far the result lies apart in the dark.
    fn apart(rim: &Rim, plan: &Plan) -> f64 {
        let dark = rim.all(plan, &vec![false; plan.words.len()]);
        let result = rim.result(plan, &dark);
        let apart = rim.on().map(|at| (result[at] - result[rim.middle()]).abs());
        apart.fold(0.0, f64::max)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn a_levelled_plan_makes_the_same_and_is_as_constant_at_the_rim(goal in forms(2, 1)) {
            let rim = Rim::new(2, ERRORS, 0.0);
            let mut least = f64::INFINITY;
            for plan in border_safe_plans(&goal, 1) {
                let reads = rim.levelled(&plan, 8);
                let level = steadied(&plan, &reads, 8).unwrap_or_else(|| plan.clone());
                let value = |plan: &Plan| {
                    let trace = plan.trace(1 << 20).unwrap();
                    trace.values[plan.goals[0]].clone()
                };
                prop_assert_eq!(value(&level), value(&plan));
                // As the choice has it, so has a run of what is made of it.
                let chosen = rim.all(&plan, &reads);
                let made = rim.all(&level, &vec![false; level.words.len()]);
                prop_assert_eq!(rim.result(&plan, &chosen), rim.result(&level, &made));
                least = least.min(apart(&rim, &level));
            }
            prop_assert!(least < 3.0, "{}", least);
        }
    }

    /// What is put into a neighbour comes from off the array with one transfer error; what is read
    /// from a neighbour is without one there.
    #[test]
    fn both_ways_across_the_border() {
        use crate::isa::Direction::East;
        let rim = Rim::new(1, ERRORS, 0.0);
        let news = |to, values| Word {
            store: Store::News(to),
            views: vec![],
            values,
            halved: false,
        };
        let read = |view| Word {
            store: Store::Register,
            views: vec![view],
            values: vec![],
            halved: false,
        };
        let plan = |words| Plan {
            words,
            goals: vec![1],
        };
        let pushed = plan(vec![news(Some(East), vec![0]), read(None)]);
        assert_eq!(apart(&rim, &pushed), 0.0);
        let pulled = plan(vec![news(None, vec![0]), read(Some(East))]);
        assert_eq!(apart(&rim, &pulled), 20.0);
        assert!(rim.levelled(&pulled, 6)[0]);
        let level = steadied(&pulled, &rim.levelled(&pulled, 6), 6).unwrap();
        assert_eq!(apart(&rim, &level), 0.0);
    }
}
