//! How many events, by sign and kind, and cell by cell.
//!
//! With `a` and `b` the counts of a cell in the reference and in the judged packet, over all
//! cells of the sensor, silent ones included:
//!
//! - L1 is the sum of `|a - b|`. ON and OFF are cells of their own, so they do not cancel.
//! - Pearson is `cov(a, b) / sqrt(var(a) var(b))`; none when either does not vary.
//!
//! Both are blind to time.

use super::{
    Pair,
    entry::{Entry, Measured, Scale},
    pearson::Pearson,
};
use crate::{
    event::{Polarity, address::AddressWord},
    unit::Micros,
};

/// Pearson of counts, cell by cell.
pub static PEARSON: Entry = Entry {
    key: "count_pearson",
    title: "counts, Pearson",
    scale: Scale::None,
    study: Some(("count-pearson", "Pearson of counts, cell by cell")),
    blind_to: "time",
    knows_a_redraw: false,
    symmetric: true,
    value: |of, _| of.cells().pearson,
};

/// L1 of counts per event, cell by cell.
pub static L1: Entry = Entry {
    key: "count_l1",
    title: "counts, L1",
    scale: Scale::None,
    study: Some(("count-l1", "L1 of counts per event, cell by cell")),
    blind_to: "time",
    knows_a_redraw: false,
    symmetric: true,
    value: |of, _| Some(of.pair.per_event(of.cells().l1 as f64 / 2.0)),
};

/// Events of the judged packet for one of the reference.
pub static EVENTS: Entry = Entry {
    key: "events_ratio",
    title: "events, ratio",
    scale: Scale::None,
    study: None,
    blind_to: "all but number",
    knows_a_redraw: false,
    symmetric: false,
    value: |of, _| {
        let [a, b] = of.pair.events();
        (a > 0).then(|| b as f64 / a as f64)
    },
};

/// Bits of the judged packet, each event one address word.
pub static BITS: Entry = Entry {
    key: "bits_sent",
    title: "bits",
    scale: Scale::None,
    study: None,
    blind_to: "all but number",
    knows_a_redraw: false,
    symmetric: false,
    value: |of, _| {
        let word = AddressWord::new(of.pair.size(), of.pair.channels());
        Some(of.pair.events()[1] as f64 * f64::from(word.bits()))
    },
};

impl Measured<'_> {
    /// How the counts of cells differ.
    #[must_use]
    pub fn cells(&self) -> Cells {
        self.shared(Micros(0), || cells(self.pair))
    }
}

/// Counts of one kind of cell; pairs are [reference, judged].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Kind {
    /// Which, from 0.
    pub channel: u8,
    /// ON events.
    pub on: [u64; 2],
    /// OFF events.
    pub off: [u64; 2],
}

/// Counts by kind of cell, one entry a kind.
#[must_use]
pub fn kinds(pair: &Pair) -> Vec<Kind> {
    let mut kinds: Vec<Kind> = (0..pair.channels())
        .map(|channel| Kind {
            channel,
            ..Kind::default()
        })
        .collect();
    for (cell, reference, judged) in pair.cells() {
        // A pair holds no event of a channel that it does not have.
        if let Some(kind) = kinds.get_mut(usize::from(cell.channel())) {
            let [a, b] = match cell.polarity() {
                Polarity::On => &mut kind.on,
                Polarity::Off => &mut kind.off,
            };
            *a += reference.len() as u64;
            *b += judged.len() as u64;
        }
    }
    kinds
}

/// Counts compared cell by cell.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Cells {
    /// Correlation of the counts, -1 to 1; none when either side has the same count in every
    /// cell.
    pub pearson: Option<f64>,
    /// Sum of the differences, in events.
    pub l1: u64,
    /// The busiest cell, [reference, judged].
    pub max: [u64; 2],
    /// Cells that spoke, [reference, judged].
    pub active: [u64; 2],
}

/// Compares counts cell by cell.
#[must_use]
pub fn cells(pair: &Pair) -> Cells {
    let (mut max, mut active, mut l1) = ([0; 2], [0; 2], 0);
    let mut pearson = Pearson::default();
    for (_, reference, judged) in pair.cells() {
        let counts = [reference.len() as u64, judged.len() as u64];
        l1 += counts[0].abs_diff(counts[1]);
        for side in 0..2 {
            max[side] = counts[side].max(max[side]);
            active[side] += u64::from(counts[side] > 0);
        }
        pearson.add(counts[0].into(), counts[1].into());
    }
    Cells {
        pearson: pearson.over(pair.cell_count()),
        l1,
        max,
        active,
    }
}
