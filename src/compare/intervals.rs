//! Divergence of the intervals between events.
//!
//! All intervals between two consecutive events of one cell, of all cells together, go into a
//! histogram: 0, 1, 2, 3 us have bins of their own, above that each doubling has four equal
//! bins. Over the bins from the smallest to the largest that either packet uses, each count is
//! raised by 1/2 (Krichevsky and Trofimov), and the divergence of Kullback and Leibler is
//! `sum p ln(p/q)`, in nats, `p` being the reference and `q` the judged packet; it is not
//! symmetric, so the other way round is given too.
//!
//! **Blind to wrong pixels, to delay, and to which cell said what**: a permutation of the
//! pixels gives exactly 0. Never use it alone.

use super::{
    Pair,
    entry::{Entry, Measured, Scale},
    pair::Times,
};
use crate::{elementary, unit::Micros};

/// Divergence of intervals, of the judged packet from the reference, in nats.
pub static ENTRY: Entry = Entry {
    key: "interval_divergence",
    title: "interval divergence",
    scale: Scale::None,
    study: Some((
        "intervals",
        "divergence of the intervals between a cell's events, in nats",
    )),
    blind_to: "wrong pixels, delay",
    knows_a_redraw: false,
    symmetric: false,
    value: |of, _| of.intervals().map(|d| d.forward),
};

/// The same the other way round.
pub static BACK: Entry = Entry {
    key: "interval_divergence_back",
    title: "  the other way",
    scale: Scale::None,
    study: None,
    blind_to: "wrong pixels, delay",
    knows_a_redraw: false,
    symmetric: false,
    value: |of, _| of.intervals().map(|d| d.back),
};

impl Measured<'_> {
    /// How the intervals differ; none when either packet has no interval.
    #[must_use]
    pub fn intervals(&self) -> Option<Divergence> {
        self.shared(Micros(0), || divergence(self.pair))
    }
}

/// Bins: four for each power of two that 64 bits hold, the first four being 0 to 3.
const BINS: usize = 4 * 63;

/// Both directions, in nats; none when either packet has no interval.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Divergence {
    /// Of the judged packet from the reference.
    pub forward: f64,
    /// Of the reference from the judged packet.
    pub back: f64,
}

/// Compares the intervals of a pair.
#[must_use]
pub fn divergence(pair: &Pair) -> Option<Divergence> {
    let [p, q] = pair.fold(
        || [Histogram::default(), Histogram::default()],
        |[p, q], reference, judged| {
            p.add(reference);
            q.add(judged);
        },
        |[p, q], [r, s]| [p.join(&r), q.join(&s)],
    );
    let used = |h: &Histogram| {
        let first = h.0.iter().position(|n| *n > 0)?;
        let last = h.0.iter().rposition(|n| *n > 0)?;
        Some((first, last))
    };
    let ((a, b), (c, d)) = (used(&p)?, used(&q)?);
    let bins = a.min(c)..=b.max(d);
    let shares = |h: &Histogram| -> Vec<f64> {
        let smooth = h.0[bins.clone()].iter().map(|n| *n as f64 + 0.5);
        let all: f64 = smooth.clone().sum();
        smooth.map(|n| n / all).collect()
    };
    let (p, q) = (shares(&p), shares(&q));
    let kl = |p: &[f64], q: &[f64]| {
        let sum: f64 = p
            .iter()
            .zip(q)
            .map(|(p, q)| p * elementary::ln(p / q))
            .sum();
        sum.max(0.0)
    };
    Some(Divergence {
        forward: kl(&p, &q),
        back: kl(&q, &p),
    })
}

#[derive(Clone)]
struct Histogram([u64; BINS]);

impl Default for Histogram {
    fn default() -> Self {
        Self([0; BINS])
    }
}

impl Histogram {
    fn add(&mut self, times: Times<'_>) {
        for (before, after) in times.iter().zip(times.iter().skip(1)) {
            self.0[bin(after - before)] += 1;
        }
    }

    fn join(mut self, other: &Self) -> Self {
        for (a, b) in self.0.iter_mut().zip(other.0) {
            *a += b;
        }
        self
    }
}

/// The bin of an interval.
const fn bin(interval: u64) -> usize {
    match interval.checked_ilog2() {
        None | Some(0 | 1) => interval as usize,
        Some(power) => 4 * (power as usize - 1) + (interval >> (power - 2) & 3) as usize,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_ascend_without_a_gap() {
        let mut last = 0;
        for interval in 0..100_000 {
            let bin = bin(interval);
            assert!(bin == last || bin == last + 1, "{interval}");
            last = bin;
        }
        assert_eq!(
            [4, 5, 6, 7, 8, 9, 10, 11, 12].map(bin),
            [4, 5, 6, 7, 8, 8, 9, 9, 10]
        );
        assert_eq!(bin(u64::MAX), BINS - 1);
    }
}
