//! What a sensor cannot be: one place of rules for files and for descriptions that are made or
//! changed in code. What a file cannot say, code cannot either.

use super::{
    Channel, Description, MemoryRule, PolarityRule, Refractory, RefractoryRule,
    growth::{MOST_GROWTH, growth},
    keys::{MOST_CHANNELS, REFRACTORY, THRESHOLD},
};
use crate::{
    config::{Fault, Kind, Place, Table},
    kernel::Kernel,
    reference::noise::Noise,
    sensor::SensorError,
    unit::counted,
};

/// Something that a sensor cannot be, and what to do.
#[derive(Debug)]
pub(super) struct Odd {
    what: String,
    help: &'static str,
}

impl Odd {
    fn new(what: impl Into<String>, help: &'static str) -> Self {
        let what = what.into();
        Self { what, help }
    }

    /// Where a file says it.
    pub(super) fn at(self, place: Place) -> Fault {
        Fault::error(place, self.what, "here").help(self.help)
    }
}

/// Refuses where a rule is broken.
fn unless(fits: bool, what: &str, help: &'static str) -> Result<(), Odd> {
    if fits {
        return Ok(());
    }
    Err(Odd::new(what, help))
}

impl Description {
    /// Whether there can be such a sensor. What is so, [`to_toml`](Self::to_toml) writes as a file
    /// that can be read.
    ///
    /// # Errors
    /// What cannot be.
    pub fn check(&self) -> Result<(), SensorError> {
        self.rules()
            .map_err(|Odd { what, help }| SensorError::Impossible {
                sensor: self.name.clone(),
                what,
                help,
            })
    }

    fn rules(&self) -> Result<(), Odd> {
        channels(self.channels.len())?;
        if let Some(what) = self.response.odd() {
            let help = "give a number in the range that docs/reference.md gives";
            return Err(Odd::new(format!("a response with {what}"), help));
        }
        shared(self.memory, self.shared)?;
        polarity(self.memory, self.polarity)?;
        let Refractory { us, rule } = self.refractory;
        if !holds(&REFRACTORY, "us", us) {
            let what = format!("a refractory period of {us} us");
            return Err(Odd::new(what, "give microseconds, 0 or more"));
        }
        refractory(self.memory, rule)?;
        if let Some((key, value)) = odd_noise(&self.noise) {
            // The field that has the key's number.
            let what = format!("noise {} of {value}", key.replace('-', "_"));
            let help = "give a number in the range that docs/reference.md gives";
            return Err(Odd::new(what, help));
        }
        leak(self.memory, rule, &self.noise)?;
        for (number, channel) in self.channels.iter().enumerate() {
            channel
                .rules(self.memory)
                .map_err(|Odd { what, help }| Odd {
                    what: format!("channel {number}: {what}"),
                    help,
                })?;
        }
        Ok(())
    }
}

impl Channel {
    fn rules(&self, memory: MemoryRule) -> Result<(), Odd> {
        let (kernels, thresholds) = (self.kernels.len(), self.thresholds.len());
        if !matches!((kernels, thresholds), (1, 1) | (4, 4)) {
            let what = format!(
                "{} and {}",
                counted(kernels, "kernel"),
                counted(thresholds, "threshold")
            );
            let help = "give one of each, or four of each for a 2x2 pattern";
            return Err(Odd::new(what, help));
        }
        for threshold in &self.thresholds {
            let numbers = [
                ("on", threshold.on),
                ("off", threshold.off),
                ("sigma", threshold.sigma),
            ];
            if numbers
                .iter()
                .any(|(key, value)| !holds(&THRESHOLD, key, *value))
            {
                let what = format!(
                    "thresholds ON {}, OFF {}, sigma {}",
                    threshold.on, threshold.off, threshold.sigma
                );
                let help = "give thresholds above 0, and a sigma of 0 or more";
                return Err(Odd::new(what, help));
            }
        }
        if let Some(surrounds) = &self.surrounds {
            mesh(memory, kernels > 1, self.log_temporal)?;
            let is_pixel = |kernel: &Kernel| kernel.weights().iter().eq([&1.0]);
            let is_pixel = self.kernels.iter().all(is_pixel);
            let help = "give a kernel of one weight of 1: the mesh stands in place of the kernel";
            unless(is_pixel, "a kernel beside a mesh", help)?;
            if let Some((what, help)) = surrounds.odd() {
                return Err(Odd::new(what, help));
            }
        }
        log_temporal(memory, self.log_temporal)?;
        memory_kernel(memory, self.memory_kernel.as_ref())
    }
}

/// Whether a number is one that a file may give for a key.
fn holds(table: &Table, key: &str, value: f64) -> bool {
    let key = table.key(key);
    matches!(key.map(|key| key.kind), Some(Kind::Number(range)) if range.holds(value))
}

/// How many kinds of cells there may be.
pub(super) fn channels(number: usize) -> Result<(), Odd> {
    if (1..=MOST_CHANNELS).contains(&number) {
        return Ok(());
    }
    let what = format!("{number} kinds of cells, and a sensor has 1 to {MOST_CHANNELS}");
    let help = "give fewer: those of a file of several kernels are counted one by one";
    Err(Odd::new(what, if number == 0 { "give one" } else { help }))
}

/// Which refractory rule a memory can have.
pub(super) fn refractory(memory: MemoryRule, rule: RefractoryRule) -> Result<(), Odd> {
    if memory.refractory_rules().contains(&rule) {
        return Ok(());
    }
    let (what, help) = match rule {
        RefractoryRule::Authors => (
            "refractory rule = \"authors\" counts the steps of a memory, but this memory snaps",
            "use rule = \"dead-time\", or memory = \"filtered-step\"",
        ),
        RefractoryRule::DeadTime => (
            "memory = \"authors-pixel-step\" exists to agree with the released code, whose refractory rule is its own",
            "use rule = \"authors\"",
        ),
    };
    Err(Odd::new(what, help))
}

/// Whether one memory serves all kinds: only a memory of pixels is the same for all of them.
pub(super) fn shared(memory: MemoryRule, shared: bool) -> Result<(), Odd> {
    unless(
        !shared || memory.may_be_shared(),
        "shared = true is for memory = \"raw-snap\": a picture of the pixels is the same for all kinds, a filtered signal is each kind's own",
        "use memory = \"raw-snap\", or leave shared out",
    )
}

/// Where a sign can come from.
pub(super) fn polarity(memory: MemoryRule, rule: PolarityRule) -> Result<(), Odd> {
    unless(
        !memory.steps() || rule != PolarityRule::Pixel,
        "polarity = \"pixel\" needs the pixel's value at the last event, which a memory that steps does not keep",
        "use polarity = \"filtered\", or memory = \"raw-snap\" or \"filtered-snap\"",
    )
}

/// Which memories can leak.
pub(super) fn leak(memory: MemoryRule, rule: RefractoryRule, noise: &Noise) -> Result<(), Odd> {
    if noise.leak_hz <= 0.0 {
        return Ok(());
    }
    unless(
        !memory.holds_pixels(),
        "noise.leak-hz is in thresholds of the filtered signal, but this memory holds pixels",
        "use memory = \"filtered-snap\" or \"filtered-step\", or leave the leak out",
    )?;
    unless(
        rule != RefractoryRule::Authors,
        "noise.leak-hz moves the memory between frames, which the authors' refractory rule does not know",
        "use rule = \"dead-time\", or leave the leak out",
    )
}

/// What a channel that sees through a mesh can have.
pub(super) fn mesh(memory: MemoryRule, four: bool, log_temporal: bool) -> Result<(), Odd> {
    unless(
        !memory.holds_pixels() && !four && !log_temporal,
        "a mesh stands in place of a kernel, before a memory of the filtered signal",
        "use memory = \"filtered-step\" or \"filtered-snap\", and no pattern or log-temporal in this channel",
    )
}

/// Which memories can hold the logarithm of the drive.
pub(super) fn log_temporal(memory: MemoryRule, log_temporal: bool) -> Result<(), Odd> {
    unless(
        !log_temporal || !memory.holds_pixels(),
        "log-temporal is the logarithm of the filtered signal, and this memory holds pixels",
        "use memory = \"filtered-step\" or \"filtered-snap\", or leave log-temporal out",
    )
}

/// Which memories are seen through a kernel of their own, and through which they are stable.
pub(super) fn memory_kernel(memory: MemoryRule, kernel: Option<&Kernel>) -> Result<(), Odd> {
    let authors = memory.has_kernel();
    unless(
        !authors || kernel.is_some(),
        "memory = \"authors-pixel-step\" needs a memory-kernel",
        "give the kernel that the memory is seen through (often the channel's own)",
    )?;
    unless(
        authors || kernel.is_none(),
        "memory-kernel is only for memory = \"authors-pixel-step\"",
        "leave it out: the memory of the other rules is seen through the channel's own kernel, or holds the filtered signal",
    )?;
    let worst = kernel.map_or(0.0, growth);
    if worst <= MOST_GROWTH {
        return Ok(());
    }
    let what = format!(
        "a pixel memory that steps by filtered thresholds is unstable with this kernel: the difference grows up to {worst:.2} times in each frame"
    );
    let help = "use memory = \"filtered-step\" or \"raw-snap\", which are stable with any kernel";
    Err(Odd::new(what, help))
}

/// The first number of the noise that is out of its range.
fn odd_noise(noise: &Noise) -> Option<(&'static str, f64)> {
    let mut numbers = noise.numbers().into_iter();
    numbers.find(|(key, value)| !holds(&Noise::TABLE, key, *value))
}
