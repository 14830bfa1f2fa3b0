//! Van Rossum's distance (Neural Computation 13:751, 2001, doi:10.1162/089976601300014321).
//!
//! Each event of a cell becomes a step that decays with the time constant `tau`; the distance
//! is the squared difference of the two traces, over all time:
//!
//! `D2 = 1/tau int (f - g)^2 dt = 1/2 sum_ij s_i s_j exp(-|t_i - t_j| / tau)`
//!
//! over the events of both packets, `s` being +1 for the reference and -1 for the judged one.
//! Summed over cells and divided by the mean number of events of the two packets. So an event
//! that is missing costs about 1/2, one that is late by `d` costs `1 - exp(-d / tau)`, and
//! streams that know nothing of each other come to about 1, less where events are regular.
//!
//! The sum is closed and takes one walk: with `m` the decayed sum of all signs so far, the
//! events of one time, `k` reference events more than judged ones, add `k^2/2 + k m`.
//! Events that both have at one time cancel exactly.

use super::{
    Pair,
    entry::{Entry, Scale},
};
use crate::{elementary, unit::Micros};

/// Van Rossum's distance per event, at a time constant.
pub static ENTRY: Entry = Entry {
    key: "van_rossum",
    title: "van Rossum,",
    scale: Scale::TimeConstant,
    study: Some((
        "van-rossum",
        "van Rossum's distance per event, for each time constant",
    )),
    blind_to: "",
    knows_a_redraw: true,
    symmetric: true,
    value: |of, tau| Some(distance(of.pair, tau)),
};

/// The distance at the time constant `tau`, per event; 0 for identical packets.
#[must_use]
pub fn distance(pair: &Pair, tau: Micros) -> f64 {
    let total = pair.fold(
        || 0.0,
        |sum, reference, judged| *sum += squared(reference.iter(), judged.iter(), tau.0 as f64),
        |a, b| a + b,
    );
    pair.per_event(total)
}

/// The squared distance of two trains, both ascending.
fn squared(
    reference: impl Iterator<Item = u64>,
    judged: impl Iterator<Item = u64>,
    tau: f64,
) -> f64 {
    let (mut a, mut b) = (reference.peekable(), judged.peekable());
    let (mut sum, mut trace, mut last) = (0.0, 0.0, 0);
    while let Some(t) = a.peek().into_iter().chain(b.peek()).min().copied() {
        let mut surplus = 0.0;
        while a.next_if_eq(&t).is_some() {
            surplus += 1.0;
        }
        while b.next_if_eq(&t).is_some() {
            surplus -= 1.0;
        }
        // What cancels leaves no trace; what decayed to nothing needs no exponential.
        if surplus != 0.0 {
            if trace != 0.0 {
                trace *= elementary::exp(-((t - last) as f64) / tau);
            }
            sum += surplus * (0.5 * surplus + trace);
            trace += surplus;
            last = t;
        }
    }
    // Rounding may leave a little less than nothing.
    f64::max(sum, 0.0)
}
