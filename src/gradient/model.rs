//! A sensor that can be differentiated.

use std::fmt;

use crate::{
    kernel::Kernel,
    limit::ARRAY_SIDE,
    number::Number,
    plane::{Plane, Size},
    reference::{
        Description, MemoryRule, Noise, PolarityRule, RefractoryRule, drive::Weights,
        thresholds::Thresholds,
    },
    rng::Hash,
    unit::counted,
};

use super::{error::GradientError, float::Float, rule::Rule, signal::Photoreceptors};

/// The float model of a sensor, and its gradient, in f32 or f64.
#[derive(Clone, Debug)]
pub struct Model<R: Float> {
    pub(super) description: Description,
    pub(super) size: Size,
    pub(super) photoreceptors: Photoreceptors<R>,
    /// Rows and columns that the kernels reach beyond a pixel.
    pub(super) reach: (usize, usize),
    /// For each channel.
    pub(super) weights: Vec<Weights<R>>,
    /// The same as planes, for the way back to the light.
    pub(super) kernels: Vec<Vec<Plane<R>>>,
    pub(super) thresholds: Vec<Thresholds<R>>,
    phase: Option<Phase>,
}

/// Where the memories begin, away from the first frame.
#[derive(Clone, Copy, Debug)]
struct Phase {
    seed: u64,
    shift: f64,
}

impl<R: Float> Model<R> {
    /// The sensor of `size` as `description` says; `seed` chooses its mismatch.
    ///
    /// # Errors
    /// When the size is empty or too large, or when a rule of the sensor has no gradient here: a
    /// memory of pixels, the pixel's own polarity, a mesh, noise but for the thresholds' mismatch; when
    /// there can be no such sensor ([`Description::check`]).
    pub fn new(description: Description, size: Size, seed: u64) -> Result<Self, GradientError> {
        let sides = 1..=ARRAY_SIDE;
        if !sides.contains(&size.width) || !sides.contains(&size.height) {
            return Err(GradientError::Size { size });
        }
        if let Some((what, help)) = stands_in_the_way(&description) {
            let name = description.name;
            return Err(GradientError::Rule { name, what, help });
        }
        description.check()?;
        let channels = &description.channels;
        let kernels = || channels.iter().flat_map(|channel| &channel.kernels);
        let reach = kernels().map(Kernel::reach);
        let number = R::NUMBER;
        let held = |kernel: &Kernel| kernel.weights().mapv(|w| number.hold(w));
        let at_home = |y, x| (y, x);
        Ok(Self {
            size,
            photoreceptors: Photoreceptors::new(description.response),
            reach: reach.fold((0, 0), |a, b| (a.0.max(b.0), a.1.max(b.1))),
            weights: channels
                .iter()
                .map(|channel| Weights::new(&number, &channel.kernels))
                .collect(),
            kernels: channels
                .iter()
                .map(|channel| channel.kernels.iter().map(held).collect())
                .collect(),
            thresholds: channels
                .iter()
                .enumerate()
                .map(|(k, channel)| Thresholds::new(&channel.thresholds, size, seed, (k, &at_home)))
                .collect(),
            phase: None,
            description,
        })
    }

    /// Begins each memory away from the first frame, between an OFF threshold below and an ON
    /// threshold above it, at a place of each cell's own that `shift` moves on (1 is once around).
    ///
    /// Cells that begin at the first frame are all in step, and their events in the first pairs come
    /// late; averaged over phases, events are a smooth function of kernels and thresholds.
    #[must_use]
    pub const fn with_phase(mut self, seed: u64, shift: f64) -> Self {
        self.phase = Some(Phase { seed, shift });
        self
    }

    /// The description of this sensor.
    #[must_use]
    pub const fn description(&self) -> &Description {
        &self.description
    }

    /// Rows and columns.
    #[must_use]
    pub const fn size(&self) -> Size {
        self.size
    }

    /// The rule that suits this sensor's memory.
    #[must_use]
    pub const fn rule(&self) -> Rule {
        Rule::of(self.description.memory)
    }

    /// Whether the cells of a channel have thresholds of their own.
    pub(super) fn is_mismatched(&self, channel: usize) -> bool {
        let thresholds = &self.description.channels[channel].thresholds;
        thresholds.iter().any(|threshold| threshold.sigma > 0.0)
    }

    /// Kinds of cells.
    pub(super) fn channels(&self) -> usize {
        self.description.channels.len()
    }

    /// How far the first drive of a row's cells lies above their memories, in thresholds (of ON
    /// where it is above 0, of OFF below).
    pub(super) fn begin(&self, (clip, channel, y): (usize, usize, usize), out: &mut [R]) {
        let Some(Phase { seed, shift }) = self.phase else {
            return out.fill(R::ZERO);
        };
        let row = Hash::new(seed)
            .with(clip as u64)
            .with(((channel as u64) << 32) | y as u64);
        for (x, out) in out.iter_mut().enumerate() {
            let place = row.with(x as u64).uniform() + shift % 1.0;
            *out = R::from_f64(2.0 * (place - place.floor()) - 1.0);
        }
    }

    /// How the cells of this sensor fire.
    pub(super) fn kind(&self) -> Kind {
        let refractory = self.description.refractory;
        if !self.description.memory.steps() {
            return Kind::Snap;
        }
        match refractory.rule {
            RefractoryRule::Authors => Kind::Authors,
            RefractoryRule::DeadTime if refractory.us > 0.0 => Kind::Dead,
            RefractoryRule::DeadTime => Kind::Step,
        }
    }

    /// What the way back needs to know of it.
    pub(super) fn shape(&self) -> Shape {
        Shape {
            size: self.size,
            channels: self.channels(),
            reach: self.reach,
            kind: self.kind(),
            rests: self.silence() > 0.0,
        }
    }

    /// The refractory period in seconds.
    pub(super) fn silence(&self) -> f64 {
        self.description.refractory.us * 1e-6
    }
}

/// How cells fire: what decides which derivative a train has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// A memory that steps.
    Step,
    /// The same, with a dead time.
    Dead,
    /// The same, by the authors' refractory rule, with or without a period.
    Authors,
    /// A memory that snaps.
    Snap,
}

/// What the way back needs to know of the model that went forward.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Shape {
    size: Size,
    channels: usize,
    /// Rows and columns that the kernels reach beyond a pixel.
    reach: (usize, usize),
    kind: Kind,
    /// Whether cells are silent for a time after an event.
    rests: bool,
}

impl fmt::Display for Shape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (down, across) = self.reach;
        let memory = match self.kind {
            Kind::Snap => "a memory that snaps",
            Kind::Step | Kind::Dead | Kind::Authors => "a memory that steps",
        };
        let rule = match (self.rests, self.kind) {
            (false, Kind::Authors) => ", by the authors' rule",
            (false, _) => "",
            (true, Kind::Authors) => " and a refractory period by the authors' rule",
            (true, _) => " and a refractory period",
        };
        write!(
            f,
            "{}, {}, kernels of {}x{}, {memory}{rule}",
            self.size,
            counted(self.channels, "channel"),
            2 * across + 1,
            2 * down + 1,
        )
    }
}

/// What keeps a sensor from being differentiated, and what to use in its place.
fn stands_in_the_way(description: &Description) -> Option<(&'static str, &'static str)> {
    let step = "use memory = \"filtered-step\" or \"filtered-snap\"";
    match description.memory {
        MemoryRule::RawSnap | MemoryRule::AuthorsPixelStep => {
            return Some(("its memory holds pixels, not the filtered signal", step));
        }
        MemoryRule::FilteredSnap | MemoryRule::FilteredStep => {}
    }
    if description.polarity == PolarityRule::Pixel {
        return Some((
            "its events have the sign of the pixel's own change",
            "use polarity = \"filtered\"",
        ));
    }
    if description.noise != Noise::NONE {
        return Some((
            "it has noise in its cells",
            "leave `noise` out while it learns: add noise to the light; mismatch of thresholds (`threshold.sigma`) can stay",
        ));
    }
    if description.channels.iter().any(|c| c.surrounds.is_some()) {
        return Some((
            "a channel sees through a mesh",
            "give the channel a kernel: what `amacrine mesh solve --show difference` makes of one bright pixel (docs/mesh.md)",
        ));
    }
    None
}
