//! The plan of a run: what the float model may leave out in one scene.

use std::ops::Range;

use crate::{
    event::readout::Readout,
    kernel::Kernel,
    number::Format,
    plane::Size,
    reference::{Description, Effect},
    scene::{SceneError, kept::Kept},
    sensor::SensorError,
    unit::Micros,
};

use super::{
    answer::Offer,
    choice::Choice,
    estimate::ChangeEstimate,
    family::Family as _,
    first_frames::clocked,
    float::Floats,
    look::{Grid, Look},
    measure::Measure,
    rule,
};

/// What is asked.
#[derive(Clone, Debug)]
pub struct Question<'a> {
    /// The sensor.
    pub description: &'a Description,
    /// Its mismatch and noise; draws the tiles, too.
    pub seed: u64,
    /// The share of the full model's events that may change: 0.01 for 1 %.
    pub tolerance: f64,
    /// An event that is moved by more is changed.
    pub within: Micros,
    /// Number formats that may be taken in place of double precision.
    pub formats: &'a [Format],
    /// The contrast that frames are inserted for, in ln units.
    pub upsample: Option<f64>,
    /// What stands between the cells and the packet.
    pub readout: Option<Readout>,
    /// Whether the array may be cut to where something changes.
    pub crop: bool,
    /// Whether the scene is looked at whatever that takes: the plan itself is what is asked for.
    pub looks_anyway: bool,
    /// What the pilot may spend: a part of the full model's time, and seconds besides.
    pub budget: (f64, f64),
    /// So many tiles whatever they cost, in place of what the budget affords.
    pub tiles: Option<usize>,
}

/// What a pilot may spend where nobody says: with the reading of the scene less than 5 % and a
/// tenth of a second.
pub const BUDGET: (f64, f64) = (0.04, 0.06);

/// The most bytes of a scene that is kept for a pilot.
pub const KEPT: usize = 1 << 30;

/// Why nothing was measured of a scene that takes more.
pub const TOO_LONG: &str = "the scene is too long to be kept, so nothing was measured";

/// Rows and columns.
pub type Crop = (Range<usize>, Range<usize>);

impl Question<'_> {
    /// Whether a pilot would look at the scene: else there is no need to keep it.
    #[must_use]
    pub fn looks(&self) -> bool {
        let family = Floats {
            description: self.description,
            seed: self.seed,
            base: &Choice::full(),
        };
        let is_cut = self.crop && !may_fire_anywhere(self.description);
        self.tolerance > 0.0
            && self.is_read_ideally()
            && (self.looks_anyway || is_cut || family.halo().is_ok())
    }

    /// Whether events leave the cells as they are.
    fn is_read_ideally(&self) -> bool {
        let is_ideal = |readout: Readout| matches!(readout, Readout::Ideal(_));
        self.readout.is_none_or(is_ideal)
    }
}

/// What a rule allows to leave out.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Free {
    /// The effect.
    pub what: Effect,
    /// Why it changes nothing.
    pub why: &'static str,
}

/// The answer.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Plan {
    /// The model to run.
    pub choice: Choice,
    /// What it changes; none where nothing but what a rule allows is left out.
    pub change: Option<ChangeEstimate>,
    /// What rules allow to leave out.
    pub free: Vec<Free>,
    /// What was thought of, and measured.
    pub offers: Vec<Offer<Choice>>,
    /// Why the pilot ended where it did.
    pub why: String,
    /// Rows and columns outside of which no cell ever fires, where the array is cut to them.
    pub window: Option<Crop>,
    /// Seconds that the pilot took, the reading of the scene not included.
    pub seconds: f64,
    /// Seconds that the full model, without what is free, and the choice are expected to take, the
    /// scene not included; none where nothing was run.
    pub expected: Option<[f64; 2]>,
}

/// Why there is no plan, or no run of it.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum PlanError {
    /// The scene cannot be read.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneError),
    /// The sensor cannot go on.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Sensor(#[from] SensorError),
    /// A tolerance that is none.
    #[error("the tolerance is {0}")]
    #[diagnostic(help("give a share of the events from 0 to 1"))]
    Tolerance(f64),
}

impl Plan {
    /// The share of the events that what is left out changes at most, with the pilot's
    /// confidence; 0 where only rules allow it.
    #[must_use]
    pub fn limit(&self) -> f64 {
        self.change.and_then(|change| change.limit).unwrap_or(0.0)
    }

    /// What it leaves of the array, where it cuts it.
    #[must_use]
    pub fn crop(&self) -> Option<&Crop> {
        let cuts = self.choice.leaves_out(Effect::Surroundings);
        self.window.as_ref().filter(|_| cuts)
    }

    fn full(why: &str) -> Self {
        Self {
            choice: Choice::full(),
            change: None,
            free: Vec::new(),
            offers: Vec::new(),
            why: why.to_owned(),
            window: None,
            seconds: 0.0,
            expected: None,
        }
    }
}

/// Makes the plan. Where the scene is too long to be `kept`, there are rules only.
///
/// # Errors
/// When the tolerance is not from 0 to 1, or the full model cannot be made.
pub fn plan(
    question: &Question<'_>,
    kept: Option<&Kept>,
    clock: &(dyn Fn() -> f64 + Sync),
) -> Result<Plan, PlanError> {
    let Question {
        description,
        tolerance,
        upsample,
        ..
    } = *question;
    if !(0.0..=1.0).contains(&tolerance) {
        return Err(PlanError::Tolerance(tolerance));
    }
    if tolerance == 0.0 {
        return Ok(Plan::full("nothing may change"));
    }
    if !question.is_read_ideally() {
        // A queue may lose any event for one that came before: there is no sample of it, and no
        // limit on what the smallest change does.
        return Ok(Plan::full(
            "what a readout does to an event depends on all others, so nothing is left out before it",
        ));
    }
    let mut plan = Plan::full("");
    let Some(kept) = kept else {
        plan.inserted(description, upsample);
        plan.choice = plan.base();
        let family = Floats {
            description,
            seed: question.seed,
            base: &plan.choice,
        };
        let why = match family.halo() {
            Err(why) => why,
            Ok(_) => TOO_LONG,
        };
        why.clone_into(&mut plan.why);
        return Ok(plan);
    };
    let start = clock();
    let size = kept.size();
    let all = Choice::full();
    let family = Floats {
        description,
        seed: question.seed,
        base: &all,
    };
    let grid = Grid::new(size, family.halo().unwrap_or(0));
    // Frames that are inserted take more than any look.
    let waits = question.tiles.is_some() || question.looks_anyway || upsample.is_some();
    if !waits && !family.affords_a_look(question, kept, grid, clock)? {
        plan.inserted(description, upsample);
        plan.choice = plan.base();
        TOO_QUICK.clone_into(&mut plan.why);
        plan.seconds = clock() - start;
        return Ok(plan);
    }
    let look = Look::new(kept, grid, family.is_relative());
    if description.refractory.us > 0.0 && rule::has_no_close_crossings(description, &look) {
        plan.free.push(Free {
            what: Effect::DeadTime,
            why: "the light changes so slowly that no two crossings of a cell are as close as the dead time",
        });
    }
    if question.crop
        && let Some(window) = window(description, &look)
    {
        plan.window = Some(window);
        plan.free.push(Free {
            what: Effect::Surroundings,
            why: "nothing ever changes outside of these rows and columns, grown by what kernels reach",
        });
    }
    // Without close crossings, a dead time decides nothing.
    plan.inserted(&plan.base().plainer(description), upsample);
    let base = plan.base();
    let candidates = candidates(question, &base);
    let left = plan.part_of(size);
    let measure = Measure {
        kept,
        upsample: upsample.filter(|_| !base.leaves_out(Effect::InsertedFrames)),
        tolerance,
        within: question.within,
        seed: question.seed,
        clock,
        budget: (
            left * question.budget.0,
            question.budget.1 - (clock() - start),
        ),
        tiles: question.tiles,
        look: Some(&look),
        limits_only: false,
    };
    let family = Floats {
        description,
        seed: question.seed,
        base: &base,
    };
    // Times were measured of the whole array.
    let answer = measure.ask(&family, &candidates)?.of_part(left);
    Ok(Plan {
        choice: answer.choice,
        change: answer.change,
        offers: answer.offers,
        why: answer.why,
        expected: answer.expected,
        seconds: clock() - start,
        ..plan
    })
}

/// Frames that are timed, after one that is another body.
const TIMED: usize = 2;

/// The part of a pilot's time that may go into the look.
const LOOKING: f64 = 0.5;

const TOO_QUICK: &str =
    "the part of the full run's time that a pilot may take is too short for a look at the scene";

impl Floats<'_> {
    /// Whether a look at all of the scene takes no more than it may, by the time of the first frames:
    /// of the look, and of the full model on the whole sensor.
    fn affords_a_look(
        &self,
        question: &Question<'_>,
        kept: &Kept,
        grid: Grid,
        clock: &(dyn Fn() -> f64 + Sync),
    ) -> Result<bool, PlanError> {
        let pairs = kept.len().saturating_sub(1) as f64;
        let sensor = self.whole(&self.full(), grid.size)?;
        let Some(seconds) = clocked(sensor, kept, TIMED, clock)? else {
            return Ok(true);
        };
        let each = seconds.iter().sum::<f64>() / TIMED as f64;
        let start = clock();
        let looked = Look::of_first(TIMED + 1, kept, grid, self.is_relative());
        std::hint::black_box(looked);
        let look = (clock() - start) / TIMED as f64 * pairs;
        let (part, besides) = question.budget;
        Ok(look <= LOOKING * (part * each * pairs + besides))
    }
}

impl Plan {
    /// Leaves inserted frames out where a rule allows it.
    fn inserted(&mut self, description: &Description, upsample: Option<f64>) {
        let what = Effect::InsertedFrames;
        let why = rule::needs_no_inserted_frames(description).filter(|_| upsample.is_some());
        self.free.extend(why.map(|why| Free { what, why }));
    }

    /// The share of the pixels that is left of the array.
    fn part_of(&self, size: Size) -> f64 {
        let pixels = |(rows, columns): &Crop| rows.len() * columns.len();
        let left = self.window.as_ref().map_or(size.pixels(), pixels);
        left as f64 / size.pixels() as f64
    }

    /// What rules leave out.
    fn base(&self) -> Choice {
        let free = self.free.iter().map(|free| free.what);
        free.fold(Choice::full(), Choice::and_without)
    }
}

/// What could be left out besides, one thing at a time.
fn candidates(question: &Question<'_>, base: &Choice) -> Vec<(String, Choice)> {
    let inserts = question.upsample.is_some();
    let is_there = |effect: &Effect| effect.is_in(question.description, inserts);
    let effects = Effect::ALL.iter().copied().filter(is_there);
    let effects = effects.filter(|effect| !base.leaves_out(*effect));
    let effects = effects.map(|effect| (effect.to_string(), base.clone().and_without(effect)));
    let formats = question
        .formats
        .iter()
        .filter(|format| **format != Format::F64);
    let formats = formats.map(|format| {
        let choice = Choice {
            format: *format,
            ..base.clone()
        };
        (format!("f64, for {format}"), choice)
    });
    effects.chain(formats).collect()
}

/// Whether a cell may fire that no change of the light is near.
fn may_fire_anywhere(description: &Description) -> bool {
    let mut channels = description.channels.iter();
    description.fires_alone() || channels.any(|channel| channel.surrounds.is_some())
}

/// The rows and columns that have to be looked at, if those are fewer: where something changes,
/// and twice as far as a kernel reaches around it, so that not even the rounding of a sum is
/// another one.
fn window(description: &Description, look: &Look) -> Option<Crop> {
    if may_fire_anywhere(description) {
        return None;
    }
    let kernels = description.channels.iter();
    let kernels = kernels.flat_map(|c| c.kernels.iter().chain(&c.memory_kernel));
    let reach = kernels.map(Kernel::reach);
    let (down, across) = reach.fold((0, 0), |a, b| (a.0.max(b.0), a.1.max(b.1)));
    let grown = |range: &Range<usize>, reach: usize, side: usize| {
        // From an even place on: patterns are 2x2.
        let start = range.start.saturating_sub(2 * reach) & !1;
        start..(range.end + 2 * reach).clamp(start + 1, side.max(start + 1))
    };
    let (rows, columns) = &look.changing;
    let size = look.grid.size;
    let rows = grown(rows, down, size.height);
    let columns = grown(columns, across, size.width);
    let part = rows.len() * columns.len();
    (10 * part <= 9 * size.pixels()).then_some((rows, columns))
}
