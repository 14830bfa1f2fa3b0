//! What the verb and Python's function answer: the scene is kept, every model is surveyed, and all
//! of it is told.

use std::fmt;

use serde::{Serialize, Serializer};

use super::{Ask, OF_PROGRAM, OF_SENSOR, Point, Programs, Setup, Trade, told::Told, trade};
use crate::{
    array::Schedule,
    compare::window,
    number::Format,
    picture::Drawing,
    reference::Description,
    scene::{Observation, Scene, SceneError, SeenLight, kept::Kept},
    stop::Stop,
    study::pilot::{Chips, Choice, Family, Floats, Look, NoLimit, PlanError, Sampled, Survey},
    unit::{Micros, counted},
};

/// A scene in memory, which every model looks at.
pub struct Held {
    /// Its frames.
    pub kept: Kept,
    /// What it is called.
    pub name: String,
    /// Seconds that it took to read.
    pub seconds: f64,
    /// What was seen of its light.
    pub light: Option<SeenLight>,
}

/// Frames of a scene at least: of fewer nothing can be measured.
const FRAMES: usize = 3;

/// Why there is no answer.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum TradeError {
    /// The scene cannot be read.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneError),
    /// A model cannot be made, or the full one cannot go on.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Plan(#[from] PlanError),
    /// A scene for which there is no room.
    #[error("{0} is too long to be kept in memory, and every model looks at all of it")]
    #[diagnostic(help("take a shorter or smaller scene, such as the first seconds of this one"))]
    TooLong(String),
    /// A scene of too few frames.
    #[error("{scene}: {}, in which nothing can be measured", counted(*frames, "frame"))]
    #[diagnostic(help("give a scene of at least three frames"))]
    Short {
        /// What it is called.
        scene: String,
        /// How many it has.
        frames: usize,
    },
}

impl Held {
    /// Keeps a scene of this name in so many bytes at most. `clock` tells seconds since before it
    /// was opened.
    ///
    /// # Errors
    /// When it cannot be read, there is no room for it, or it has fewer than three frames.
    pub fn new(
        name: &str,
        scene: &mut dyn Scene,
        most: usize,
        observation: &Observation,
        clock: &dyn Fn() -> f64,
    ) -> Result<Self, TradeError> {
        let kept = Kept::new(scene, most)?.ok_or_else(|| TradeError::TooLong(name.to_owned()))?;
        if kept.len() < FRAMES {
            return Err(TradeError::Short {
                scene: name.to_owned(),
                frames: kept.len(),
            });
        }
        Ok(Self {
            seconds: clock(),
            kept,
            name: name.to_owned(),
            light: observation.seen_light(),
        })
    }
}

/// What is asked, of a sensor or of a program.
pub struct Asked<'a> {
    /// What it is called.
    pub of: &'a str,
    /// The contrast that frames are inserted for, in ln units.
    pub upsample: Option<f64>,
    /// Number formats to try; none for the usual ones.
    pub formats: Option<&'a [Format]>,
    /// An event that is moved by more is changed.
    pub within: Micros,
    /// The part of the sensor that is run, 0 to 1.
    pub sample: f64,
    /// How many runs share the planning.
    pub runs: u32,
    /// Whether everything is run on the whole scene, too.
    pub verify: bool,
    /// Draws mismatch, noise and tiles.
    pub seed: u64,
}

/// Who looks on.
pub struct Watch<'a> {
    /// Seconds since any moment.
    pub clock: &'a (dyn Fn() -> f64 + Sync),
    /// Called before each model is run whole, and before the tiles.
    pub begin: &'a dyn Fn(&str),
    /// Whether to give up.
    pub stop: Stop,
}

/// A trade, and all that is told of it.
pub struct Answer<'a, M> {
    /// What was asked, in words.
    pub told: Told<'a, M>,
    /// Every model, and where it stands.
    pub trade: Trade<M>,
    held: &'a Held,
    within: Micros,
}

/// Every effect of a sensor left out, and other number formats; `command` runs a model.
///
/// # Errors
/// When a model cannot be made, or the full one cannot go on.
pub fn of_sensor<'a>(
    description: &Description,
    asked: &'a Asked<'_>,
    held: &'a Held,
    watch: &Watch<'_>,
    command: &'a dyn Fn(&Choice) -> String,
) -> Result<Answer<'a, Choice>, TradeError> {
    let full = Choice::full();
    let family = Floats {
        description,
        seed: asked.seed,
        base: &full,
    };
    let rules = Rules {
        models: family.models(&asked.formats(&OF_SENSOR), asked.upsample.is_some()),
        alternative: &|choice| family.alternative(choice),
        free: &|choice, look| family.free(choice, look),
    };
    let trade = surveyed(&family, rules, asked, held, watch)?;
    let full = "f64, with all its effects".to_owned();
    Ok(Answer::new(trade, full, asked, held, command))
}

/// Every error of a program's array left out, and other arithmetics and schedules; `command` runs a
/// model.
///
/// # Errors
/// When a model cannot be made, or the full one cannot go on.
pub fn of_program<'a>(
    mut chips: Chips<'_>,
    asked: &'a Asked<'_>,
    held: &'a Held,
    watch: &Watch<'_>,
    command: &'a dyn Fn(&Setup) -> String,
) -> Result<Answer<'a, Setup>, TradeError> {
    chips.settings.threads = Some(rayon::current_num_threads());
    chips.arithmetic = chips.arithmetic.with_seed(asked.seed);
    let family = Programs {
        chips,
        schedule: Schedule::for_size(held.kept.size()),
    };
    let rules = Rules {
        models: family.models(&asked.formats(&OF_PROGRAM)),
        alternative: &|setup| family.alternative(setup),
        free: &|setup, _| family.free(setup),
    };
    let trade = surveyed(&family, rules, asked, held, watch)?;
    let full = format!("{}, {}", chips.arithmetic, family.schedule);
    Ok(Answer::new(trade, full, asked, held, command))
}

/// The models that are tried, which of them are alternatives, and which change nothing.
struct Rules<'a, M> {
    models: Vec<M>,
    alternative: &'a dyn Fn(&M) -> bool,
    free: &'a dyn Fn(&M, &Look) -> Option<&'static str>,
}

fn surveyed<F>(
    family: &F,
    rules: Rules<'_, F::Model>,
    asked: &Asked<'_>,
    held: &Held,
    watch: &Watch<'_>,
) -> Result<Trade<F::Model>, TradeError>
where
    F: Family,
    F::Model: fmt::Display,
{
    let ask = Ask {
        survey: Survey {
            kept: &held.kept,
            upsample: asked.upsample,
            within: asked.within,
            seed: asked.seed,
            clock: watch.clock,
            sample: asked.sample,
            stop: watch.stop,
        },
        models: rules.models,
        alternative: rules.alternative,
        free: rules.free,
        verify: asked.verify,
        runs: asked.runs,
        begin: watch.begin,
    };
    Ok(trade(family, &ask)?)
}

impl Asked<'_> {
    /// The number formats to try: these where none are named.
    fn formats(&self, usual: &[&str]) -> Vec<Format> {
        let usual = || usual.iter().filter_map(|name| name.parse().ok()).collect();
        self.formats.map_or_else(usual, <[Format]>::to_vec)
    }
}

impl<'a, M> Answer<'a, M> {
    fn new(
        trade: Trade<M>,
        full: String,
        asked: &'a Asked<'_>,
        held: &'a Held,
        command: &'a dyn Fn(&M) -> String,
    ) -> Self {
        Self {
            told: Told {
                of: asked.of,
                scene: &held.name,
                fps: held.kept.scene().fps(),
                full,
                verify: asked.verify,
                runs: asked.runs,
                command,
            },
            trade,
            held,
            within: asked.within,
        }
    }

    /// The chart.
    #[must_use]
    pub fn drawing(&self) -> Drawing {
        self.told.drawing(&self.trade)
    }
}

/// As `--json` has it.
#[derive(Serialize)]
#[serde(bound = "")]
struct Json<'a, M> {
    scene: &'a str,
    of: &'a str,
    full: &'a str,
    frames: usize,
    within_us: Micros,
    f1_within_us: Micros,
    kept_within_us: Micros,
    reading_seconds: f64,
    runs: u32,
    /// Where seconds were measured: `tiles`, or the `whole` scene.
    times: &'static str,
    tiles: Option<Sampled>,
    no_tiles: Option<&'a str>,
    without_slot: u64,
    points: Vec<Placed<'a, M>>,
    knee: Option<&'a str>,
    no_knee: Option<&'static str>,
    command: Option<String>,
    light: Option<&'a SeenLight>,
}

/// A model, and where it stands.
#[derive(Serialize)]
#[serde(bound = "")]
struct Placed<'a, M> {
    #[serde(flatten)]
    point: &'a Point<M>,
    error: Option<f64>,
    no_limit: Option<NoLimit>,
    seconds: Option<f64>,
    seconds_range: Option<[f64; 2]>,
    planning_seconds: f64,
    command: String,
}

impl<'a, M> Placed<'a, M> {
    fn new(point: &'a Point<M>, command: &dyn Fn(&M) -> String) -> Self {
        let seconds = point.known().map(|known| known.seconds);
        Self {
            error: point.error(),
            no_limit: point.no_limit(),
            seconds: seconds.map(|seconds| seconds.median),
            seconds_range: seconds.map(|seconds| [seconds.least, seconds.most]),
            planning_seconds: point.planning(),
            command: command(&point.model),
            point,
        }
    }
}

impl<M> Serialize for Answer<'_, M> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self {
            told, trade, held, ..
        } = self;
        let knee = trade.knee();
        let is_whole = trade.no_tiles.is_some() || told.verify;
        let placed = |point| Placed::new(point, told.command);
        let json = Json {
            scene: told.scene,
            of: told.of,
            full: &told.full,
            frames: held.kept.len(),
            within_us: self.within,
            f1_within_us: self.within,
            kept_within_us: window::headline(told.fps),
            reading_seconds: held.seconds,
            runs: told.runs,
            times: if is_whole { "whole" } else { "tiles" },
            tiles: trade.tiles,
            no_tiles: trade.no_tiles.as_deref(),
            without_slot: trade.without_slot,
            points: trade.points.iter().map(placed).collect(),
            knee: knee.map(|knee| knee.name.as_str()),
            no_knee: trade.no_knee(),
            command: knee.map(|knee| (told.command)(&knee.model)),
            light: held.light.as_ref(),
        };
        json.serialize(serializer)
    }
}
