//! What a description that is made or changed in code must hold to; a file is held to the same when
//! it is read.

use super::{Channel, Description, MemoryRule, PolarityRule, RefractoryRule, keys::MOST_CHANNELS};
use crate::{config::Kind, reference::noise::Noise, sensor::SensorError};

impl Description {
    /// Whether there can be such a sensor.
    ///
    /// # Errors
    /// What cannot be.
    pub fn check(&self) -> Result<(), SensorError> {
        let wrong = |what: &str, help: &'static str| {
            Err(SensorError::Impossible {
                sensor: self.name.clone(),
                what: what.to_owned(),
                help,
            })
        };
        if !(1..=MOST_CHANNELS).contains(&self.channels.len()) {
            let what = format!("{} kinds of cells", self.channels.len());
            return wrong(
                &what,
                "give at least one, and no more than docs/limits.md allows",
            );
        }
        if self.shared && self.memory != MemoryRule::RawSnap {
            return wrong(
                "a shared memory that is not raw-snap",
                "use MemoryRule::RawSnap",
            );
        }
        if self.polarity == PolarityRule::Pixel && self.memory.steps() {
            return wrong(
                "the sign of the pixel with a memory that steps",
                "use PolarityRule::Filtered, or a memory that snaps",
            );
        }
        let authors = self.refractory.rule == RefractoryRule::Authors;
        if self.refractory.us > 0.0 && !self.memory.steps() && authors {
            return wrong(
                "the authors' refractory rule with a memory that snaps",
                "use RefractoryRule::DeadTime",
            );
        }
        let is_time = |us: f64| us.is_finite() && us >= 0.0;
        if !is_time(self.refractory.us) {
            let what = format!("a refractory period of {} us", self.refractory.us);
            return wrong(&what, "give microseconds, 0 or more");
        }
        if let Some((name, value)) = odd_noise(&self.noise) {
            let what = format!("noise {name} of {value}");
            return wrong(
                &what,
                "give a number in the range that docs/reference.md gives",
            );
        }
        for (number, channel) in self.channels.iter().enumerate() {
            if let Some((what, help)) = odd_channel(channel, self.memory) {
                return wrong(&format!("channel {number} has {what}"), help);
            }
        }
        Ok(())
    }
}

/// The first number of the noise that is out of its range.
fn odd_noise(noise: &Noise) -> Option<(&'static str, f64)> {
    let Noise {
        leak_hz,
        leak_spread,
        shot_hz,
        shot_at_white,
        hot_fraction,
        hot_hz,
        jitter_us,
        cutoff_hz,
        cutoff_rule: _,
    } = *noise;
    let all = [
        ("leak_hz", leak_hz),
        ("leak_spread", leak_spread),
        ("shot_hz", shot_hz),
        ("shot_at_white", shot_at_white),
        ("hot_fraction", hot_fraction),
        ("hot_hz", hot_hz),
        ("jitter_us", jitter_us),
        ("cutoff_hz", cutoff_hz),
    ];
    let is_odd = |(field, value): &(&str, f64)| {
        let key = Noise::TABLE.key(&field.replace('_', "-"));
        !matches!(key.map(|key| key.kind), Some(Kind::Number(range)) if range.holds(*value))
    };
    all.into_iter().find(is_odd)
}

/// What a kind of cell cannot have.
fn odd_channel(channel: &Channel, memory: MemoryRule) -> Option<(String, &'static str)> {
    let (kernels, thresholds) = (channel.kernels.len(), channel.thresholds.len());
    if !matches!((kernels, thresholds), (1, 1) | (4, 4)) {
        let what = format!("{kernels} kernels and {thresholds} thresholds");
        return Some((what, "give one of each, or four of each for a 2x2 pattern"));
    }
    for threshold in &channel.thresholds {
        let is_threshold = |value: f64| value.is_finite() && value > 0.0;
        let is_sigma = threshold.sigma.is_finite() && threshold.sigma >= 0.0;
        if !(is_threshold(threshold.on) && is_threshold(threshold.off) && is_sigma) {
            let what = format!(
                "thresholds ON {}, OFF {}, sigma {}",
                threshold.on, threshold.off, threshold.sigma
            );
            return Some((what, "give thresholds above 0, and a sigma of 0 or more"));
        }
    }
    let authors = memory == MemoryRule::AuthorsPixelStep;
    (authors && channel.memory_kernel.is_none()).then(|| {
        let what = "no kernel of its memory".to_owned();
        (what, "give memory_kernel, which the authors' rule needs")
    })
}
