//! The list of metrics, and what each says of itself.
//!
//! A new metric is a file beside this one, with its [`Entry`], and a line of [`ENTRIES`]. From
//! the list come the tables and JSON of `compare`, what studies may ask for, and the pages.

use std::fmt;

pub use super::entry::{Entry, Measured, Scale};

use super::{counts, intervals, matching, rates, van_rossum, victor_purpura, voxel, window};
use crate::unit::Micros;

/// All metrics, in the order in which they are shown. Those of one scale stand together.
pub const ENTRIES: &[&Entry] = &[
    &window::KEPT,
    &matching::F1,
    &matching::PRECISION,
    &matching::RECALL,
    &van_rossum::ENTRY,
    &victor_purpura::ENTRY,
    &voxel::L1,
    &voxel::L1_SIGNS_APART,
    &voxel::RMSE,
    &counts::PEARSON,
    &counts::L1,
    &rates::PEARSON,
    &rates::L1,
    &rates::SIGNED_PEARSON,
    &rates::SIGNED_L1,
    &intervals::ENTRY,
    &intervals::BACK,
    &counts::EVENTS,
    &counts::BITS,
];

impl Entry {
    /// The metric at each scale, or alone where it has none.
    pub fn metrics(&'static self, scales: &[Micros]) -> impl Iterator<Item = Metric> {
        let alone = (self.scale == Scale::None).then(|| self.alone());
        let at: &[Micros] = if alone.is_some() { &[] } else { scales };
        alone.into_iter().chain(at.iter().map(|at| self.at(*at)))
    }

    /// The metric, which has no scale.
    #[must_use]
    pub const fn alone(&'static self) -> Metric {
        Metric(self, None)
    }

    /// The metric at a scale.
    #[must_use]
    pub const fn at(&'static self, scale: Micros) -> Metric {
        Metric(self, Some(scale))
    }

    /// The metric that studies call by this name.
    #[must_use]
    pub fn in_studies(name: &str) -> Option<&'static Self> {
        let mut all = ENTRIES.iter().copied();
        all.find(|entry| entry.study.is_some_and(|(own, _)| own == name))
    }
}

const fn count_in_studies() -> usize {
    let (mut i, mut count) = (0, 0);
    while i < ENTRIES.len() {
        count += ENTRIES[i].study.is_some() as usize;
        i += 1;
    }
    count
}

/// The metrics that studies may ask for: their names, and what each is.
pub const IN_STUDIES: [(&str, &str); count_in_studies()] = {
    let mut names = [("", ""); count_in_studies()];
    let (mut i, mut count) = (0, 0);
    while i < ENTRIES.len() {
        if let Some(study) = ENTRIES[i].study {
            names[count] = study;
            count += 1;
        }
        i += 1;
    }
    names
};

/// A metric at its scale.
#[derive(Clone, Copy, Debug)]
pub struct Metric(&'static Entry, Option<Micros>);

impl PartialEq for Metric {
    fn eq(&self, other: &Self) -> bool {
        self.0.key == other.0.key && self.1 == other.1
    }
}

impl Eq for Metric {}

impl Metric {
    /// Which of the list.
    #[must_use]
    pub const fn entry(self) -> &'static Entry {
        self.0
    }

    /// Name in files: letters, digits and `_`.
    #[must_use]
    pub fn key(self) -> String {
        match self.1 {
            None => self.0.key.into(),
            Some(at) => format!("{}_{}", self.0.key, Short(at)),
        }
    }

    /// Its value; none where it has none.
    #[must_use]
    pub fn value(self, of: &Measured<'_>) -> Option<f64> {
        (self.0.value)(of, self.1.unwrap_or_default())
    }
}

impl fmt::Display for Metric {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.1 {
            None => f.write_str(self.0.title),
            Some(at) => write!(f, "{} {}", self.0.title, Short(at)),
        }
    }
}

/// A time in the largest unit that keeps it whole: `1us`, `10ms`.
#[derive(Clone, Copy, Debug)]
pub struct Short(pub Micros);

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0.0 {
            us if us > 0 && us.is_multiple_of(1_000_000) => write!(f, "{}s", us / 1_000_000),
            us if us > 0 && us.is_multiple_of(1_000) => write!(f, "{}ms", us / 1_000),
            us => write!(f, "{us}us"),
        }
    }
}
