//! What a run has shown: quality over bits, differences at equal bits, what silicon leaves.
//!
//! [`Report::read`] takes the `learn.json` of a run; [`Report::table`] is for a terminal,
//! [`Report::page`] one HTML file without script. A difference is "not shown" where its interval,
//! in the digits that are told, contains 0, and where there is one photograph or one seed.

mod chip;
mod curve;
mod difference;
mod error;
mod metric;
mod notes;
mod page;
mod surround;
mod table;

use std::{
    collections::{BTreeMap, BTreeSet},
    io::ErrorKind,
    path::Path,
};

pub use chip::{Kept, Stage};
pub use curve::{Curve, Point};
pub use difference::Difference;
pub use error::ReportError;
pub use metric::Metric;
pub use surround::Surround;

use crate::record::{Decoder, Form, KEPT_TASK, Record, Row, VERSION};

/// The file of a run that is read.
pub const FILE: &str = "learn.json";

/// Resamplings of each interval.
pub(crate) const RESAMPLES: u64 = 1000;

/// What a run has measured, to be told.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    record: Record,
    /// Arms in the order in which they were run.
    arms: Vec<String>,
    /// Seeds with which not all has run.
    left_out: Vec<u64>,
}

impl Report {
    /// From the folder of a run.
    ///
    /// # Errors
    /// When there is no record, it is of another version, or nothing was measured yet.
    pub fn read(run: &Path) -> Result<Self, ReportError> {
        let path = run.join(FILE);
        let text = std::fs::read_to_string(&path).map_err(|cause| {
            let path = path.clone();
            // Of a run that goes on, the record comes with the first arm.
            if cause.kind() == ErrorKind::NotFound && run.join(KEPT_TASK).exists() {
                return ReportError::Nothing { path };
            }
            ReportError::Unreadable { path, cause }
        })?;
        let record: Record = serde_json::from_str(&text).map_err(|cause| ReportError::Damaged {
            path: path.clone(),
            cause,
        })?;
        if record.version != VERSION {
            return Err(ReportError::Version {
                path,
                got: record.version,
            });
        }
        if record.rows.is_empty() {
            return Err(ReportError::Nothing { path });
        }
        Ok(Self::new(record))
    }

    /// Of a record that is at hand. A seed with which some arm and target has not run yet is left out,
    /// where another has run with all: means over unequal seeds are no comparison.
    #[must_use]
    pub fn new(mut record: Record) -> Self {
        let left_out = incomplete(&record.rows);
        record.rows.retain(|row| !left_out.contains(&row.seed));
        record.kernels.retain(|at| !left_out.contains(&at.seed));
        record.remarks.retain(|of| !left_out.contains(&of.seed));
        let mut arms: Vec<String> = Vec::new();
        for row in &record.rows {
            if !arms.contains(&row.arm) {
                arms.push(row.arm.clone());
            }
        }
        Self {
            record,
            arms,
            left_out,
        }
    }

    /// The record.
    #[must_use]
    pub const fn record(&self) -> &Record {
        &self.record
    }

    /// Arms in the order in which they were run.
    #[must_use]
    pub fn arms(&self) -> &[String] {
        &self.arms
    }

    /// The metrics that were measured, the first of them the headline.
    #[must_use]
    pub fn metrics(&self) -> Vec<Metric> {
        let measured =
            |metric: &Metric| self.record.rows.iter().any(|row| metric.of(row).is_some());
        Metric::ALL.into_iter().filter(measured).collect()
    }

    /// The metric that differences are told in.
    #[must_use]
    pub fn headline(&self) -> Metric {
        self.metrics().first().copied().unwrap_or(Metric::Psnr)
    }

    /// How an arm as it was trained became, over its bits.
    #[must_use]
    pub fn curve(&self, arm: &str, metric: Metric) -> Curve {
        self.curve_of((arm, Form::Trained, Decoder::Own), metric)
    }

    /// The same for another form of it.
    #[must_use]
    pub fn curve_of(&self, of: (&str, Form, Decoder), metric: Metric) -> Curve {
        Curve::new(&self.record.rows, of, metric)
    }

    /// How much better `a` is than `b` at equal bits, both as they were trained; `None` where they
    /// have no bits in common.
    #[must_use]
    pub fn difference(&self, a: &str, b: &str, metric: Metric) -> Option<Difference> {
        let own = |arm| (arm, Form::Trained, Decoder::Own);
        Difference::new(&self.record.rows, (own(a), own(b)), metric)
    }

    /// What of each arm is left on the chip, for the arms that were compiled.
    #[must_use]
    pub fn kept(&self) -> Vec<Kept> {
        let arms = self.arms.iter();
        arms.filter_map(|arm| Kept::new(self, arm)).collect()
    }

    /// Whether the deltas of the arm `fs-dvs` became centre and surround; `None` without one.
    #[must_use]
    pub fn surround(&self) -> Option<Surround> {
        Surround::new(&self.record.kernels, "fs-dvs")
    }

    /// The arms that make events, as they were trained.
    fn with_events(&self) -> Vec<&str> {
        let rows = &self.record.rows;
        let events = |arm: &&String| rows.iter().any(|row| row.arm == **arm && row.bits > 0);
        self.arms
            .iter()
            .filter(events)
            .map(String::as_str)
            .collect()
    }
}

/// Seeds that lack an arm and target that another seed has; none where all do.
fn incomplete(rows: &[Row]) -> Vec<u64> {
    let runs: BTreeSet<(&str, u64)> = rows.iter().map(run).collect();
    let mut seeds: BTreeMap<u64, BTreeSet<(&str, u64)>> = BTreeMap::new();
    for row in rows {
        seeds.entry(row.seed).or_default().insert(run(row));
    }
    let all = seeds.len();
    let lacking = seeds.iter().filter(|(_, own)| own.len() < runs.len());
    let lacking: Vec<u64> = lacking.map(|(seed, _)| *seed).collect();
    if lacking.len() == all {
        Vec::new()
    } else {
        lacking
    }
}

/// What is run with each seed.
fn run(row: &Row) -> (&str, u64) {
    (&row.arm, row.target.to_bits())
}
