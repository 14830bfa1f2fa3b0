//! Rate maps: the counts of every pixel and kind, as two pictures.
//!
//! Unsigned the map holds ON + OFF, signed ON - OFF. Pearson is over all pixels and kinds,
//! silent ones too; L1 is the sum of the differences divided by the events of both packets, 0
//! to 1. The rates of both maps are counts over the same time, which drops out of either.
//!
//! Blind to time altogether; the unsigned map is blind to sign, the signed one to ON and OFF
//! in equal numbers.

use super::{
    Pair,
    entry::{Entry, Measured, Scale},
    pearson::Pearson,
};
use crate::unit::Micros;

/// Pearson of the map of ON + OFF.
pub static PEARSON: Entry = Entry {
    key: "rate_pearson",
    title: "rate map, Pearson",
    scale: Scale::None,
    study: Some(("rate-pearson", "Pearson of the map of ON + OFF")),
    blind_to: "time, sign",
    knows_a_redraw: false,
    symmetric: true,
    value: |of, _| of.rates().unsigned.pearson,
};

/// L1 of the map of ON + OFF, per event.
pub static L1: Entry = Entry {
    key: "rate_l1",
    title: "rate map, L1",
    scale: Scale::None,
    study: Some(("rate-l1", "L1 of the map of ON + OFF, per event")),
    blind_to: "time, sign",
    knows_a_redraw: false,
    symmetric: true,
    value: |of, _| Some(of.rates().unsigned.l1),
};

/// Pearson of the map of ON - OFF.
pub static SIGNED_PEARSON: Entry = Entry {
    key: "signed_rate_pearson",
    title: "signed map, Pearson",
    scale: Scale::None,
    study: None,
    blind_to: "time, ON with OFF",
    knows_a_redraw: false,
    symmetric: true,
    value: |of, _| of.rates().signed.pearson,
};

/// L1 of the map of ON - OFF, per event.
pub static SIGNED_L1: Entry = Entry {
    key: "signed_rate_l1",
    title: "signed map, L1",
    scale: Scale::None,
    study: None,
    blind_to: "time, ON with OFF",
    knows_a_redraw: false,
    symmetric: true,
    value: |of, _| Some(of.rates().signed.l1),
};

impl Measured<'_> {
    /// How the rate maps differ.
    #[must_use]
    pub fn rates(&self) -> Rates {
        self.shared(Micros(0), || rates(self.pair))
    }
}

/// How two maps differ.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Map {
    /// Correlation, -1 to 1; none when either map is the same everywhere.
    pub pearson: Option<f64>,
    /// Sum of the differences per event, 0 to 1.
    pub l1: f64,
}

/// Both maps.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Rates {
    /// ON + OFF.
    pub unsigned: Map,
    /// ON - OFF.
    pub signed: Map,
}

/// Compares the rate maps of a pair.
#[must_use]
pub fn rates(pair: &Pair) -> Rates {
    let [unsigned, signed] = pair.fold_sites(
        || [(Pearson::default(), 0_u128); 2],
        |sums, reference, judged| {
            let maps = |[off, on]: [u64; 2]| {
                let (off, on) = (i128::from(off), i128::from(on));
                [on + off, on - off]
            };
            let (a, b) = (maps(reference.counts()), maps(judged.counts()));
            for ((pearson, l1), (a, b)) in sums.iter_mut().zip(a.into_iter().zip(b)) {
                pearson.add(a, b);
                *l1 += (a - b).unsigned_abs();
            }
        },
        |[a, b], [c, d]| [(a.0.join(c.0), a.1 + c.1), (b.0.join(d.0), b.1 + d.1)],
    );
    let map = |(pearson, l1): (Pearson, u128)| Map {
        pearson: pearson.over(pair.site_count()),
        l1: pair.per_event(l1 as f64 / 2.0),
    };
    Rates {
        unsigned: map(unsigned),
        signed: map(signed),
    }
}
