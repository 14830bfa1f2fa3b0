//! Matched events: precision, recall, F1, and how late the matches are.
//!
//! A reference event and a judged event of the same cell may be matched when their times
//! differ by at most the window; every event is matched at most once. Greedy in time order:
//! the earliest unmatched event of each side are matched if they may be, else the earlier of
//! the two stays alone.
//!
//! No matching has more pairs. Take `a` and `b`, the earliest of each side. If `b` is too late
//! for `a`, so is everything after `b`: `a` can have no partner, and is rightly left alone
//! (likewise the other way round). If they may be matched, take any largest matching: if it
//! leaves both alone it is not the largest; if it gives one of them another partner, giving
//! `a` to `b` instead loses nothing; and if it pairs `a` with `b'` and `a'` with `b`, then
//! `a'` and `b'` may be matched too, since with `a <= a'` and `b <= b'` the difference
//! `a' - b'` lies between `a - b'` and `a' - b`. So some largest matching has the pair
//! (`a`, `b`), and the rest follows by induction.
//!
//! - precision = matched / judged events; none when only the reference has events
//! - recall = matched / reference events; none when only the judged packet has events
//! - F1 = 2 matched / (reference events + judged events), the harmonic mean
//!
//! Two packets without events are the same: all three are 1.
//!
//! The time error is judged minus reference, so a delay is positive. Greedy matches are the
//! most, not the closest: where one cell speaks more often than once a window, a missing
//! event shifts the matches after it, and the errors grow although no event moved.

use rayon::slice::ParallelSliceMut;

use super::{
    Pair,
    entry::{Entry, Measured, Scale},
    pair::Times,
};
use crate::unit::Micros;

/// Harmonic mean of precision and recall, within a window.
pub static F1: Entry = Entry {
    key: "f1",
    title: "F1 within",
    scale: Scale::Window,
    study: Some((
        "f1",
        "harmonic mean of precision and recall, for each window",
    )),
    blind_to: "",
    knows_a_redraw: true,
    symmetric: true,
    value: |of, within| {
        let [a, b] = of.pair.events();
        Some(share(2 * of.matched(within), a + b))
    },
};

/// Matched share of the judged events, within a window.
pub static PRECISION: Entry = Entry {
    key: "precision",
    title: "precision within",
    scale: Scale::Window,
    study: Some((
        "precision",
        "matched share of the point's events, for each window",
    )),
    blind_to: "",
    knows_a_redraw: true,
    symmetric: false,
    value: |of, within| {
        let [reference, judged] = of.pair.events();
        part(of.matched(within), judged, reference)
    },
};

/// Matched share of the reference's events, within a window.
pub static RECALL: Entry = Entry {
    key: "recall",
    title: "recall within",
    scale: Scale::Window,
    study: Some((
        "recall",
        "matched share of the reference's events, for each window",
    )),
    blind_to: "",
    knows_a_redraw: true,
    symmetric: false,
    value: |of, within| {
        let [reference, judged] = of.pair.events();
        part(of.matched(within), reference, judged)
    },
};

/// How many events match within a window, kept while a pair is measured.
#[derive(Clone, Copy)]
struct Matched(u64);

impl Measured<'_> {
    /// How many events match within a window.
    #[must_use]
    pub fn matched(&self, within: Micros) -> u64 {
        self.shared(within, || Matched(matched(self.pair, within)))
            .0
    }
}

/// What was matched.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Matches {
    /// Number of events, [reference, judged].
    events: [u64; 2],
    /// Judged minus reference of every match, in microseconds, ascending.
    errors: Vec<i64>,
}

/// Matches the events of a pair within `within`.
#[must_use]
pub fn matches(pair: &Pair, within: Micros) -> Matches {
    let mut errors = pair.fold(
        Vec::new,
        |errors, reference, judged| {
            pairs(reference, judged, within, |a, b| {
                errors.push(difference(b, a));
            });
        },
        |mut all, mut more| {
            all.append(&mut more);
            all
        },
    );
    errors.par_sort_unstable();
    Matches {
        events: pair.events(),
        errors,
    }
}

/// How many events of a pair match within `within`.
#[must_use]
pub fn matched(pair: &Pair, within: Micros) -> u64 {
    pair.fold(
        || 0,
        |matched, reference, judged| pairs(reference, judged, within, |_, _| *matched += 1),
        |a, b| a + b,
    )
}

/// How many events of one cell match within `within`.
#[must_use]
pub fn matched_of_cell(reference: Times<'_>, judged: Times<'_>, within: Micros) -> u64 {
    let mut matched = 0;
    pairs(reference, judged, within, |_, _| matched += 1);
    matched
}

/// Finds the matches of one cell.
fn pairs(reference: Times<'_>, judged: Times<'_>, within: Micros, mut found: impl FnMut(u64, u64)) {
    let (mut a, mut b) = (reference.iter().peekable(), judged.iter().peekable());
    while let (Some(&ta), Some(&tb)) = (a.peek(), b.peek()) {
        if ta.abs_diff(tb) <= within.0 {
            found(ta, tb);
            a.next();
            b.next();
        } else if ta < tb {
            a.next();
        } else {
            b.next();
        }
    }
}

/// `a - b`, held to what 64 bits with a sign can say.
fn difference(a: u64, b: u64) -> i64 {
    let size = i64::try_from(a.abs_diff(b)).unwrap_or(i64::MAX);
    if a < b { -size } else { size }
}

impl Matches {
    /// How many.
    #[must_use]
    pub fn matched(&self) -> u64 {
        self.errors.len() as u64
    }

    /// Matched share of the judged events; none when only the reference has events.
    #[must_use]
    pub fn precision(&self) -> Option<f64> {
        part(self.matched(), self.events[1], self.events[0])
    }

    /// Matched share of the reference's events; none when only the judged packet has events.
    #[must_use]
    pub fn recall(&self) -> Option<f64> {
        part(self.matched(), self.events[0], self.events[1])
    }

    /// Harmonic mean of precision and recall.
    #[must_use]
    pub fn f1(&self) -> f64 {
        share(2 * self.matched(), self.events[0] + self.events[1])
    }

    /// How late the judged events are; none without matches.
    #[must_use]
    pub fn time_error(&self) -> Option<Quantiles> {
        Quantiles::from_ascending(&self.errors)
    }
}

/// The matched share of one packet's events; none where only the other has events.
fn part(matched: u64, own: u64, other: u64) -> Option<f64> {
    (own > 0 || other == 0).then(|| share(matched, own))
}

/// A part of a whole; all of nothing is 1.
pub(crate) fn share(part: u64, whole: u64) -> f64 {
    if whole == 0 {
        1.0
    } else {
        part as f64 / whole as f64
    }
}

/// Quantiles by nearest rank: `q` is the smallest value that at least a share `q` of all do
/// not exceed, so each is a value that occurs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Quantiles {
    /// The smallest.
    pub min: i64,
    /// 5 %.
    pub p05: i64,
    /// 25 %.
    pub p25: i64,
    /// Half.
    pub p50: i64,
    /// 75 %.
    pub p75: i64,
    /// 95 %.
    pub p95: i64,
    /// The largest.
    pub max: i64,
}

impl Quantiles {
    /// Of values in ascending order; none of nothing.
    #[must_use]
    pub fn from_ascending(ascending: &[i64]) -> Option<Self> {
        let at = |percent: usize| {
            let rank = (ascending.len() * percent).div_ceil(100);
            ascending.get(rank.saturating_sub(1)).copied()
        };
        Some(Self {
            min: at(0)?,
            p05: at(5)?,
            p25: at(25)?,
            p50: at(50)?,
            p75: at(75)?,
            p95: at(95)?,
            max: at(100)?,
        })
    }
}
