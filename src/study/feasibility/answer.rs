//! The answer in numbers, as it is written to `feasibility.json`.

use super::{
    assumption::Assumption,
    chip::OnChip,
    chips::OverChips,
    named::{FigureSummary, Named},
    power::{Link, Power},
    stream::Stream,
    verdict::Verdict,
    watched::SceneSummary,
};
use crate::{
    isa::{Device, Evidence, Figure},
    kernel::Kernel,
    mesh,
    rig::guard::Warning,
    study::{
        quantisation::Row,
        waterfall::{Rates, Waterfall},
    },
    unit::Micros,
};

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
    pub kernel: KernelSummary,
    /// Of every sensor, in kernel times light (0 to 255).
    pub threshold: f64,
    /// What was watched.
    pub scene: SceneSummary,
    /// The chip on which the program is to run.
    pub chip: ChipSummary,
    /// The kernel in the few values that the chip computes with.
    pub chosen: Chosen,
    /// The program on the chip, or why there is none.
    pub fit: Fit,
    /// What becomes of all that on the chips that the public data allow.
    #[serde(flatten)]
    pub over_chips: OverChips,
    /// The chip's numbers that all this rests on, with their intervals and sources.
    pub figures: Vec<FigureSummary>,
    /// Events match within this, in microseconds.
    pub within_us: Micros,
    /// What each sensor said.
    pub streams: Streams,
    /// Where the float sensor's events went; none without a program, or without events.
    pub waterfall: Option<Waterfall>,
    /// The same over frame rate, on some of the drawn chips' seeds; none where nothing happens.
    pub over_rates: Option<Rates>,
    /// The kernel in other few values.
    pub quantisation: Vec<Row>,
    /// The kernel as resistor meshes have it, one sheet and two; empty for one of zeros.
    pub mesh: Vec<mesh::Fit>,
    /// Electrical power, part by part; none without a program.
    pub power: Option<Power>,
    /// What leaves the chip.
    pub link: Link,
    /// What was taken as given.
    pub assumptions: Vec<Assumption>,
    /// What makes these figures mean something else than they seem to.
    pub warnings: Vec<Warning>,
}

/// A kernel by its numbers.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct KernelSummary {
    /// What it is called.
    pub name: String,
    /// Row 0 to the north.
    pub weights: Vec<Vec<f64>>,
    /// Their sum: the answer to uniform light of 1.
    pub sum: f64,
}

/// The chip, and how large it is.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct ChipSummary {
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
    /// Those on which the verdict rests and that are guesses without an interval, and those of the
    /// room whose interval leaves open whether it is enough.
    pub guessed_values: Vec<String>,
}

/// A kernel in few values.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Chosen {
    /// The quantiser.
    pub to: String,
    /// Whether it was asked for; else it was the best of the table.
    pub asked_for: bool,
    /// The levels, none above 1, and their sum.
    pub levels: KernelSummary,
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

impl Feasibility {
    /// Puts the warnings of the scene before its own, and takes what was seen of the light in place
    /// of what the scene says beforehand.
    pub fn saw(&mut self, of_scene: &[Warning], light: Option<&str>) {
        self.warnings.splice(0..0, of_scene.to_owned());
        if let Some(light) = light {
            light.clone_into(&mut self.scene.light);
        }
    }
}

impl KernelSummary {
    pub(super) fn new(name: &str, kernel: &Kernel) -> Self {
        let rows = kernel.weights().rows();
        Self {
            name: name.to_owned(),
            weights: rows.into_iter().map(|row| row.to_vec()).collect(),
            sum: kernel.dc(),
        }
    }
}

impl ChipSummary {
    /// Of a chip that needs so many rows, columns and words of its store.
    pub(super) fn new(device: &Device, needed: [Option<u64>; 3]) -> Self {
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
            guessed_values: { Named::guessed_values(device).into_iter() }
                .chain(Named::open_room(device, needed))
                .map(Named::name)
                .collect(),
        }
    }
}
