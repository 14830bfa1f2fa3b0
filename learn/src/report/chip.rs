//! What of an arm is left on the chip.

use std::collections::BTreeSet;

use amacrine::unit::{fixed, signed};

use super::{Report, curve::Curve, difference::Difference, metric::Metric};
use crate::record::{Decoder, Form, Row};

/// The arm that others are to beat, and the one whose win over it is to be kept.
const BASE: &str = "dvs";
const FLOAT: &str = "rgc";

/// An arm in its forms, from the float model to silicon.
#[derive(Clone, Debug, PartialEq)]
pub struct Kept {
    /// The arm.
    pub arm: String,
    /// Its forms in order.
    pub stages: Vec<Stage>,
    /// On silicon over [`BASE`] as trained, with each decoder that there is; empty without such bits.
    pub won: Vec<(Decoder, Difference)>,
    /// What [`FLOAT`] wins over [`BASE`], on the clips that the chip was shown.
    pub float: Option<Difference>,
    /// Whether [`BASE`] and [`FLOAT`] took part.
    took_part: [bool; 2],
}

/// An arm in one form with one decoder.
#[derive(Clone, Debug, PartialEq)]
pub struct Stage {
    /// What made the events.
    pub form: Form,
    /// Whose decoder.
    pub decoder: Decoder,
    /// Quality over bits.
    pub curve: Curve,
    /// Against the arm as it was trained, at equal bits.
    pub change: Option<Difference>,
}

impl Kept {
    pub(super) fn new(report: &Report, arm: &str) -> Option<Self> {
        let (rows, metric) = (&report.record.rows, report.headline());
        // The chip may have been shown fewer clips: all forms are told on those of all.
        let own: Vec<Row> = rows.iter().filter(|row| row.arm == arm).cloned().collect();
        let shown: BTreeSet<u64> = { own.iter() }
            .filter(|row| row.form != Form::Trained)
            .map(|row| row.clip)
            .collect();
        let common: Vec<Row> = { own.into_iter() }
            .filter(|row| shown.contains(&row.clip))
            .collect();
        let trained = (arm, Form::Trained, Decoder::Own);
        let mut stages = Vec::new();
        for form in [Form::Trained, Form::Quantised, Form::Exact, Form::Silicon] {
            for decoder in [Decoder::Own, Decoder::Retrained] {
                let of = (arm, form, decoder);
                let curve = Curve::new(&common, of, metric);
                if !curve.points.is_empty() {
                    let change =
                        (of != trained).then(|| Difference::new(&common, (of, trained), metric));
                    stages.push(Stage {
                        form,
                        decoder,
                        curve,
                        change: change.flatten(),
                    });
                }
            }
        }
        stages.iter().find(|stage| stage.form != Form::Trained)?;
        let base = (BASE, Form::Trained, Decoder::Own);
        // What the float kernel wins is told on the same clips: a part of a win on others is none.
        let rows: Vec<Row> = { rows.iter() }
            .filter(|row| shown.contains(&row.clip))
            .cloned()
            .collect();
        let against = |of| Difference::new(&rows, (of, base), metric);
        Some(Self {
            arm: arm.to_owned(),
            won: [Decoder::Own, Decoder::Retrained]
                .into_iter()
                .filter_map(|decoder| Some((decoder, against((arm, Form::Silicon, decoder))?)))
                .collect(),
            float: against((FLOAT, Form::Trained, Decoder::Own)),
            took_part: [BASE, FLOAT].map(|arm| report.arms.iter().any(|own| own == arm)),
            stages,
        })
    }

    /// Whether half of what the float kernel wins over `dvs` is kept on silicon, in a sentence;
    /// `None` of `dvs` itself.
    #[must_use]
    pub fn verdict(&self, metric: Metric) -> Option<String> {
        (self.arm != BASE).then(|| self.sentence(metric))
    }

    /// Why nothing can be said of it.
    fn silent(&self) -> Option<String> {
        if !self.took_part[0] {
            return Some(format!(
                "`{BASE}` did not take part, so there is nothing to compare it with"
            ));
        }
        { self.won.is_empty() }
            .then(|| format!("on silicon it has no bits in common with `{BASE}` as it was trained"))
    }

    fn sentence(&self, metric: Metric) -> String {
        if let Some(why) = self.silent() {
            return format!("{}: {why}", self.arm);
        }
        let (sign, digits) = (metric.sign(), metric.digits());
        let label = metric.label();
        let told = |number: f64| signed(number, digits);
        let on_silicon = |(decoder, won): &(Decoder, Difference)| {
            let mut ends = won.interval.map(|end| end * sign);
            ends.sort_by(f64::total_cmp);
            let own = won.mean * sign;
            let ends = if won.interval.iter().all(|end| end.is_finite()) {
                format!("{} to {}", told(ends[0]), told(ends[1]))
            } else {
                "no interval".to_owned()
            };
            (decoder.name(), own, ends)
        };
        let parts: Vec<_> = self.won.iter().map(on_silicon).collect();
        let each: Vec<_> = { parts.iter() }
            .map(|(decoder, own, ends)| {
                format!("{} ({ends}) with the decoder {decoder}", told(*own))
            })
            .collect();
        let on_silicon = each.join(", ");
        let Some(float) = &self.float else {
            let why = if self.took_part[1] {
                format!("`{FLOAT}` as it was trained has no bits in common with `{BASE}`")
            } else {
                format!("`{FLOAT}` did not take part")
            };
            return format!(
                "{}: {why}, so there is no win of a float kernel to keep; on silicon, in {label} against `{BASE}`, {on_silicon}",
                self.arm
            );
        };
        let all = float.mean * sign;
        if !float.shown(metric) || all <= 0.0 {
            return format!(
                "{}: the win of the float kernel `{FLOAT}` over `{BASE}` is not shown ({} {label}), so there is none to keep; on silicon {on_silicon}",
                self.arm,
                told(all),
            );
        }
        let kept: Vec<_> = { parts.iter() }
            .map(|(decoder, own, ends)| {
                let share = 100.0 * own / all;
                let half = if *own >= all / 2.0 {
                    "at least half".to_owned()
                } else {
                    format!("{:.digits$} {label} less than half", all / 2.0 - own)
                };
                let (share, own) = (fixed(share, 0), told(*own));
                format!("{share} % ({own}, {ends}) with the decoder {decoder}: {half}")
            })
            .collect();
        format!(
            "{}: of the {} {label} that the float kernel `{FLOAT}` wins over `{BASE}` silicon keeps {}",
            self.arm,
            told(all),
            kept.join("; ")
        )
    }
}
