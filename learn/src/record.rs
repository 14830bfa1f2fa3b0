//! What a run has measured: `learn.json`.

use serde::{Deserialize, Serialize};

/// The version of the file; another one is refused.
pub const VERSION: u32 = 1;

/// The copy of its task that a run's folder keeps.
pub const KEPT_TASK: &str = "task.toml";

/// What a run has measured.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// [`VERSION`].
    pub version: u32,
    /// The task's name.
    pub task: String,
    /// What is learned: `interpolation` or `flow`.
    pub goal: String,
    /// Steps of each arm, clips in each, and the side of their crops in pixels.
    pub steps: u64,
    /// Clips in a step.
    pub batch: usize,
    /// The side of a crop, in pixels.
    pub crop: usize,
    /// Weights of the network of an arm of one kind of cell.
    pub parameters: usize,
    /// A row for each arm, target, seed, form, decoder and held-out clip.
    pub rows: Vec<Row>,
    /// What was learned on the way, in order of steps.
    pub kernels: Vec<KernelAt>,
    /// What is to be said of arms, in their order.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub remarks: Vec<Remark>,
}

/// What is to be said of an arm: why the chip has no program of it, what few values have taken from
/// its kernel, a rate that is not the one that was asked for.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Remark {
    /// What the arm, its target and its seed are called in files.
    pub of: String,
    /// The arm.
    pub arm: String,
    /// The seed.
    pub seed: u64,
    /// What is to be said, without a full stop.
    pub what: String,
}

/// How good one held-out clip became.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// The arm, by its name in the task.
    pub arm: String,
    /// Events a pixel and pair that were asked for; 0 for an arm without events.
    pub target: f64,
    /// The seed.
    pub seed: u64,
    /// What made the events.
    pub form: Form,
    /// Whose decoder.
    pub decoder: Decoder,
    /// The file name of the photograph.
    pub photograph: String,
    /// Which held-out clip.
    pub clip: u64,
    /// Events.
    pub events: u64,
    /// Bits of the events as address events.
    pub bits: u64,
    /// Pixels times pairs of frames.
    pub cells: u64,
    /// dB, of light from 0 to 255; interpolation.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub psnr: Option<f64>,
    /// Structural similarity, up to 1; interpolation.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub ssim: Option<f64>,
    /// Mean end-point error in pixels a frame, over pixels seen at both ends; flow.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub epe: Option<f64>,
    /// Part of those pixels more than 1 pixel off over the clip's pairs of frames; flow.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub off_by_1: Option<f64>,
    /// The same, more than 3 pixels.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub off_by_3: Option<f64>,
}

/// What made the events of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Form {
    /// The sensor as it was trained, in the float model.
    Trained,
    /// The float model with the kernel rounded afterwards and whole thresholds.
    Quantised,
    /// The compiled program in exact arithmetic.
    Exact,
    /// The compiled program on silicon.
    Silicon,
}

/// Whose decoder made a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Decoder {
    /// The one that was trained with the arm.
    Own,
    /// One trained anew on the events of this form.
    Retrained,
}

/// The kernels of an arm at a step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct KernelAt {
    /// The arm.
    pub arm: String,
    /// Events a pixel and pair that were asked for.
    pub target: f64,
    /// The seed.
    pub seed: u64,
    /// After how many steps.
    pub step: u64,
    /// The loss, a running mean.
    pub loss: f64,
    /// Events a pixel and pair, a running mean.
    pub rate: f64,
    /// Words of the compiled program a frame, where the arm is compiled.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub words: Option<u64>,
    /// For each kind of cell (four in a row for a 2x2 pattern), row 0 north, as they were applied.
    pub kernels: Vec<Vec<Vec<f64>>>,
    /// ON thresholds, in the signal's unit, in the same order.
    pub on: Vec<f64>,
    /// OFF thresholds.
    pub off: Vec<f64>,
}

impl Form {
    /// How it is called.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Trained => "float model",
            Self::Quantised => "few levels",
            Self::Exact => "program, exact",
            Self::Silicon => "program, silicon",
        }
    }
}

impl Decoder {
    /// How it is called.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Own => "frozen",
            Self::Retrained => "retrained",
        }
    }
}
