//! Sensors to choose from, and the front of them.

use serde::Serialize;

use crate::{
    compile::DriveMemory, kernel::quantise::Quantiser, order::Order, program::readout::Way,
    reference::Description, unit::Micros,
};

use super::super::equivalent::Likeness;

/// What is kept at least by the knee, of the most that any keeps.
pub const NEARLY: f64 = 0.95;

/// A sensor that was compiled and has run.
#[derive(Clone, Debug, Serialize)]
pub struct Candidate {
    /// Its few values.
    #[serde(serialize_with = "shown")]
    pub to: Quantiser,
    /// What the program remembers, in words.
    pub memory: String,
    /// What it remembers, as the compiler takes it.
    #[serde(skip)]
    pub remembers: DriveMemory,
    /// What of F1 is more than chance with the chip's errors, the mean of its kinds that have
    /// something to keep; none where none has.
    pub kept: Option<f64>,
    /// Of how many kinds it is the mean.
    pub kept_kinds: usize,
    /// The same of that which keeps least.
    pub least_kept: Option<f64>,
    /// Instruction words of a frame.
    pub words: u64,
    /// Instruction words that the program takes of the store.
    pub stored_words: u64,
    /// The least and the most that these words take, in microseconds.
    pub array_us: [f64; 2],
    /// Halvings of the light on the way, for each filter of the program.
    pub halvings: Vec<u32>,
    /// How the events leave the chip: the cheapest way that loses none of this scene's, on several
    /// chips of the model and without a chip's errors.
    pub readout: Way,
    /// Frames a second with it, the least and the most.
    pub frames_s: [f64; 2],
    /// How many kinds like these the chip carries.
    pub carried: usize,
    /// Each kind.
    pub kinds: Vec<Kind>,
    /// Whether no other is at least as good in kept, words and frames/s, and better in one.
    pub on_front: bool,
    /// The float sensor that it stands for.
    #[serde(skip)]
    pub sensor: Description,
    /// The program, with that readout and the words that it takes.
    #[serde(skip)]
    pub program: String,
}

/// One kind of a candidate.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Kind {
    /// What it is called.
    pub name: String,
    /// Its threshold, in kernel times light (0 to 255).
    pub threshold: f64,
    /// The same on the chip, in LSB of its register.
    pub threshold_lsb: f64,
    /// Without the chip's errors.
    pub exact: Likeness,
    /// With them.
    pub silicon: Likeness,
}

/// A quantiser and a way to remember for which there is no program.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Refused {
    /// The few values.
    pub to: String,
    /// What was to be remembered; none where the kernels are not to be had in these values.
    pub memory: Option<String>,
    /// What is short, and by how much.
    pub why: String,
}

/// The thresholds of one way to remember, and what comes of them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RatedThresholds {
    /// What is remembered: of the drives, or of the pixel.
    pub memory: &'static str,
    /// In kernel times light (0 to 255), one for each kind.
    pub thresholds: Vec<f64>,
    /// Events of the float sensor per pixel and second, all kinds together.
    pub rate: f64,
    /// The same of each kind.
    pub rates: Vec<f64>,
    /// How many events of each kind the float sensor has.
    pub events: Vec<u64>,
}

/// All candidates, and what they were judged on.
#[derive(Clone, Debug, Serialize)]
pub struct Exploration {
    /// In the order of what they keep, the best first.
    pub candidates: Vec<Candidate>,
    /// What there is no program for.
    pub refused: Vec<Refused>,
    /// The thresholds.
    pub rated: Vec<RatedThresholds>,
    /// Index of the knee among the candidates; none where no candidate keeps anything.
    pub knee: Option<usize>,
    /// Frames a second of the scene.
    pub fps: f64,
    /// Frames that were shown.
    pub frames: u64,
    /// Events match within this.
    pub window_us: Micros,
}

impl std::fmt::Display for Refused {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.memory {
            Some(memory) => write!(f, "{}, {memory}: {}", self.to, self.why),
            None => write!(f, "{}: {}", self.to, self.why),
        }
    }
}

impl Candidate {
    /// What it keeps; less than anything where there is nothing to keep.
    fn worth(&self) -> f64 {
        self.kept.unwrap_or(f64::NEG_INFINITY)
    }

    /// What is to be high: kept, fewer words, frames a second at least.
    fn merits(&self) -> [f64; 3] {
        [self.worth(), -(self.words as f64), self.frames_s[0]]
    }

    /// At least as good in everything, and better in something.
    fn beats(&self, other: &Self) -> bool {
        let (own, theirs) = (self.merits(), other.merits());
        let pairs = || own.iter().zip(&theirs);
        pairs().all(|(own, theirs)| own >= theirs) && pairs().any(|(own, theirs)| own > theirs)
    }
}

impl Exploration {
    /// The candidates that nothing beats, the best first.
    pub fn front(&self) -> impl Iterator<Item = &Candidate> {
        self.candidates.iter().filter(|it| it.on_front)
    }

    /// Finds the front and its knee.
    pub(super) fn choose(&mut self) {
        self.candidates
            .order_by(|a, b| b.worth().total_cmp(&a.worth()));
        let beaten: Vec<bool> = { self.candidates.iter() }
            .map(|one| self.candidates.iter().any(|other| other.beats(one)))
            .collect();
        for (candidate, beaten) in self.candidates.iter_mut().zip(beaten) {
            candidate.on_front = !beaten && candidate.kept.is_some();
        }
        // What cannot follow the scene is taken only where nothing can.
        let follows = |it: &Candidate| it.frames_s[0] >= self.fps;
        let any = self.candidates.iter().any(follows);
        let able = || {
            let all = self.candidates.iter().enumerate();
            all.filter(move |(_, it)| it.on_front && (!any || follows(it)))
        };
        let most = able().map(|(_, it)| it.worth()).fold(f64::MIN, f64::max);
        // Where nothing is kept, the shortest program is no better than any other.
        if most <= 0.0 {
            return;
        }
        let enough = most * NEARLY;
        let near = able().filter(|(_, it)| it.worth() >= enough);
        self.knee = near.min_by_key(|(_, it)| it.words).map(|(at, _)| at);
    }
}

fn shown<S: serde::Serializer>(to: &Quantiser, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(to)
}
