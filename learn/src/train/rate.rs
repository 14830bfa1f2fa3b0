//! The thresholds that an arm is judged with.

use amacrine::{
    elementary,
    gradient::{Clips as Light, GradientError, Model, Rated, rate_threshold},
    plane::Size,
    reference::Description,
    unit::signed,
};

use crate::{
    record::{Decoder, Form, Row},
    scene::Clips,
};

use super::{
    batch::Batch,
    error::TrainError,
    trainee::{Reason, Trainee},
};

/// How far from its target a rate may be without a word, as a part of it.
const FAR: f64 = 0.1;

/// The first step away from a threshold, of its logarithm, in the search for where its rate ends; and
/// the last: beyond it rates are those of a still scene.
const STEPS: [f64; 2] = [1e-5, 1.0];

/// Where thresholds are looked for around the one that meets the target, by their logarithms: those
/// that are nearest are between steps that single precision alone has.
const AROUND: [f64; 5] = [0.0, -1e-4, 1e-4, -1e-3, 1e-3];

/// Halvings between a threshold of the same rate and one of another.
const HALVINGS: u32 = 10;

impl Trainee<'_> {
    /// The sensor as it is judged: thresholds meet the target on the held-out clips themselves, so
    /// that all arms are judged at the same bits. Where events have a price, thresholds are those that
    /// were learned. With the chip in the loop they are one LSB at least, whatever the target: the
    /// chip has none below.
    ///
    /// # Errors
    /// When no thresholds meet the target.
    pub fn rated(&self, clips: &Clips) -> Result<Option<Rated>, TrainError> {
        let Some(applied) = self.applied()? else {
            return Ok(None);
        };
        let batch = Batch::new(clips, 0..self.task.test.0);
        let light = batch.light(self.task.sensor.light_noise, self.draw(Reason::Test, 1));
        let lit = self.light(&light, &batch)?;
        let wrong = |cause| self.gradient_error(cause);
        let least = self.state.chip[1];
        let description = self.sensor(&applied.kernels, self.state.threshold.max(least));
        if self.task.sparsity.is_some() {
            let rated = self.as_it_is(&description, lit);
            return rated.map(Some).map_err(wrong);
        }
        let at_least = || self.as_it_is(&self.sensor(&applied.kernels, least), lit);
        let rated = match rate_threshold(&description, lit, self.mismatch(), self.target) {
            // A memory that snaps makes one event a pair at most, and the most at the least threshold.
            Err(GradientError::Rate { .. }) if least > 0.0 => at_least(),
            Ok(rated) if rated.description.channels[0].thresholds[0].on < least => at_least(),
            // Without noise and mismatch many cells fire at one threshold, which then is no safe one:
            // arithmetic of other precision decides otherwise.
            Ok(rated)
                if self.task.sensor.mismatch == 0.0 && self.task.sensor.light_noise == 0.0 =>
            {
                self.between_jumps(rated, (&light, batch.size()), least)
            }
            other => other,
        };
        rated.map(Some).map_err(wrong)
    }

    /// A sensor as it is, and its rate.
    pub(super) fn as_it_is(
        &self,
        description: &Description,
        lit: Light<'_, f32>,
    ) -> Result<Rated, GradientError> {
        let model = Model::<f32>::new(description.clone(), lit.size(), self.mismatch())?;
        let rate = model.forward(lit)?.rate();
        Ok(Rated {
            description: description.clone(),
            scale: 1.0,
            rate,
        })
    }

    /// A threshold as near to the target that is the middle of those with its rate, and has this rate
    /// in double precision too; the one that is given where none is.
    fn between_jumps(
        &self,
        rated: Rated,
        (light, size): (&[f32], Size),
        least: f64,
    ) -> Result<Rated, GradientError> {
        let lit = Light::new(light, self.times(), size)?;
        let double: Vec<f64> = light.iter().copied().map(f64::from).collect();
        let double = Light::new(&double, self.times(), size)?;
        let miss = |rated: &Rated| (rated.rate / self.target - 1.0).abs();
        let mut best: Option<Rated> = None;
        for log in AROUND {
            let own = self.middle(&scaled(&rated.description, log), lit)?;
            if own.description.channels[0].thresholds[0].on < least {
                continue;
            }
            let model = Model::<f64>::new(own.description.clone(), size, self.mismatch())?;
            let is_nearer = best.as_ref().is_none_or(|best| miss(&own) < miss(best));
            if is_nearer && model.forward(double)?.rate() == own.rate {
                best = Some(own);
            }
        }
        Ok(best.unwrap_or(rated))
    }

    /// The middle of the thresholds that have the rate of a sensor.
    fn middle(&self, sensor: &Description, lit: Light<'_, f32>) -> Result<Rated, GradientError> {
        let own = self.as_it_is(sensor, lit)?;
        let is_same = |log: f64| {
            self.as_it_is(&scaled(sensor, log), lit)
                .map(|at| at.rate == own.rate)
        };
        let mut ends = [0.0; 2];
        for (end, way) in ends.iter_mut().zip([-1.0, 1.0]) {
            let [mut step, last] = STEPS;
            while step < last && is_same(way * step)? {
                *end = way * step;
                step *= 4.0;
            }
            let mut beyond = way * step;
            for _ in 0..HALVINGS {
                let middle = f64::midpoint(*end, beyond);
                if is_same(middle)? {
                    *end = middle;
                } else {
                    beyond = middle;
                }
            }
        }
        let middle = scaled(sensor, f64::midpoint(ends[0], ends[1]));
        let middle = self.as_it_is(&middle, lit)?;
        Ok(if middle.rate == own.rate { middle } else { own })
    }

    /// Which mismatch the arm is judged with.
    pub(super) fn mismatch(&self) -> u64 {
        self.draw(Reason::Mismatch, u64::MAX).bits()
    }

    /// The forms whose rates are far from the target, in a sentence; `None` where none is, and where
    /// events have a price.
    pub(super) fn far(&self, rows: &[Row]) -> Option<String> {
        if self.task.sparsity.is_some() || self.arm.cells().is_none() {
            return None;
        }
        let told = |form: Form| {
            let own = |row: &&Row| row.form == form && row.decoder == Decoder::Own;
            let (events, cells) = { rows.iter().filter(own) }
                .fold((0, 0), |(e, c), row| (e + row.events, c + row.cells));
            let rate = events as f64 / cells as f64;
            let off = rate / self.target - 1.0;
            (off.abs() > FAR).then(|| {
                let (name, percent) = (form.name(), 100.0 * off);
                format!("{rate:.4} ({name}, {} %)", signed(percent, 0))
            })
        };
        let forms = [Form::Trained, Form::Quantised, Form::Exact, Form::Silicon];
        let far: Vec<String> = forms.into_iter().filter_map(told).collect();
        if far.is_empty() {
            return None;
        }
        let why = if self.snaps() || far.iter().any(|told| !told.contains(Form::Trained.name())) {
            ": thresholds on the chip are whole LSB, one at the least"
        } else {
            ": many cells fire at the same threshold"
        };
        Some(format!(
            "asked for {} events a pixel and pair, it makes {}{why}",
            self.target,
            far.join(", ")
        ))
    }
}

/// A sensor with thresholds whose logarithms are larger by so much.
fn scaled(sensor: &Description, log: f64) -> Description {
    let mut sensor = sensor.clone();
    for channel in &mut sensor.channels {
        for threshold in &mut channel.thresholds {
            threshold.on *= elementary::exp(log);
            threshold.off *= elementary::exp(log);
        }
    }
    sensor
}
