//! `exec --repeat`: the same program on chip after chip, in numbers.

use std::ops::ControlFlow;

use miette::miette;
use serde_json::{Value, json};

use super::{bench::Bench, moment::Part};
use crate::{
    event::{Dropped, Polarity},
    limit::RUNS,
    plane::Plane,
    rig::guard::{Guard, Warning},
    unit::counted,
};

/// What many runs gave.
///
/// Every run has a seed of its own, so it is another chip with other noise: deviation from run
/// to run holds both.
pub struct Statistics {
    program: String,
    domain: String,
    first_seed: u64,
    runs: u64,
    registers: Vec<Sums>,
    /// Each run's events.
    events: Vec<Events>,
    /// What there is to warn of, each of the first run in which it comes.
    pub warnings: Vec<Warning>,
}

/// Events of one run.
#[derive(Clone, Copy)]
struct Events {
    on: u64,
    off: u64,
    dropped: Dropped,
}

/// Sums over the runs of one register.
struct Sums {
    name: String,
    sum: Plane<f64>,
    squares: Plane<f64>,
    /// Sum of the variances over the pixels, run by run.
    variances: f64,
}

impl Statistics {
    /// Runs the program with seed after seed.
    pub fn from_runs(bench: &Bench<'_>, first_seed: u64, runs: u64) -> miette::Result<Self> {
        if runs > RUNS {
            return Err(miette!(
                help = "some thousand runs tell mean and spread",
                "--repeat {runs}: {RUNS} runs at most"
            ));
        }
        let opened = &bench.opened;
        let written = bench.written();
        let mut registers: Vec<Sums> = Vec::new();
        let mut events = Vec::new();
        let mut domain = String::new();
        let mut warnings = Guard::new();
        for run in 0..runs {
            let mut chip = bench.chip(first_seed.wrapping_add(run))?;
            let (mut guard, mut saturation) = (Guard::new(), bench.saturation());
            let (packet, frames) = bench.watch(&mut *chip, |chip, moment, packet| {
                guard.frame_at(moment.t);
                if moment.part != Part::Ran {
                    saturation.before(chip, moment.steps);
                }
                moment.run(chip, packet)?;
                saturation.frame(chip);
                Ok(ControlFlow::Continue(()))
            })?;
            warnings.extend(bench.warnings(guard, &*chip, &packet, frames, saturation));
            for (at, register) in written.iter().enumerate() {
                let values = register.values(&*chip);
                if registers.len() == at {
                    registers.push(Sums {
                        name: register.name(&opened.device),
                        sum: Plane::zeros(values.dim()),
                        squares: Plane::zeros(values.dim()),
                        variances: 0.0,
                    });
                }
                registers[at].add(&values);
            }
            let on = packet.events.iter().filter(|e| e.polarity == Polarity::On);
            let on = on.count() as u64;
            events.push(Events {
                on,
                off: packet.events.len() as u64 - on,
                dropped: packet.dropped,
            });
            domain = chip.domain();
        }
        Ok(Self {
            program: opened.program.file.clone(),
            domain,
            first_seed,
            runs,
            registers,
            events,
            warnings: warnings.warnings(),
        })
    }

    /// Mean and standard deviation of a number of each run; no deviation of a single run.
    fn over_runs(&self, number: impl Fn(&Events) -> u64 + Clone) -> (f64, Option<f64>) {
        spread(self.events.iter().map(number))
    }

    /// What was lost, by reason.
    fn dropped(&self) -> serde_json::Map<String, Value> {
        let each: Vec<Value> = self.events.iter().map(|it| json!(it.dropped)).collect();
        let reasons = each.first().and_then(Value::as_object);
        let reasons = reasons.into_iter().flat_map(serde_json::Map::keys);
        let told = reasons.map(|reason| {
            let number = |run: &Value| run[reason].as_u64().unwrap_or_default();
            let (mean, sd) = spread(each.iter().map(number));
            (reason.clone(), json!({"mean": mean, "sd": sd}))
        });
        told.collect()
    }

    pub fn json(&self) -> Value {
        let registers: serde_json::Map<_, _> = self
            .registers
            .iter()
            .map(|sums| {
                let value = json!({
                    "mean": sums.mean(self.runs),
                    "spatial_sd": sums.spatial(self.runs),
                    "temporal_sd": sums.temporal(self.runs),
                });
                (sums.name.clone(), value)
            })
            .collect();
        let events = |(mean, sd): (f64, Option<f64>)| json!({"mean": mean, "sd": sd});
        json!({
            "program": self.program,
            "domain": self.domain,
            "runs": self.runs,
            "first_seed": self.first_seed,
            "registers": registers,
            "events": events(self.over_runs(|it| it.on + it.off)),
            "on": events(self.over_runs(|it| it.on)),
            "off": events(self.over_runs(|it| it.off)),
            "dropped": self.dropped(),
            "warnings": self.warnings,
        })
    }

    /// A line for each reason for which events were lost.
    fn lost(&self) -> Vec<String> {
        let reasons = Dropped::default().reasons().into_iter().enumerate();
        let lines = reasons.filter_map(|(at, (reason, _))| {
            let (mean, sd) = self.over_runs(|it| it.dropped.reasons()[at].1);
            let sd = shown(sd);
            (mean > 0.0).then(|| format!("dropped  {mean:.1} a run, sd {sd}: {reason}"))
        });
        lines.collect()
    }

    pub fn table(&self) -> String {
        let last = self.first_seed.wrapping_add(self.runs - 1);
        let mut lines = vec![
            format!(
                "program  {}, {}, {}, seeds {} to {last}",
                self.program,
                self.domain,
                counted(self.runs, "run"),
                self.first_seed
            ),
            format!(
                "{:<8} {:>12} {:>12} {:>12}",
                "register", "mean", "spatial sd", "temporal sd"
            ),
        ];
        for sums in &self.registers {
            lines.push(format!(
                "{:<8} {:>12.4} {:>12.4} {:>12}",
                sums.name,
                sums.mean(self.runs),
                sums.spatial(self.runs),
                shown(sums.temporal(self.runs))
            ));
        }
        let (mean, sd) = self.over_runs(|it| it.on + it.off);
        let of = |number: fn(&Events) -> u64| self.over_runs(number).0;
        lines.push(format!(
            "events   {mean:.1} a run, sd {} ({:.1} ON, {:.1} OFF)",
            shown(sd),
            of(|e| e.on),
            of(|e| e.off)
        ));
        lines.extend(self.lost());
        lines.push(
            "spatial: over the pixels of a run; temporal: of a pixel from run to run, each a chip of its own"
                .to_owned(),
        );
        lines.join("\n") + "\n"
    }
}

/// Mean and standard deviation; none of a single number.
fn spread(numbers: impl ExactSizeIterator<Item = u64> + Clone) -> (f64, Option<f64>) {
    let count = numbers.len() as f64;
    let numbers = numbers.map(|n| n as f64);
    let mean = numbers.clone().sum::<f64>() / count;
    let square = numbers.map(|n| (n - mean).powi(2)).sum::<f64>();
    (mean, (count > 1.0).then(|| (square / (count - 1.0)).sqrt()))
}

fn shown(sd: Option<f64>) -> String {
    sd.map_or_else(|| "-".to_owned(), |sd| format!("{sd:.4}"))
}

impl Sums {
    fn add(&mut self, values: &Plane<f64>) {
        self.sum += values;
        self.squares += &values.mapv(|v| v * v);
        self.variances += values.var(0.0);
    }

    /// Over pixels and runs.
    fn mean(&self, runs: u64) -> f64 {
        self.sum.sum() / (self.sum.len() as f64 * runs as f64)
    }

    /// Standard deviation over the pixels of one run, the runs' root mean square.
    fn spatial(&self, runs: u64) -> f64 {
        (self.variances / runs as f64).sqrt()
    }

    /// Standard deviation of a pixel over the runs, the pixels' root mean square.
    fn temporal(&self, runs: u64) -> Option<f64> {
        if runs < 2 {
            return None;
        }
        let n = runs as f64;
        let pixels = self.sum.iter().zip(&self.squares);
        // Rounding can leave a little less than nothing.
        let variance: f64 = pixels
            .map(|(sum, squares)| ((squares - sum * sum / n) / (n - 1.0)).max(0.0))
            .sum();
        Some((variance / self.sum.len() as f64).sqrt())
    }
}
