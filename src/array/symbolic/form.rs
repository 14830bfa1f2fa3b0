//! Linear forms: what a cell holds, in terms of what went in.

use std::collections::{BTreeMap, btree_map::Entry};

use crate::{isa::Analog, number::Dyadic, plane::At};

/// What went in at one pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Input {
    /// The light that fell on the photodiode.
    Light,
    /// What a register held beforehand, in LSB.
    Register(Analog),
}

/// `constant + Σ weight · input`, inputs by place.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Form {
    pub(super) constant: Dyadic,
    /// Without zero weights.
    pub(super) taps: BTreeMap<(Input, At), Dyadic>,
}

impl Form {
    pub(super) fn constant(value: Dyadic) -> Self {
        Self {
            constant: value,
            taps: BTreeMap::new(),
        }
    }

    pub(super) fn input(input: Input, at: At) -> Self {
        Self {
            constant: Dyadic::ZERO,
            taps: [((input, at), Dyadic::ONE)].into(),
        }
    }

    /// The value, where nothing that went in matters.
    pub(super) fn known(&self) -> Option<Dyadic> {
        self.taps.is_empty().then_some(self.constant)
    }

    /// Adds `other`, so often; `None` beyond what [`Dyadic`] holds.
    pub(super) fn add(&mut self, other: &Self, times: i32) -> Option<()> {
        let times = Dyadic::from(times);
        self.constant = self.constant.plus(other.constant.times(times)?)?;
        for (tap, weight) in &other.taps {
            let more = weight.times(times)?;
            match self.taps.entry(*tap) {
                Entry::Vacant(entry) => {
                    if !more.is_zero() {
                        entry.insert(more);
                    }
                }
                Entry::Occupied(mut entry) => {
                    let sum = entry.get().plus(more)?;
                    if sum.is_zero() {
                        entry.remove();
                    } else {
                        entry.insert(sum);
                    }
                }
            }
        }
        Some(())
    }

    /// Each part mapped; `None` where one has no image.
    pub(super) fn map(&self, part: impl Fn(Dyadic) -> Option<Dyadic>) -> Option<Self> {
        let taps = self
            .taps
            .iter()
            .map(|(tap, weight)| Some((*tap, part(*weight)?)));
        Some(Self {
            constant: part(self.constant)?,
            taps: taps.collect::<Option<_>>()?,
        })
    }

    /// `-(form) / by`; `None` where that is not dyadic.
    pub(super) fn stored(&self, by: u32) -> Option<Self> {
        let minus = Dyadic::from(-1);
        self.map(|value| value.times(minus)?.divided(by))
    }
}
