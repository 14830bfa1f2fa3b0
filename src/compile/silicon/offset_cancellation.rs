//! Constant errors out of a plan: a register that holds one transfer error.
//!
//! A store with nothing on its bus leaves the transfer error Δ alone in its register. Read along
//! with the other sources of a word, it cancels the Δ of that word's own store, at no word: what
//! the vendor's macros reach by storing twice. It costs one word and a register as long as it is
//! held; where registers are short, it is made anew.

use crate::{
    compile::intermediate::plan::{Plan, SOURCES, SOURCES_SPLIT, StoreErrors, Word, values_made},
    order::Order,
};

/// For each word, whether it reads the constant too.
pub(in crate::compile) type Reads = Vec<bool>;

/// Whether a word has a source to spare.
pub(super) fn room(word: &Word) -> bool {
    let most = if word.splits() {
        SOURCES_SPLIT
    } else {
        SOURCES
    };
    word.views.len() + word.values.len() < most && !is_constant(word)
}

/// A store of nothing.
fn is_constant(word: &Word) -> bool {
    word.views.is_empty() && word.values.is_empty()
}

/// A first choice: every word that comes nearer to 0 by it reads the constant.
pub(super) fn greedy(plan: &Plan, errors: StoreErrors) -> Reads {
    let mut values = vec![0.0];
    let mut news = 0.0;
    let constant = errors.stored(0.0, false);
    let mut reads = Vec::with_capacity(plan.words.len());
    for word in &plan.words {
        let held = word.values.iter().filter_map(|v| values.get(*v));
        let sum = news * word.views.len() as f64 + held.sum::<f64>();
        let without = errors.stored(sum, word.splits());
        let with = errors.stored(sum + constant, word.splits());
        let read = room(word) && with.abs() < without.abs() - 1.0;
        let stored = if read { with } else { without };
        if word.writes_news() {
            news = stored;
        }
        if word.makes_value() {
            values.push(stored);
        }
        reads.push(read);
    }
    reads
}

/// A choice that leaves the least in the last word, the result, and little on the way: words are
/// changed one by one or in pairs, as long as that helps.
pub(in crate::compile) fn balanced(plan: &Plan, errors: StoreErrors, registers: usize) -> Reads {
    // The cost of a choice, and what stays in the result.
    let tried = |reads: &Reads| {
        let steady = steadied(plan, reads, registers);
        let dark = steady.as_ref().unwrap_or(plan).dark(0.0, errors);
        let most = dark
            .iter()
            .fold(0.0, |most: f64, dark| most.max(dark.abs()));
        let last = dark.last().copied().unwrap_or(0.0);
        (last.abs() + ON_THE_WAY * most, last)
    };
    let changed = |reads: &Reads, at: &[usize]| {
        let mut reads = reads.clone();
        for at in at {
            reads[*at] = !reads[*at];
        }
        reads
    };
    let open: Vec<usize> = { plan.words.iter().enumerate() }
        .filter(|(_, word)| room(word))
        .map(|(at, _)| at)
        .collect();
    let mut best = greedy(plan, errors);
    if open.len() > MOST {
        return best;
    }
    let (mut least, mut last) = tried(&best);
    for _ in 0..ROUNDS {
        let singles: Vec<_> = { open.iter() }
            .map(|at| (vec![*at], tried(&changed(&best, &[*at]))))
            .collect();
        // What two words do together is nearly the sum of what each does.
        let mut pairs: Vec<(f64, Vec<usize>)> = Vec::new();
        for (i, (a, (_, with_a))) in singles.iter().enumerate() {
            for (b, (_, with_b)) in &singles[i + 1..] {
                pairs.push(((with_a + with_b - last).abs(), vec![a[0], b[0]]));
            }
        }
        pairs.order_by(|a, b| a.0.total_cmp(&b.0));
        pairs.truncate(PAIRS);
        let pairs = pairs.into_iter().map(|(_, at)| {
            let tried = tried(&changed(&best, &at));
            (at, tried)
        });
        let found = singles.iter().cloned().chain(pairs);
        let found = found.min_by(|(_, a), (_, b)| a.0.total_cmp(&b.0));
        match found {
            Some((at, (cost, left))) if cost < least => {
                best = changed(&best, &at);
                (least, last) = (cost, left);
            }
            _ => break,
        }
    }
    best
}

/// A plan of one goal behind which what stays in the result is taken out by up to five words: its
/// constant is moved by a sum and by another, of one transfer error, about half of one, and about
/// three quarters. `None` where nothing is gained.
pub(in crate::compile) fn trimmed(plan: &Plan, errors: StoreErrors) -> Option<Plan> {
    let last = *plan.dark(0.0, errors).last()?;
    let one = errors.stored(0.0, false);
    let half = errors.stored(one, true);
    let constants = [one, half, errors.stored(half, true)];
    let sum = |set: usize| -> f64 {
        let own = constants.iter().enumerate();
        own.filter(|(i, _)| set >> i & 1 == 1)
            .map(|(_, it)| it)
            .sum()
    };
    // As sets of them: which the first copy reads, and which the second.
    let sets = (0..8).flat_map(|a| (0..8).map(move |b| (a, b)));
    let needed =
        |(a, b): (usize, usize)| (a | b).checked_ilog2().map_or(0, |most| most + 1) as usize;
    let left = |(a, b): (usize, usize)| (last + sum(a) - sum(b)).abs();
    let cost = |sets: &(usize, usize)| left(*sets) + A_WORD * needed(*sets) as f64;
    let best = sets.min_by(|a, b| cost(a).total_cmp(&cost(b)))?;
    if left(best) + 2.0 > last.abs() {
        return None;
    }
    let [goal] = plan.goals[..] else { return None };
    let mut out = plan.clone();
    let first = 1 + values_made(&plan.words);
    let count = needed(best);
    for i in 0..count {
        out.words.push(match i {
            0 => Word::register(Vec::new(), false),
            _ => Word::register(vec![first + i - 1], true),
        });
    }
    let copy = |value: usize, set: usize| {
        let own = (0..count).filter(|i| set >> i & 1 == 1).map(|i| first + i);
        Word::register([value].into_iter().chain(own).collect(), false)
    };
    out.words.push(copy(goal, best.0));
    out.words.push(copy(first + count, best.1));
    out.goals = vec![first + count + 1];
    Some(out)
}

/// What a word is worth of a constant in the result, LSB.
const A_WORD: f64 = 0.5;

/// What a constant on the way weighs beside one in the result.
const ON_THE_WAY: f64 = 0.05;

/// Words up to which a choice is bettered: each is tried against all, in each round.
const MOST: usize = 600;

/// Pairs of words that are tried in a round, and rounds.
const PAIRS: usize = 40;
const ROUNDS: usize = 8;

/// The plan in which these words read the constant too, wherever one of `registers` is free for
/// it; `None` where no word does.
pub(in crate::compile) fn steadied(plan: &Plan, reads: &[bool], registers: usize) -> Option<Plan> {
    let pressures = plan.pressures(false);
    let mut out = Plan {
        words: Vec::with_capacity(plan.words.len() + 1),
        goals: Vec::new(),
    };
    // Where each value of the old plan is in the new one.
    let mut renamed = vec![0];
    let mut values = 1;
    let mut held = None;
    let mut any = false;
    for (at, word) in plan.words.iter().enumerate() {
        let free = pressures.get(at).is_some_and(|p| *p < registers);
        if !free {
            held = None;
        }
        let read = free && reads.get(at) == Some(&true) && room(word);
        if read && held.is_none() {
            out.words.push(Word::register(Vec::new(), false));
            held = Some(values);
            values += 1;
        }
        let mut own = word.clone();
        for value in &mut own.values {
            *value = *renamed.get(*value)?;
        }
        if read {
            own.values.extend(held);
            any = true;
        }
        if word.makes_value() {
            renamed.push(values);
            values += 1;
        }
        out.words.push(own);
    }
    for goal in &plan.goals {
        out.goals.push(*renamed.get(*goal)?);
    }
    any.then_some(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compile::{construction::walk::walks, intermediate::random_form::forms};
    use proptest::prelude::*;

    const ERRORS: StoreErrors = StoreErrors {
        transfer: 20.0,
        division: 2.0,
    };

    proptest! {
        #[test]
        fn a_steadied_plan_makes_the_same_with_less_in_the_dark(
            goal in forms(2, 30),
            registers in 3usize..8,
        ) {
            for plan in walks(&goal, 1) {
                let reads = greedy(&plan, ERRORS);
                let Some(steady) = steadied(&plan, &reads, registers) else { continue };
                let fine = 1 << 20;
                let value = |plan: &Plan| {
                    let trace = plan.trace(fine).unwrap();
                    trace.values[plan.goals[0]].clone()
                };
                prop_assert_eq!(value(&steady), value(&plan));
                prop_assert!(steady.pressure(false) <= registers.max(plan.pressure(false)));
            }
        }
    }

    proptest! {
        #[test]
        fn a_trimmed_plan_makes_the_same_round_zero(goal in forms(2, 30)) {
            for plan in walks(&goal, 1) {
                let Some(trimmed) = trimmed(&plan, ERRORS) else { continue };
                let fine = 1 << 20;
                let value = |plan: &Plan| {
                    let trace = plan.trace(fine).unwrap();
                    trace.values[plan.goals[0]].clone()
                };
                prop_assert_eq!(value(&trimmed), value(&plan));
                let dark = |plan: &Plan| plan.dark(0.0, ERRORS).last().unwrap().abs();
                prop_assert!(dark(&trimmed) < dark(&plan));
                if dark(&plan) < 40.0 {
                    prop_assert!(dark(&trimmed) <= 3.0, "{}", dark(&trimmed));
                }
            }
        }
    }

    #[test]
    fn a_row_of_copies_stays_at_zero() {
        let copy = |value| Word::register(vec![value], false);
        let plan = Plan {
            words: (0..5).map(copy).collect(),
            goals: vec![5],
        };
        assert_eq!(plan.dark(0.0, ERRORS), [20.0, 0.0, 20.0, 0.0, 20.0]);
        let steady = steadied(&plan, &greedy(&plan, ERRORS), 6).unwrap();
        let dark = steady.dark(0.0, ERRORS);
        assert_eq!(dark[1..], [0.0; 5]);
    }
}
