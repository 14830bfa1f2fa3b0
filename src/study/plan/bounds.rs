//! Bounds: how much of the full model's events each choice can change, at most.
//!
//! A change is an event of one model without a partner in the other: of the same cell and sign,
//! within a window of time. Leaving out one thing after another is a chain of models, and what
//! the first and the last differ by is at most the sum of the steps (`docs/fidelity.md`).

use crate::{event::readout::Readout, number::Format, reference::Description, unit::Micros};

use super::{
    chance,
    effect::{Effect, Present},
    follow::Followed,
    models::Models,
    survey::Light,
};

/// What a model leaves out: the digits of its numbers, and effects.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Choice {
    /// The format of signals, weights and memory.
    pub format: Format,
    /// What it does without, in the order of [`Effect::ALL`].
    pub without: Vec<Effect>,
}

impl Choice {
    /// Nothing is left out.
    #[must_use]
    pub const fn full() -> Self {
        Self {
            format: Format::F64,
            without: Vec::new(),
        }
    }

    /// Whether it does without `effect`.
    #[must_use]
    pub fn leaves_out(&self, effect: Effect) -> bool {
        self.without.contains(&effect)
    }
}

/// How much may change.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Bound {
    /// Events without a partner, of both models together, at most.
    pub events: f64,
    /// The same for each event of the full model; no number where it may have none.
    pub share: f64,
}

/// All that is known about what may change.
#[derive(Clone, Debug)]
pub struct Bounds {
    pub(super) present: Present,
    pub(super) description: Description,
    pub(super) light: Light,
    pub(super) followed: Option<Followed>,
    pub(super) models: Models,
    /// How far one step of the chain may move an event, in seconds.
    pub(super) within: f64,
    pub(super) readout: Option<Readout>,
    /// Whether frames are inserted.
    pub(super) inserts: bool,
    /// Whether they are, and may be left out.
    pub(super) upsampled: bool,
    /// Whether the array may be cut.
    pub(super) crop: bool,
}

impl Bounds {
    /// Events of the full model, at least: those of the scene less what noise may have taken.
    #[must_use]
    pub fn events(&self) -> f64 {
        let Some(followed) = &self.followed else {
            return 0.0;
        };
        let taken = if self.present.strays && self.present.dead_time {
            self.silenced(followed)
        } else {
            0.0
        };
        let inserted = self.inserted().unwrap_or(f64::INFINITY);
        (followed.events as f64 - taken - inserted).max(0.0)
    }

    /// What may change if only `without` is left out, and what has to go with it.
    #[must_use]
    pub fn alone(&self, format: Format, effect: Option<Effect>) -> Option<(Choice, Bound)> {
        let mut without: Vec<Effect> = effect.into_iter().collect();
        let perturbs = format != Format::F64 || effect.is_some_and(|e| e != Effect::Surroundings);
        if perturbs && self.readout.is_some() {
            without.push(Effect::Readout);
        }
        without.extend(self.present.needs(effect));
        if self.present.needs(effect).contains(&Effect::Mismatch) && self.readout.is_some() {
            without.push(Effect::Readout);
        }
        without.sort_unstable();
        without.dedup();
        let choice = Choice { format, without };
        let bound = self.of(&choice)?;
        Some((choice, bound))
    }

    /// What may change, at most; `None` where that cannot be said, or something is left out
    /// that is not there.
    #[must_use]
    pub fn of(&self, choice: &Choice) -> Option<Bound> {
        let mut events = 0.0;
        for effect in &choice.without {
            let needs = self.present.needs(Some(*effect));
            if !needs.iter().all(|effect| choice.leaves_out(*effect)) {
                return None;
            }
            events += self.effect(*effect)?;
        }
        if choice.format != Format::F64 {
            let needs = self.present.needs(None);
            if !needs.iter().all(|effect| choice.leaves_out(*effect)) {
                return None;
            }
        }
        let touches = choice.format != Format::F64
            || choice.without.iter().any(|e| *e != Effect::Surroundings);
        if touches && self.readout.is_some() && !choice.leaves_out(Effect::Readout) {
            return None;
        }
        events += self.perturbed(choice)?;
        let touches = choice.format != Format::F64
            || choice.without.iter().any(|e| *e != Effect::Surroundings);
        if touches && *choice != Choice::full() {
            events += self.inserted()?;
        }
        let share = if events <= 0.0 {
            0.0
        } else {
            events / self.events()
        };
        Some(Bound { events, share })
    }

    /// What an effect that does not only perturb may change.
    pub(super) fn effect(&self, effect: Effect) -> Option<f64> {
        let present = self.present;
        match effect {
            Effect::Surroundings => self.window().map(|_| 0.0),
            Effect::Readout => super::burst::bound(self),
            Effect::Strays if present.strays => Some(self.strays()?),
            Effect::Jitter if present.jitter => self.jitter(),
            Effect::Refractory if present.dead_time => {
                let followed = self.followed.as_ref()?;
                Some((followed.crossings - followed.events) as f64)
            }
            Effect::LowPass if present.low_pass => Some(0.0),
            Effect::Settling if present.settling => Some(0.0),
            Effect::SheetNoise if present.sheet_noise => Some(0.0),
            Effect::Mismatch if present.mismatch => Some(0.0),
            Effect::Upsampling if self.upsampled => Some(0.0),
            _ => None,
        }
    }

    /// What format and perturbations may change together.
    fn perturbed(&self, choice: &Choice) -> Option<f64> {
        let mut left_out = 0;
        for effect in choice.without.iter().filter(|e| e.perturbs()) {
            let place = self.models.ladder.iter().position(|e| e == effect)?;
            left_out = left_out.max(place + 1);
        }
        if choice.format == Format::F64 && left_out <= usize::from(self.upsampled) {
            return Some(0.0);
        }
        if self.upsampled {
            left_out = left_out.max(1);
        }
        self.change(
            choice.format,
            left_out,
            choice.leaves_out(Effect::Refractory),
        )
    }

    fn change(&self, format: Format, left_out: usize, free: bool) -> Option<f64> {
        let mut which = self.models.which.iter();
        let n = which.position(|model| *model == (format, left_out))?;
        let change = self.followed.as_ref()?.changes.get(n)?;
        let events = if free || !self.present.dead_time {
            change.free
        } else {
            change.dead
        };
        events.is_finite().then_some(events)
    }

    /// The frames are followed as the scene has them. Where others are inserted, the full model
    /// may differ from that by so many events.
    fn inserted(&self) -> Option<f64> {
        if !self.upsampled {
            return Some(0.0);
        }
        let free = self.change(Format::F64, 1, true)?;
        let dead = self.change(Format::F64, 1, false)?;
        Some(free + dead)
    }

    /// Stray events, at most, and what they silence.
    fn strays(&self) -> Option<f64> {
        let lost = self.stray_events();
        if !self.present.dead_time {
            return Some(lost);
        }
        Some(lost + self.silenced(self.followed.as_ref()?))
    }

    /// Stray events, at most.
    pub(super) fn stray_events(&self) -> f64 {
        let noise = self.description.noise;
        let channels = self.description.channels.len() as f64;
        let cells = self.light.size.pixels() as f64 * channels;
        let hot = chance::poisson(noise.hot_fraction * cells).min(cells);
        let hot = hot * noise.hot_hz * self.light.seconds;
        chance::poisson(self.light.shots * channels + hot)
    }

    /// Scene events that stray events may silence, or free, at most.
    fn silenced(&self, followed: &Followed) -> f64 {
        let noise = self.description.noise;
        let (seconds, most) = followed.chains;
        let mean = noise.shot_hz * seconds;
        let shot = if mean > 0.0 {
            chance::bernstein(mean, mean * most as f64, most as f64)
        } else {
            0.0
        };
        if noise.hot_hz <= 0.0 || noise.hot_fraction <= 0.0 {
            return shot;
        }
        // In a hot cell every event may change.
        let mean = noise.hot_fraction * followed.crossings as f64;
        let (squares, most) = followed.cells;
        shot + chance::bernstein(mean, noise.hot_fraction * squares, most as f64)
    }

    /// Seconds that two events of one cell are apart, at least.
    pub(super) fn closest(&self) -> f64 {
        let present = self.present;
        if present.jitter || (present.strays && !present.dead_time) {
            return 0.0;
        }
        let dead = self.description.refractory.us * 1e-6;
        dead.max(self.followed.as_ref().map_or(0.0, |f| f.closest)) * (1.0 - 1e-6)
    }

    fn jitter(&self) -> Option<f64> {
        let followed = self.followed.as_ref()?;
        let sigmas = self.within * 1e6 / self.description.noise.jitter_us;
        let part = chance::beyond(sigmas);
        if part <= 0.0 {
            return Some(0.0);
        }
        let most = followed.longest as f64;
        let mean = part * followed.events as f64;
        let moved = chance::bernstein(mean, part * followed.squares, most);
        Some(2.0 * moved.min(followed.events as f64))
    }

    /// The rows and columns that have to be looked at, if those are fewer: where something
    /// changes, and twice as far as a kernel reaches around it, so that not even the rounding
    /// of a sum is another one.
    #[must_use]
    pub fn window(&self) -> Option<(std::ops::Range<usize>, std::ops::Range<usize>)> {
        let present = self.present;
        if !self.crop || present.leak || present.sheets {
            return None;
        }
        let kernels = self.description.channels.iter();
        let kernels = kernels.flat_map(|c| c.kernels.iter().chain(&c.memory_kernel));
        let reach = kernels.map(crate::kernel::Kernel::reach);
        let (down, across) = reach.fold((0, 0), |a, b| (a.0.max(b.0), a.1.max(b.1)));
        let grown = |range: &std::ops::Range<usize>, reach: usize, side: usize| {
            // From an even place on: patterns are 2x2.
            let start = range.start.saturating_sub(2 * reach) & !1;
            start..(range.end + 2 * reach).clamp(start + 1, side.max(start + 1))
        };
        let (rows, columns) = &self.light.changing;
        let size = self.light.size;
        let rows = grown(rows, down, size.height);
        let columns = grown(columns, across, size.width);
        let part = rows.len() * columns.len();
        (10 * part <= 9 * size.pixels()).then_some((rows, columns))
    }
}

/// How far one step of the chain may move an event, in seconds, so that after all of them its
/// time, rounded to microseconds, is still within the window: those that move events are a
/// perturbation, jitter, a readout, and inserted frames, which may be there three times.
pub(super) fn within(window: Micros, present: &Present, readout: bool, upsampled: bool) -> f64 {
    let parts = 1 + u8::from(present.jitter) + u8::from(readout) + 3 * u8::from(upsampled);
    (window.seconds() - 1.001e-6).max(0.0) / f64::from(parts)
}
