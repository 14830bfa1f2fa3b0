//! Tours: a running sum that stops at few places of the kernel, and there adds several inputs.
//!
//! A walk takes in one place at a time, and two words move it by at most two pixels. A tour first
//! makes copies of the input as it is seen from other places, its *footprint*, at little more than a
//! word each. Then one stop adds what the kernel has at all places under the footprint: of its two
//! words one adds up to three copies with a positive sign, the other up to three with a negative
//! one. With the five inputs of a row held, a ternary 5x5 kernel with at most three of a sign in each
//! row can be made in 17 words: six for the copies, one that begins the sum, and two for each of the
//! five moves between its rows and home. The search finds 15 to 20, often with other footprints.
//!
//! Weights of several bits are added plane by plane, the lowest first, and the sum is halved in
//! between; several goals one after the other, from the same copies.

mod footprint;
mod search;

use rayon::prelude::*;

use self::{
    footprint::Footprint,
    search::{MOST_DIGITS, PlacedDigit, Scaled, Search, Stage, Task},
};
use crate::{
    compile::intermediate::{
        linear_form::LinearForm,
        plan::Plan,
        signed_digit::{Plane, grouped, magnitudes, planes, scaling},
    },
    isa::Direction,
    order::Order,
    stop::Stop,
};

/// The most copies of the input, itself among them.
const MOST_COPIES: usize = 5;

/// The most exponents of digits that one visit adds.
const MOST_EXPONENTS: usize = 3;

/// Nodes of this search that take as long as a state of the other.
pub(in crate::compile) const NODES: u64 = 32;

/// The registers of a tour.
#[derive(Clone, Copy, Debug)]
pub(in crate::compile) struct Room<'a> {
    pub(in crate::compile) registers: usize,
    /// The goals in the order in which they are made.
    pub(in crate::compile) order: &'a [usize],
    /// Whether the last goal ends in the register of the input.
    pub(in crate::compile) over_input: bool,
    /// Whether to give up.
    pub(in crate::compile) stop: Stop,
}

/// The shortest tours that are found, of fewer than `fewer` words or a few more, with five copies and
/// with fewer, which leave registers free; and how many nodes were looked at, about `budget` at most.
pub(in crate::compile) fn tours(
    goals: &[LinearForm],
    unit: i64,
    room: Room<'_>,
    (fewer, budget): (usize, u64),
) -> (u64, Vec<Plan>) {
    let most = room.registers.saturating_sub(goals.len()).min(MOST_COPIES);
    if most == 0 || goals.iter().any(LinearForm::is_zero) {
        return (0, Vec::new());
    }
    let forms: [fn(&LinearForm) -> Vec<Plane>; 2] = [planes, magnitudes];
    let tasks: Vec<Vec<Option<Task>>> = { forms.into_iter() }
        .map(|form| {
            let held = 1..=MOST_EXPONENTS;
            held.map(|held| task(goals, unit, room, (form, held)))
                .collect()
        })
        .collect();
    let exponents = goals.iter().map(|goal| planes(goal).len()).max();
    let exponents = exponents.unwrap_or(1).min(MOST_EXPONENTS);
    let several = exponents > 1;
    let footprints = Footprint::all(most, exponents);
    // The least that each may take, the best first.
    let mut tries: Vec<Try<'_>> = Vec::new();
    for footprint in &footprints {
        for tasks in &tasks[..=usize::from(several)] {
            let Some(task) = &tasks[footprint.exponents - 1] else {
                continue;
            };
            let words = Search::new(task, footprint).estimate();
            tries.push(Try {
                task,
                footprint,
                words,
                plan: None,
            });
        }
    }
    let mut seen = tries.len() as u64 * ESTIMATE;
    let mut width = NARROW;
    let mut left = tries.len();
    for round in 0..ROUNDS {
        tries.order_by_key(|one| one.words);
        tries.truncate(left);
        // What a narrow search makes is longer than what a wide one will.
        let (slack, fewer) = if round == 0 {
            (SLACK, fewer.saturating_add(fewer / LOOSE))
        } else {
            (0, fewer)
        };
        let mut at = 0;
        // In turns of a fixed size, so that what is searched does not depend on the threads.
        while at < tries.len() && seen < budget && !room.stop.is_asked() {
            let end = (at + TURN).min(tries.len());
            let below = |copies: usize| {
                let same = tries
                    .iter()
                    .filter(|one| one.footprint.copies.len() == copies);
                let made = same.filter(|one| one.plan.is_some());
                let least = made.map(|one| one.words).min();
                least.map_or(fewer, |least| fewer.min(least + slack))
            };
            let below: Vec<usize> = (0..=most).map(below).collect();
            let counts: Vec<u64> = { tries[at..end].par_iter_mut() }
                .map(|one| one.search(width, below[one.footprint.copies.len()]))
                .collect();
            seen += counts.iter().sum::<u64>();
            at = end;
        }
        if round == 0 {
            tries.retain(|one| one.plan.is_some());
        }
        left = KEPT >> (2 * round);
        width *= WIDER;
    }
    tries.order_by_key(|one| one.words);
    let mut plans = Vec::new();
    for copies in (1..=most).rev() {
        let own = tries
            .iter()
            .filter(|one| one.footprint.copies.len() == copies);
        plans.extend(own.filter_map(|one| one.plan.clone()).take(ALIKE));
    }
    (seen, plans)
}

/// States kept after each word, in the first round.
const NARROW: usize = 12;

/// How much wider each round is than the one before it.
const WIDER: usize = 8;

/// Rounds, and the footprints that are kept after the first; a quarter of them after each other.
const ROUNDS: usize = 3;
const KEPT: usize = 32;

/// Footprints that are searched at a time.
const TURN: usize = 8;

/// Words more than the best of as many copies with which a footprint is looked at again.
const SLACK: usize = 3;

/// The part of the words that a tour of the first round may have more than is asked for.
const LOOSE: usize = 4;

/// Tours of each number of copies.
const ALIKE: usize = 2;

/// What an estimate costs, in nodes.
const ESTIMATE: u64 = 20;

/// A footprint, and what was found with it.
struct Try<'a> {
    task: &'a Task,
    footprint: &'a Footprint,
    /// Words of the plan, or as estimated.
    words: usize,
    plan: Option<Plan>,
}

impl Try<'_> {
    fn search(&mut self, width: usize, below: usize) -> u64 {
        let mut search = Search::new(self.task, self.footprint);
        if let Some((words, plan)) = search.run(width, below) {
            self.words = words;
            self.plan = Some(plan);
        }
        search.seen
    }
}

/// The digits of all goals in the order in which they are added; `None` where they are too many.
fn task(
    goals: &[LinearForm],
    unit: i64,
    room: Room<'_>,
    (form, held): (fn(&LinearForm) -> Vec<Plane>, usize),
) -> Option<Task> {
    let mut stages = Vec::new();
    let mut scaled = Vec::new();
    for (goal, at) in room.order.iter().enumerate() {
        let (groups, last) = grouped(&form(goals.get(*at)?), held)?;
        let begun = groups.iter().skip_while(|visits| visits.is_empty());
        for visits in begun {
            let digits: Vec<PlacedDigit> = { visits.iter() }
                .flat_map(|(place, digits)| {
                    digits.iter().map(|digit| PlacedDigit {
                        place: *place,
                        digit: *digit,
                    })
                })
                .collect();
            if digits.len() > MOST_DIGITS {
                return None;
            }
            stages.push(Stage {
                goal,
                digits,
                ends: false,
            });
        }
        stages.last_mut()?.ends = true;
        let (up, down) = scaling(unit, last);
        scaled.push(Scaled {
            up,
            down,
            steps: goals.len() > 1,
        });
    }
    Some(Task {
        stages,
        scaled,
        order: room.order.to_vec(),
        registers: room.registers,
        over_input: room.over_input,
    })
}

/// The direction of a cell of [`NEWS_CELLS`](crate::compile::intermediate::linear_form::NEWS_CELLS).
const fn direction(cell: usize) -> Option<Direction> {
    match cell {
        0 => None,
        cell => Some(Direction::ALL[cell - 1]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compile::intermediate::random_form::forms;
    use proptest::prelude::*;

    /// The tours of these goals, each proved by its trace.
    fn proved(goals: &[LinearForm], unit: i64, registers: usize, budget: u64) -> Vec<Plan> {
        let order: Vec<usize> = (0..goals.len()).collect();
        let room = Room {
            registers,
            order: &order,
            over_input: true,
            stop: Stop::NEVER,
        };
        let (_, plans) = tours(goals, unit, room, (usize::MAX, budget));
        let fine = 1 << 20;
        for plan in &plans {
            let trace = plan.trace(unit * fine).unwrap();
            for (goal, value) in goals.iter().zip(&plan.goals) {
                assert_eq!(trace.values[*value], goal.times(fine));
            }
            assert!(plan.pressure(false) <= registers, "{plan:?}");
        }
        plans
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]

        #[test]
        fn tours_make_what_is_asked(
            goals in proptest::collection::vec(forms(3, 40), 1..3),
            exponent in 0u32..9,
            registers in 3usize..8,
        ) {
            prop_assume!(goals.iter().all(|goal| !goal.is_zero()));
            // So little effort does not always find one.
            let _ = proved(&goals, 1 << exponent, registers, 40_000);
        }
    }

    /// No weight is 0, and no factor helps.
    #[test]
    fn a_full_ternary_kernel_takes_at_most_twenty_words() {
        use crate::compile::intermediate::linear_form::Tap;
        for seed in 0..4 {
            let sign = |at: i16| {
                if (at * (7 + seed) + at / 5 * 3) % 5 < 3 {
                    1
                } else {
                    -1
                }
            };
            let taps = (0..25).map(|at| Tap {
                y: at / 5 - 2,
                x: at % 5 - 2,
                weight: sign(at),
            });
            let goal = LinearForm::new(taps.collect());
            let plans = proved(std::slice::from_ref(&goal), 1, 6, 150_000);
            let least = plans.iter().map(|plan| plan.words.len()).min().unwrap();
            assert!(least <= 20, "{least} words: {goal:?}");
        }
    }
}
