//! Task files.
//!
//! ```toml
//! name = "interpolation"
//! goal = "interpolation"        # or "flow"
//! steps = 20000
//! batch = 8                     # clips in a step
//! crop = 32                     # px
//! targets = [0.01, 0.02, 0.05]  # events a pixel and pair of frames
//! seeds = [1, 2, 3]
//! arms = ["none", "dvs", "rgc", "ternary"]
//! [network]
//! widths = [16, 24, 32]
//! [scenes]
//! photographs = "a/folder"      # those that come with the program when left out
//! ```

mod change;
mod keys;
mod origin;
mod read;

use std::path::PathBuf;

use amacrine::photoreceptor::Response;

use crate::{arm::Arm, network::Plan, scene::Motion};

pub use keys::FILE;
pub use origin::Origin;
pub use read::TaskError;

/// What is learned, from what, and how long.
#[derive(Clone, Debug, PartialEq)]
pub struct Task {
    /// What it is called.
    pub name: String,
    /// What the network is to say.
    pub goal: Goal,
    /// How far an answer is from the truth.
    pub loss: Distance,
    /// Steps of each arm.
    pub steps: u64,
    /// Clips in a step.
    pub batch: usize,
    /// Rows and columns of a clip.
    pub crop: usize,
    /// Events a pixel and pair of frames, all kinds together.
    pub targets: Vec<f64>,
    /// Seeds of networks, clips and mismatch.
    pub seeds: Vec<u64>,
    /// Who takes part.
    pub arms: Vec<Arm>,
    /// Channels of the network's levels.
    pub widths: Vec<usize>,
    /// 3x3 convolutions of a level.
    pub convolutions: usize,
    /// How far a weight of the network moves in a step at first, and a kernel's weight.
    pub rates: (f64, f64),
    /// A price of an event in the loss, in place of following the targets (the authors' `5e-8`).
    pub sparsity: Option<f64>,
    /// What is seen.
    pub scenes: Scenes,
    /// What all sensors have in common.
    pub sensor: Sensors,
    /// The chip that kernels of few values are trained for.
    pub chip: Option<String>,
    /// What a word of the filter, and 1 less the correlation that is predicted on silicon, add to the
    /// loss; 0 without a search among neighbours.
    pub price: [f64; 2],
    /// Held-out clips, and rows and columns of each.
    pub test: (u64, usize),
    /// Steps that the network is trained on with the events of each form of the chip, and the training
    /// clips that are shown to it.
    pub retrain: Option<(u64, u64)>,
    /// Steps between checkpoints.
    pub checkpoint: u64,
    /// Where it comes from.
    pub origin: Origin,
}

/// What the network is to say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Goal {
    /// The frame in the middle, from the first, the last, and events.
    Interpolation,
    /// The flow at the frame in the middle, from events alone.
    Flow,
}

impl Goal {
    /// Its word in files.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Interpolation => "interpolation",
            Self::Flow => "flow",
        }
    }
}

/// How far an answer is from the truth, pixel by pixel; of a flow, where it is seen at both ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Distance {
    /// `sqrt(e² + 0.001²)` (Charbonnier et al. 1994).
    Charbonnier,
    /// `|e|`.
    Absolute,
}

impl Distance {
    /// That of an error, and its slope.
    #[must_use]
    pub fn of(self, error: f32) -> (f32, f32) {
        match self {
            Self::Charbonnier => {
                let size = (error * error + EDGE * EDGE).sqrt();
                (size, error / size)
            }
            Self::Absolute if error == 0.0 => (0.0, 0.0),
            Self::Absolute => (error.abs(), error.signum()),
        }
    }
}

/// What Charbonnier's distance is rounded off by.
const EDGE: f32 = 1e-3;

/// What is seen.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenes {
    /// A folder of pictures; those that come with the program when there is none.
    pub photographs: Option<PathBuf>,
    /// A video or a pattern in their place.
    pub video: Option<String>,
    /// Different clips to train on; 0 for new ones in each step.
    pub clips: u64,
    /// Frames of a clip, odd.
    pub frames: usize,
    /// Frames a second.
    pub fps: f64,
    /// How photographs move.
    pub motion: Motion,
}

impl Scenes {
    /// The time of each frame, in seconds.
    #[must_use]
    pub fn times(&self) -> Vec<f64> {
        (0..self.frames).map(|n| n as f64 / self.fps).collect()
    }
}

/// What all sensors have in common.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensors {
    /// From light to signal.
    pub response: Response,
    /// The dead time after an event, in microseconds.
    pub refractory_us: f64,
    /// Noise of the light, standard deviation, of 255.
    pub light_noise: f64,
    /// Mismatch of thresholds, standard deviation, a part of the threshold.
    pub mismatch: f64,
}

impl Task {
    /// The network of an arm.
    #[must_use]
    pub fn plan(&self, arm: &Arm) -> Plan {
        let bins = self.scenes.frames * arm.kinds();
        Plan {
            widths: self.widths.clone(),
            convolutions: self.convolutions,
            inputs: self.pictures() + bins,
            outputs: match self.goal {
                Goal::Interpolation => 1,
                Goal::Flow => 2,
            },
        }
    }

    /// Pictures that go into the network beside the events.
    #[must_use]
    pub const fn pictures(&self) -> usize {
        match self.goal {
            Goal::Interpolation => 2,
            Goal::Flow => 0,
        }
    }

    /// Inputs of the network of an arm of one kind of cell: what all networks begin for.
    #[must_use]
    pub const fn fan(&self) -> usize {
        self.pictures() + self.scenes.frames
    }

    /// The frame in the middle.
    #[must_use]
    pub const fn middle(&self) -> usize {
        self.scenes.frames / 2
    }
}
