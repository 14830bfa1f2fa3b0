//! The waterfall as a picture: over frame rate, and step by step.

use super::{Cause, Rate, Rates, Sample, Share, Waterfall};
use crate::{
    compare::metric::Short,
    picture::{
        Drawing, RatesCause, RatesShow, WaterfallShow, WaterfallStep, ink, rates, waterfall,
    },
    unit::{Micros, counted, frame_rate},
};

impl Waterfall {
    /// A page with a row for each step; [`picture::svg`](crate::picture::svg) and
    /// [`picture::raster`](crate::picture::raster) make a file of it.
    #[must_use]
    pub fn drawing(&self, title: &str) -> Drawing {
        let steps: Vec<_> = self
            .steps
            .iter()
            .map(|step| WaterfallStep {
                name: step.name,
                forward: step.forward,
                backward: step.backward,
            })
            .collect();
        waterfall(&WaterfallShow {
            title,
            captions: &self.captions(),
            whole: self.float_events,
            steps: &steps,
            ends: self.ends,
        })
    }

    /// What was run, in two lines.
    #[must_use]
    pub fn captions(&self) -> [String; 2] {
        let Self {
            float_events,
            chip_events,
            windows,
            program,
            ..
        } = self;
        [
            format!(
                "{float_events} events of the float sensor are 100 %, {chip_events} leave the chip; kept within {}, mistimed within {}",
                windows.narrow, windows.wide
            ),
            format!(
                "{} on cells of {}: {} a frame, the light halved {}, a threshold of {:.3} LSB",
                self.to,
                self.arithmetic,
                counted(program.words, "word"),
                counted(program.prescale_bits, "time"),
                program.threshold_lsb
            ),
        ]
    }
}

impl Rates {
    /// A page with a bar for each rate.
    #[must_use]
    pub fn drawing(&self, title: &str) -> Drawing {
        let fps: Vec<f64> = self.rates.iter().map(|rate| rate.headline.fps).collect();
        let kept = RatesCause {
            name: "kept",
            ink: ink::MATCHED,
            shares: { self.rates.iter() }
                .map(|rate| rate.headline.kept.zip(rate.kept_10_90))
                .collect(),
        };
        let of = |(i, cause): (usize, &Share)| {
            let shares = self.rates.iter().filter_map(|rate| rate.causes.get(i));
            let place = Cause::SILICON.iter().position(|one| *one == cause.cause);
            RatesCause {
                name: cause.name,
                ink: place.map_or(ink::BARS, |place| ink::CAUSES[place]),
                shares: shares
                    .map(|share| share.share.zip(share.share_10_90))
                    .collect(),
            }
        };
        let first = self.rates.first().map(|rate| rate.causes.as_slice());
        let causes: Vec<_> = first
            .unwrap_or_default()
            .iter()
            .enumerate()
            .map(of)
            .collect();
        rates(&RatesShow {
            title,
            captions: &self.captions(),
            rates: &fps,
            kept,
            causes: &causes,
            notes: &{ self.unjudged().map(|why| format!("-: {why}")).into_iter() }
                .chain(self.advice())
                .collect::<Vec<_>>(),
        })
    }

    /// What was looked at, in two lines.
    #[must_use]
    pub fn captions(&self) -> [String; 2] {
        let Sample {
            from_seconds,
            seconds,
            tiles,
            width,
            height,
            ..
        } = &self.sample;
        let window = self
            .rates
            .first()
            .map_or(Micros(0), |rate| rate.headline.window_us);
        let some = |count: usize, what: &str| match count {
            1 => format!("1 {what}"),
            count => format!("{count} {what}s"),
        };
        let place = if self.sample.part() < 1.0 {
            format!(
                "{} of {width}x{height}, {:.1} % of the sensor",
                some(tiles.len(), "tile"),
                100.0 * self.sample.part()
            )
        } else {
            "the whole sensor".to_owned()
        };
        [
            format!(
                "kept of the float sensor's events, at the times of its crossings, within {} and above chance; with all its readout slots the chip allows {:.0} frames/s (nominal)",
                Short(window),
                self.ceiling_fps
            ),
            format!(
                "{} on {place}, from {:.2} to {:.2} s of the scene; the same light at each rate{}",
                some(self.chips as usize, "chip"),
                from_seconds,
                from_seconds + seconds,
                self.brackets()
            ),
        ]
    }

    /// What lies between the ends of the ranges.
    fn brackets(&self) -> &'static str {
        match (self.chips, self.sample.part() < 1.0) {
            (0 | 1, false) => "",
            (0 | 1, true) => ", in brackets 80 % of choices of tiles",
            (_, false) => ", in brackets 80 % of further chips",
            (_, true) => ", in brackets 80 % of further chips on other tiles",
        }
    }

    /// What stands in place of what is kept, where chance scores 1 at some rate.
    #[must_use]
    pub fn unjudged(&self) -> Option<&'static str> {
        let is_unknown = |rate: &Rate| rate.headline.kept.is_none();
        self.rates
            .iter()
            .any(is_unknown)
            .then_some("chance alone scores 1 there, so nothing can be said of what is kept.")
    }

    /// What a designer can do about noise; nothing where there is none.
    #[must_use]
    pub fn advice(&self) -> Vec<String> {
        let Some(noise) = &self.noise else {
            return Vec::new();
        };
        let mut lines = Vec::new();
        if let Some(sigmas) = noise.sigmas {
            lines.push(format!(
                "threshold {:.2} LSB: {sigmas:.1} sigmas of the noise of a difference of two results ({:.2} LSB each, predicted)",
                noise.threshold_lsb, noise.temporal_lsb
            ));
        }
        let told = |rate: &Rate| {
            let noise = rate.noise?;
            Some(format!(
                "{} at {}",
                few(noise.events_per_second),
                frame_rate(rate.headline.fps)
            ))
        };
        let rates: Vec<String> = self.rates.iter().filter_map(told).collect();
        lines.push(format!(
            "noise alone, events/s of a still picture: {} frames/s; the float sensor: {} of the scene",
            rates.join(", "),
            few(self.reference_events_per_second)
        ));
        let limit = 100.0 * noise.limit;
        let fastest = self.rates.last().map_or(0.0, |rate| rate.headline.fps);
        let fastest = frame_rate(fastest);
        lines.push(match (noise.fps_below, noise.threshold_for_fastest) {
            (None, _) => format!("that is below {limit:.0} % of the float sensor's up to {fastest} frames/s"),
            (Some(fps), None) => {
                format!("decide at most {fps:.1} times a second to keep that below {limit:.0} %")
            }
            (Some(fps), Some(threshold)) => format!(
                "to keep that below {limit:.0} % decide at most {fps:.1} times a second, or raise the threshold to about {threshold:.1} for {fastest} frames/s"
            ),
        });
        lines
    }
}

/// Events a second with three digits.
fn few(events: f64) -> String {
    match events {
        e if e >= 99_950.0 => format!("{:.0}k", e / 1000.0),
        e if e >= 9995.0 => format!("{:.1}k", e / 1000.0),
        e if e >= 99.5 || e == 0.0 => format!("{e:.0}"),
        e => format!("{e:.1}"),
    }
}
