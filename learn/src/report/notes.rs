//! What a report cannot say, in sentences.

use std::collections::BTreeSet;

use super::{Report, metric::Metric};
use crate::record::Remark;

impl Report {
    /// What is to be said of arms, a line for each thing: of all of an arm's targets and seeds where it
    /// is the same of all, else of each by its name.
    #[must_use]
    pub fn remarks(&self) -> Vec<String> {
        let mut lines: Vec<String> = Vec::new();
        for one in &self.record.remarks {
            let own = |of: &&Remark| of.arm == one.arm;
            let alike = |of: &&Remark| own(of) && of.what == one.what;
            let all: BTreeSet<(u64, u64)> = { self.record.rows.iter() }
                .filter(|row| row.arm == one.arm)
                .map(|row| (row.target.to_bits(), row.seed))
                .collect();
            let same = self.record.remarks.iter().filter(alike).count() == all.len();
            let line = format!("{}: {}", if same { &one.arm } else { &one.of }, one.what);
            if !lines.contains(&line) {
                lines.push(line);
            }
        }
        lines
    }

    /// Why intervals, a metric or events are missing; empty where nothing is.
    pub(super) fn notes(&self) -> Vec<String> {
        let (rows, mut notes) = (&self.record.rows, Vec::new());
        let photographs: BTreeSet<&str> = rows.iter().map(|row| &*row.photograph).collect();
        let seeds: BTreeSet<u64> = rows.iter().map(|row| row.seed).collect();
        let lacking = [
            (
                photographs.len(),
                "photograph or video is held out",
                "photographs, at least 10, of which a fifth is held out: a video is one scene",
            ),
            (
                seeds.len(),
                "seed has run",
                "more seeds, such as `seeds = [1, 2, 3]`",
            ),
        ];
        for (_, what, more) in lacking.iter().filter(|(count, ..)| *count == 1) {
            notes.push(format!(
                "only one {what}, which says nothing about others: no difference is shown; use {more}"
            ));
        }
        let metrics = self.metrics();
        if metrics.contains(&Metric::Psnr) && !metrics.contains(&Metric::Ssim) {
            notes.push(
                "SSIM is not reported: its windows of 11x11 pixels do not fit into the held-out clips; set `crop` in [test] to 11 or more"
                    .to_owned(),
            );
        }
        for arm in &self.arms {
            let points = self.curve(arm, self.headline()).points;
            for point in points.iter().filter(|p| p.target > 0.0 && p.events == 0.0) {
                notes.push(format!(
                    "{arm}: no event on the held-out clips, where {} per pixel and pair were asked for",
                    point.target
                ));
            }
        }
        notes
    }
}
