//! What the verb and Python's function answer: all kernels of a question, the scene's light and
//! warnings with them.

use serde::Serialize;

use super::{
    Choice, Fall, Question, Rates, Waterfall, WaterfallError, check_crossings, steps_together,
};
use crate::{
    array::Arithmetic,
    compare::window,
    compile::DriveMemory,
    event::readout::Readout,
    kernel::quantise::{Quantiser, Sum},
    photoreceptor::Response,
    picture::Drawing,
    rig::guard::Warning,
    scene::{Observation, Reopen, SeenLight},
    study::{design::Design, together},
};

/// What is asked of one kernel, or of several in one program.
pub struct Asked<'a> {
    /// What each kernel is called.
    pub names: &'a [String],
    /// The float cell of each, and the chip; the seed of the first is that of the silicon, too.
    pub designs: &'a [Design<'a>],
    /// How kernels come into few values.
    pub to: Quantiser,
    /// What they must sum to.
    pub sum: Sum,
    /// What the chip's cells hold.
    pub arithmetic: Arithmetic,
    /// How events leave the chip.
    pub readout: Readout,
    /// What a program of several remembers; none for the first memory that fits.
    pub memory: Option<DriveMemory>,
    /// The rates, and the window of matches at all of them.
    pub choice: Choice,
    /// Whether the steps at the clip's own rate are all that is asked for.
    pub steps_alone: bool,
}

/// Who looks on, and where the scene comes from.
pub struct Watch<'a> {
    /// Opens the scene.
    pub open: &'a Reopen<'a>,
    /// What was seen of it.
    pub observation: &'a Observation,
    /// Called for each frame of the steps.
    pub frame: &'a dyn Fn(),
    /// Called after each sensor of a chip that has watched its tiles.
    pub chip: &'a (dyn Fn() + Sync),
}

/// What became of one kernel's events.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Answer {
    /// What the kernel is called, where there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// What the program of several remembers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub memory: Option<String>,
    /// Step by step. Its warnings begin with those of the scene.
    #[serde(flatten)]
    pub steps: Waterfall,
    /// Over frame rate, where that was asked for.
    #[serde(flatten)]
    pub rates: Option<Rates>,
    /// What was seen of the light.
    pub light: Option<SeenLight>,
    /// How many of the warnings are of the scene.
    #[serde(skip)]
    of_scene: usize,
}

impl Answer {
    /// The warnings that are not of the scene.
    #[must_use]
    pub fn own_warnings(&self) -> &[Warning] {
        self.steps.warnings.get(self.of_scene..).unwrap_or_default()
    }

    /// The drawing: over frame rate where that was asked for, else of the steps.
    #[must_use]
    pub fn drawing(&self, title: &str) -> Drawing {
        match &self.rates {
            Some(rates) => rates.drawing(title),
            None => self.steps.drawing(title),
        }
    }
}

impl Asked<'_> {
    /// The title of a kernel's drawing.
    #[must_use]
    pub fn title(&self, kind: usize, scene: &str) -> String {
        let name = self.names.get(kind).map_or("", String::as_str);
        let of = match self.names.len() {
            1 => name.to_owned(),
            several => format!("{name}, one of {several} in one program,"),
        };
        let design = self.designs.get(kind);
        let chip = design.map_or("", |design| design.device.name());
        let threshold = design.map_or(0.0, |design| design.threshold);
        format!(
            "Where the events of {of} in {} went: {chip}, threshold {threshold}, {scene}",
            self.to
        )
    }
}

/// Follows the events of each kernel.
///
/// # Errors
/// As [`Fall::all`], [`Fall::steps`] and [`Fall::rates`].
pub fn answer(asked: &Asked<'_>, watch: &Watch<'_>) -> Result<Vec<Answer>, WaterfallError> {
    let Some(first) = asked.designs.first() else {
        return Ok(Vec::new());
    };
    let mut scene = (watch.open)()?;
    if let Some(frames) = scene.frames().filter(|_| !asked.steps_alone) {
        asked.choice.check(frames, scene.fps())?;
    }
    let question = Question {
        design: *first,
        to: asked.to,
        sum: asked.sum,
        arithmetic: asked.arithmetic.with_seed(first.seed),
        readout: asked.readout,
        within: { asked.choice.within }.unwrap_or_else(|| window::headline(scene.fps())),
    };
    check_crossings(asked.designs, &mut *(watch.open)()?)?;
    let falls = Fall::all(asked.designs, question, asked.memory)?;
    let steps = steps_together(&falls, &mut *scene, |_| (watch.frame)())?;
    let mut rates = Vec::new();
    if !asked.steps_alone {
        for fall in &falls {
            rates.push(fall.rates(&asked.choice, watch.open, watch.chip)?);
        }
    }
    let memory = falls.first().and_then(Fall::remembered).map(together::name);
    let of_scene = Warning::of_scene(watch.observation, Response::IDENTITY);
    let light = watch.observation.seen_light();
    let mut rates = rates.into_iter();
    let told = |(name, mut steps): (&String, Waterfall)| {
        steps.warnings.splice(0..0, of_scene.iter().cloned());
        Answer {
            name: (asked.names.len() > 1).then(|| name.clone()),
            memory: memory.clone(),
            steps,
            rates: rates.next(),
            light: light.clone(),
            of_scene: of_scene.len(),
        }
    };
    Ok(asked.names.iter().zip(steps).map(told).collect())
}
