//! Victor and Purpura's distance (J. Neurophysiology 76:1310, 1996,
//! doi:10.1152/jn.1996.76.2.1310).
//!
//! The least cost of turning the reference's train of a cell into the judged one: 1 for an
//! event added or taken away, `q |dt|` for one moved by `dt`. The cost is given as the time
//! `h = 1/q` whose shift costs 1, in whole microseconds, at least 1: no event is moved by more
//! than `2h`, since taking it away and adding it elsewhere costs 2. Summed over cells and
//! divided by the mean number of events of the two packets: an event missing costs 1, one
//! late by `d` costs `d / h`, and no stream comes above 2.
//!
//! The textbook computes this with a table of n x m. Here it takes one walk over the events,
//! and is exact, in whole numbers:
//!
//! Let `F(k)` be the least cost so far when `k` events of the reference still wait for a
//! partner (negative: judged events that do). Time that passes adds `|k| dt / h`. A reference
//! event waits too, or is taken away: `min(F(k - 1), F(k) + 1)`; a judged event likewise the
//! other way. All of these keep `F` convex, so it is held as `F(0)` and its differences going
//! away from 0, one list to the left and one to the right, each ascending. Time raises both
//! lists alike, which is one clock. A reference event puts a 1 into the left list and moves
//! the place of 0 by one step to the left: the smallest difference there is added to `F(0)`
//! and goes over to the right with its sign turned. A judged event does the same the other
//! way. A difference above 1 can never be the smallest again and is dropped. Every event
//! puts two numbers into the lists, and each leaves once: no table, no band, however crowded
//! a cell is.
//!
//! It is allowed to pair without regard to order, as uncrossing two pairs never makes them
//! dearer.

use std::collections::VecDeque;

use super::{
    Pair,
    entry::{Entry, Scale},
};
use crate::unit::Micros;

/// Victor and Purpura's distance per event, at the shift that costs 1.
pub static ENTRY: Entry = Entry {
    key: "victor_purpura",
    title: "Victor-Purpura,",
    scale: Scale::Shift,
    study: Some((
        "victor-purpura",
        "Victor and Purpura's distance per event, for each shift that costs 1",
    )),
    blind_to: "",
    knows_a_redraw: true,
    symmetric: true,
    value: |of, h| Some(distance(of.pair, h)),
};

/// The distance when a shift by `h` costs as much as an event added, per event; 0 for
/// identical packets, at most 2.
#[must_use]
pub fn distance(pair: &Pair, h: Micros) -> f64 {
    let h = i128::from(h.0.max(1));
    let total = pair.fold(
        || 0_i128,
        |sum, reference, judged| *sum += cost(reference.iter(), judged.iter(), h),
        |a, b| a + b,
    );
    pair.per_event(total as f64 / h as f64)
}

/// The least cost between two trains, both ascending, in units of 1/h.
fn cost(reference: impl Iterator<Item = u64>, judged: impl Iterator<Item = u64>, h: i128) -> i128 {
    let (mut a, mut b) = (reference.peekable(), judged.peekable());
    // Differences to the left and to the right of 0, the nearest in front, less the clock.
    let mut lists = [VecDeque::<i128>::new(), VecDeque::new()];
    let mut at_zero = 0;
    loop {
        let (t, [own, other]) = match (a.peek(), b.peek()) {
            (Some(&t), judged) if judged.is_none_or(|&judged| t <= judged) => {
                a.next();
                let [left, right] = &mut lists;
                (t, [left, right])
            }
            (_, Some(&t)) => {
                b.next();
                let [left, right] = &mut lists;
                (t, [right, left])
            }
            (_, None) => return at_zero,
        };
        let clock = i128::from(t);
        while own.back().is_some_and(|last| last + clock >= h) {
            own.pop_back();
        }
        own.push_back(h - clock);
        // Never none: one was just put in.
        let step = own.pop_front().map_or(h, |first| first + clock);
        at_zero += step;
        other.push_front(-step - clock);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The textbook's table.
    fn table(a: &[u64], b: &[u64], h: u64) -> u64 {
        let mut row: Vec<u64> = (0..=b.len() as u64).map(|j| j * h).collect();
        for &ta in a {
            let mut next = vec![row[0] + h];
            for (j, &tb) in b.iter().enumerate() {
                let shifted = row[j] + ta.abs_diff(tb);
                next.push(shifted.min(row[j + 1] + h).min(next[j] + h));
            }
            row = next;
        }
        row[b.len()]
    }

    fn train() -> impl Strategy<Value = Vec<u64>> {
        (1..300_u64)
            .prop_flat_map(|end| prop::collection::vec(0..end, 0..30))
            .prop_map(|mut times| {
                times.sort_unstable();
                times
            })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(5000))]

        #[test]
        fn one_walk_gives_what_the_table_gives(a in train(), b in train(), h in 1..40_u64) {
            let walked = cost(a.iter().copied(), b.iter().copied(), h.into());
            prop_assert_eq!(walked, i128::from(table(&a, &b, h)));
        }
    }

    #[test]
    fn times_at_the_end_of_64_bits_do_not_overflow() {
        let cost = |a: &[u64], b: &[u64], h: u64| {
            cost(a.iter().copied(), b.iter().copied(), i128::from(h))
        };
        assert_eq!(cost(&[0], &[u64::MAX], u64::MAX), i128::from(u64::MAX));
        assert_eq!(cost(&[0], &[u64::MAX], 1), 2);
        assert_eq!(cost(&[u64::MAX; 3], &[u64::MAX], 7), 14);
    }
}
