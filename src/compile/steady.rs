//! Constant errors out of a plan: a register that holds one transfer error.
//!
//! A store with nothing on its bus leaves the transfer error Δ alone in its register. Read along
//! with the other sources of a word, it cancels the Δ of that word's own store, at no word: what
//! the vendor's macros reach by storing twice. It costs one word and a register as long as it is
//! held; where registers are short, it is made anew.

use super::{
    beam::SOURCES,
    plan::{Plan, Store, StoreErrors, Word},
};

/// Sources of a word that stores in two parts.
const SOURCES_SPLIT: usize = 2;

/// For each word, whether it reads the constant too.
pub(super) type Reads = Vec<bool>;

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
        if let Store::News(_) | Store::Both(_) = word.store {
            news = stored;
        }
        if let Store::Register | Store::Both(_) = word.store {
            values.push(stored);
        }
        reads.push(read);
    }
    reads
}

/// The plan in which these words read the constant too, wherever one of `registers` is free for
/// it; `None` where no word does.
pub(super) fn steadied(plan: &Plan, reads: &[bool], registers: usize) -> Option<Plan> {
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
            out.words.push(Word {
                store: Store::Register,
                views: Vec::new(),
                values: Vec::new(),
                halved: false,
            });
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
        if !matches!(word.store, Store::News(_)) {
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
    use crate::compile::{strategy::forms, walk::walks};
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

    #[test]
    fn a_row_of_copies_stays_at_zero() {
        let copy = |value| Word {
            store: Store::Register,
            views: vec![],
            values: vec![value],
            halved: false,
        };
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
