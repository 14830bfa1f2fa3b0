//! The report for a terminal.

use std::fmt::Write as _;

use amacrine::unit::{counted, fixed, signed};

use super::{Report, difference::Difference, metric::Metric, surround::DIGITS};

impl Report {
    /// Points, differences at equal bits, what silicon leaves, the surround of `fs-dvs`.
    #[must_use]
    pub fn table(&self) -> String {
        let (mut text, metrics, headline) = (String::new(), self.metrics(), self.headline());
        let _ = writeln!(text, "{}", self.summary());
        let width = self.arms.iter().map(String::len).max().unwrap_or(0).max(12);
        let _ = write!(text, "\n{:width$} {:>12} {:>12}", "arm", "events", "bits");
        let wide = |metric: &Metric| metric.label().len().max(12);
        for metric in &metrics {
            let _ = write!(text, " {:>1$}", metric.label(), wide(metric));
        }
        text.push_str("      (events and bits: a pixel and pair)\n");
        for arm in &self.arms {
            let curves: Vec<_> = metrics
                .iter()
                .map(|metric| self.curve(arm, *metric))
                .collect();
            let Some(first) = curves.first() else {
                continue;
            };
            for (n, point) in first.points.iter().enumerate() {
                let _ = write!(
                    text,
                    "{arm:width$} {:12.4} {:12.3}",
                    point.events, point.bits
                );
                for (metric, curve) in metrics.iter().zip(&curves) {
                    let quality = curve.points.get(n).map_or(f64::NAN, |point| point.quality);
                    let (digits, wide) = (metric.digits(), wide(metric));
                    let _ = write!(text, " {:>wide$}", fixed(quality, digits));
                }
                text.push('\n');
            }
        }
        let pairs = self.pairs();
        if !pairs.is_empty() {
            let _ = writeln!(
                text,
                "\nat equal bits, {}, with 95 % over photographs and seeds:",
                headline.label()
            );
            let wide = pairs
                .iter()
                .map(|(a, b, _)| a.len() + b.len() + 7)
                .max()
                .unwrap_or(0);
            for (a, b, difference) in &pairs {
                let what = format!("{a} minus {b}");
                let _ = writeln!(
                    text,
                    "{what:wide$}  {}",
                    told(difference.as_ref(), headline)
                );
            }
        }
        let kept = self.kept();
        if !kept.is_empty() {
            let _ = writeln!(text, "\non the chip:");
            let wide = self.arms.iter().map(String::len).max().unwrap_or(0);
            for arm in &kept {
                for stage in &arm.stages {
                    let change = stage.change.as_ref();
                    for point in &stage.curve.points {
                        let _ = writeln!(
                            text,
                            "{:wide$}  {:16} decoder {:9} {:8.3} bits {:>8} {}",
                            arm.arm,
                            stage.form.name(),
                            stage.decoder.name(),
                            point.bits,
                            fixed(point.quality, headline.digits()),
                            headline.label(),
                        );
                    }
                    if change.is_some() {
                        let told = told(change, headline);
                        let _ = writeln!(text, "{:wide$}  against the float model: {told}", "");
                    }
                }
            }
            for arm in &kept {
                if let Some(verdict) = arm.verdict(headline) {
                    let _ = writeln!(text, "{verdict}");
                }
            }
        }
        let remarks = self.remarks();
        if !remarks.is_empty() {
            text.push_str("\nto be known of arms:\n");
            for remark in remarks {
                let _ = writeln!(text, "{remark}");
            }
        }
        if let Some(line) = self.surround_line() {
            let _ = writeln!(text, "\n{line}");
        }
        for line in self.notes() {
            let _ = writeln!(text, "\n{line}");
        }
        text
    }

    /// What was run, in a line.
    pub(super) fn summary(&self) -> String {
        let record = &self.record;
        let count = |of: &dyn Fn(&crate::record::Row) -> String| {
            let mut all: Vec<String> = record.rows.iter().map(of).collect();
            all.sort_unstable();
            all.dedup();
            all.len()
        };
        let left_out: Vec<String> = self.left_out.iter().map(u64::to_string).collect();
        let left_out = match left_out.as_slice() {
            [] => String::new(),
            [seed] => format!("; seed {seed} is left out: not all arms have run with it"),
            seeds => {
                let seeds = seeds.join(", ");
                format!("; seeds {seeds} are left out: not all arms have run with them")
            }
        };
        format!(
            "{}, {}: {}, {}, {} of {} of {}x{}; judged on {} of {}{left_out}",
            record.task,
            record.goal,
            counted(self.arms.len(), "arm"),
            counted(count(&|row| row.seed.to_string()), "seed"),
            counted(record.steps, "step"),
            counted(record.batch, "clip"),
            record.crop,
            record.crop,
            counted(count(&|row| row.clip.to_string()), "clip"),
            match count(&|row| row.photograph.clone()) {
                1 => "1 held-out photograph or video".to_owned(),
                more => counted(more, "held-out photograph"),
            },
        )
    }

    /// All pairs of arms with events, the later one against the earlier.
    pub(super) fn pairs(&self) -> Vec<(String, String, Option<Difference>)> {
        let (arms, metric) = (self.with_events(), self.headline());
        let mut pairs = Vec::new();
        for (n, b) in arms.iter().enumerate() {
            for a in &arms[n + 1..] {
                pairs.push((
                    (*a).to_owned(),
                    (*b).to_owned(),
                    self.difference(a, b, metric),
                ));
            }
        }
        pairs
    }

    /// The answer to the question of `fs-dvs`, where it was asked.
    pub(super) fn surround_line(&self) -> Option<String> {
        let found = self.surround()?;
        let [low, high] = found.interval;
        Some(format!(
            "fs-dvs: does a delta before a logarithmic response become centre and surround? {}; its surround weighs {} of its centre, {}",
            found.answer(),
            signed(found.mean, DIGITS),
            if low.is_finite() {
                let seeds = found.seeds.len();
                let [low, high] = [low, high].map(|end| signed(end, DIGITS));
                format!("from {low} to {high} (95 % over {seeds} seeds)")
            } else {
                "and one seed gives no interval".to_owned()
            },
        ))
    }
}

/// A difference and whether it is shown.
pub(super) fn told(difference: Option<&Difference>, metric: Metric) -> String {
    let Some(own) = difference else {
        return "no bits in common".to_owned();
    };
    let digits = metric.digits();
    let [low, high] = own.interval;
    let mean = signed(own.mean, digits);
    if !(low.is_finite() && high.is_finite()) {
        return format!("{mean}, no interval: not shown");
    }
    let over = match (own.photographs, own.seeds) {
        (1, _) => " over seeds alone",
        (_, 1) => " over photographs alone",
        _ => "",
    };
    let verdict = match (own.shown(metric), own.mean * metric.sign() > 0.0) {
        (false, _) => "not shown",
        (true, true) => "better",
        (true, false) => "worse",
    };
    let [low, high] = [low, high].map(|end| signed(end, digits));
    format!("{mean}, from {low} to {high}{over}: {verdict}")
}
