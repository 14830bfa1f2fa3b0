//! Whether a kernel can run in the pixels of a chip, what that takes, and what is lost.
//!
//! One scene, watched by the float sensor, by a plain DVS at the same threshold, and by the
//! compiled program on the array, without the chip's errors and with them. Besides: the program
//! store, registers and time; the kernel in other few values; a resistor mesh instead; power and
//! link as intervals. [`verdict`] says in words what the numbers say, by rules that it states.
//!
//! `docs/feasibility.md` derives every number; [`report`](super::report) makes a page of it.

mod assumption;
pub mod chip;
mod choice;
pub mod known;
pub mod power;
mod question;
mod said;
mod sight;
pub mod stream;
pub mod time;
pub mod verdict;

pub use assumption::Assumption;
pub use known::Known;
pub use question::{Question, ask};
pub use sight::Sight;
pub use stream::Stream;

use crate::{
    compare::CompareError,
    isa::{Device, Evidence, Figure},
    kernel::Kernel,
    mesh,
    rig::RigError,
    scene::SceneError,
    study::{
        design::DesignError,
        quantisation::{QuantisationError, Row},
        waterfall::{Waterfall, WaterfallError},
    },
    unit::Micros,
};
use chip::OnChip;
use power::{Link, Power};
use verdict::Verdict;

/// The answer in numbers.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Feasibility {
    /// The version that computed it.
    pub amacrine: &'static str,
    /// The command that computes it again.
    pub command: String,
    /// The seed in it.
    pub seed: u64,
    /// In words.
    pub verdict: Verdict,
    /// The kernel that was asked about.
    pub kernel: Weights,
    /// Of every sensor, in kernel times light (0 to 255).
    pub threshold: f64,
    /// What was watched.
    pub scene: Watched,
    /// The chip.
    pub chip: Named,
    /// The kernel in the few values that the chip computes with.
    pub chosen: Chosen,
    /// The program on the chip, or why there is none.
    pub fit: Fit,
    /// Events match within this, in microseconds.
    pub within_us: Micros,
    /// What each sensor said.
    pub streams: Streams,
    /// Where the float sensor's events went; none without a program, or without events.
    pub waterfall: Option<Waterfall>,
    /// The kernel in other few values.
    pub quantisation: Vec<Row>,
    /// The kernel as resistor meshes have it, one sheet and two; empty for one of zeros.
    pub mesh: Vec<mesh::Fit>,
    /// Electrical power of the array; none without a program.
    pub power: Option<Power>,
    /// What leaves the chip.
    pub link: Link,
    /// What was taken as given.
    pub assumptions: Vec<Assumption>,
}

/// A kernel by its numbers.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Weights {
    /// What it is called.
    pub name: String,
    /// Row 0 to the north.
    pub weights: Vec<Vec<f64>>,
    /// Their sum: the answer to uniform light of 1.
    pub sum: f64,
}

/// The scene.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Watched {
    /// What it is called.
    pub name: String,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Frames that were watched.
    pub frames: u64,
    /// From the first frame to the last.
    pub seconds: f64,
    /// Frames a second, which the chip must keep up with.
    pub fps: f64,
    /// Whether neither the scene nor the caller said so.
    pub fps_is_assumed: bool,
}

/// The chip, and how large it is.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Named {
    /// Its name.
    pub name: String,
    /// In a few words.
    pub title: String,
    /// Columns of its array.
    pub width: u64,
    /// Rows of its array.
    pub height: u64,
    /// Figures of its data that are guesses, by name.
    pub guesses: Vec<String>,
}

/// A kernel in few values.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Chosen {
    /// The quantiser.
    pub to: String,
    /// Whether it was asked for; else it was the best of the table.
    pub asked_for: bool,
    /// The levels, none above 1, and their sum.
    pub levels: Weights,
    /// What they are to be multiplied by.
    pub scale: f64,
    /// `|w - scale l| / |w|`.
    pub relative_error: f64,
}

/// A program, or none.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Fit {
    /// It runs.
    OnChip(Box<OnChip>),
    /// The chip has no room for it: what is short, and by how much.
    Refused(String),
}

/// What each sensor said.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Streams {
    /// The kernel itself in f64, one decision a frame: what the others are judged against.
    pub float: Stream,
    /// A plain DVS: each pixel on its own, at the same threshold.
    pub dvs: Stream,
    /// The program, without the chip's errors.
    pub exact: Option<Stream>,
    /// The program, with them.
    pub silicon: Option<Stream>,
}

/// Why there is no answer.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum FeasibilityError {
    /// The question makes no sense.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Design(#[from] DesignError),
    /// The table cannot be made.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Quantisation(#[from] QuantisationError),
    /// Scene or sensor cannot go on.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Rig(#[from] RigError),
    /// The scene cannot be read again.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneError),
    /// The waterfall cannot be made.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Waterfall(#[from] WaterfallError),
    /// Packets of one scene that do not compare.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Compare(#[from] CompareError),
}

impl Weights {
    fn of(name: &str, kernel: &Kernel) -> Self {
        let rows = kernel.weights().rows();
        Self {
            name: name.to_owned(),
            weights: rows.into_iter().map(|row| row.to_vec()).collect(),
            sum: kernel.sum(),
        }
    }
}

impl Named {
    fn of(device: &Device) -> Self {
        let name = |figure: Figure| {
            let (section, key) = figure.key();
            format!("{section}.{key}")
        };
        Self {
            name: device.name().to_owned(),
            title: device.title().to_owned(),
            width: device.value(Figure::Width) as u64,
            height: device.value(Figure::Height) as u64,
            guesses: device.figures_of(Evidence::Guess).map(name).collect(),
        }
    }
}
