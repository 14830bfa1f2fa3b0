//! `exec --repeat`: the same program on chip after chip, in numbers.

use std::ops::ControlFlow;

use miette::miette;
use serde_json::json;

use super::bench::Bench;
use crate::{event::Polarity, limit::RUNS, plane::Plane};

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
    /// ON and OFF events of each run.
    events: Vec<(u64, u64)>,
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
        for run in 0..runs {
            let mut chip = bench.chip(first_seed.wrapping_add(run))?;
            let (packet, _) = bench.watch(&mut *chip, |chip, moment, packet| {
                moment.run(chip, packet)?;
                Ok(ControlFlow::Continue(()))
            })?;
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
            events.push((on, packet.events.len() as u64 - on));
            domain = chip.domain();
        }
        Ok(Self {
            program: opened.program.file.clone(),
            domain,
            first_seed,
            runs,
            registers,
            events,
        })
    }

    /// Mean and standard deviation of a number of each run; no deviation of a single run.
    fn over_runs(&self, number: impl Fn(&(u64, u64)) -> u64) -> (f64, Option<f64>) {
        let numbers = || self.events.iter().map(|e| number(e) as f64);
        let runs = self.runs as f64;
        let mean = numbers().sum::<f64>() / runs;
        let square = numbers().map(|n| (n - mean).powi(2)).sum::<f64>();
        (
            mean,
            (self.runs > 1).then(|| (square / (runs - 1.0)).sqrt()),
        )
    }

    pub fn json(&self) -> serde_json::Value {
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
            "events": events(self.over_runs(|(on, off)| on + off)),
            "on": events(self.over_runs(|(on, _)| *on)),
            "off": events(self.over_runs(|(_, off)| *off)),
        })
    }

    pub fn table(&self) -> String {
        let last = self.first_seed.wrapping_add(self.runs - 1);
        let shown = |sd: Option<f64>| sd.map_or_else(|| "-".to_owned(), |sd| format!("{sd:.4}"));
        let mut lines = vec![
            format!(
                "program  {}, {}, {}, seeds {} to {last}",
                self.program,
                self.domain,
                crate::unit::counted(self.runs, "run"),
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
        let (mean, sd) = self.over_runs(|(on, off)| on + off);
        let of = |number: fn(&(u64, u64)) -> u64| self.over_runs(number).0;
        lines.push(format!(
            "events   {mean:.1} a run, sd {} ({:.1} ON, {:.1} OFF)",
            shown(sd),
            of(|e| e.0),
            of(|e| e.1)
        ));
        lines.push(
            "spatial: over the pixels of a run; temporal: of a pixel from run to run, each a chip of its own"
                .to_owned(),
        );
        lines.join("\n") + "\n"
    }
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
