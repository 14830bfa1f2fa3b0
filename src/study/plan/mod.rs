//! The fidelity plan: what a model may leave out in this scene, and how that is known.
//!
//! ```text
//!  scene ─► [survey] its light ─► [perturbation] by how much a plainer cell is off
//!    └────► [follow] every cell, and what may become of it ─► [bounds] ─┐
//!                              [cost] measured times ─► [choice] the cheapest within the tolerance
//!                                                             └─► [model] run it ─► [verify]
//! ```
//!
//! The full model is the sensor file in double precision, with the frames and the readout that
//! were asked for. Every bound is rigorous: it holds for this scene and seed, or, where noise is
//! left out, for all but one in 10^9 seeds. What has no such bound is not left out.
//! `docs/fidelity.md` has the derivations.

pub mod bounds;
mod burst;
mod cell;
pub mod chance;
pub mod cost;
pub mod effect;
mod fate;
pub mod follow;
pub mod model;
mod models;
pub mod perturbation;
mod row;
pub mod survey;
mod words;

pub use bounds::{Bound, Bounds, Choice};
pub use cost::Costs;
pub use effect::{Effect, Present};
pub use model::{Change, Model};
pub use survey::Light;

use crate::{
    event::readout::Readout,
    number::Format,
    reference::Description,
    scene::{Scene, SceneError, upsample},
    sensor::SensorError,
    unit::Micros,
};

/// What is asked.
#[derive(Clone, Debug)]
pub struct Question<'a> {
    /// The sensor.
    pub description: &'a Description,
    /// Its mismatch and noise.
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
}

/// Opens the scene from its start; it is looked at twice, and run.
pub type Open<'a> = dyn FnMut() -> Result<Box<dyn Scene>, SceneError> + 'a;

/// Something that could be left out.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Offer {
    /// What: an effect, or a number format.
    pub what: String,
    /// What may change if it, and what has to go with it, is left out; `None` where no bound is
    /// known.
    pub bound: Option<Bound>,
    /// The model that does without it, and without what has to go with it.
    pub model: Option<Choice>,
    /// What has to go with it.
    pub with: Vec<Effect>,
    /// Whether it is left out.
    pub left_out: bool,
    /// Why the bound is what it is, or why there is none.
    pub why: String,
}

/// The answer.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Plan {
    /// What the scene is like.
    pub light: Light,
    /// Events of the full model, at least.
    pub events: f64,
    /// The cheapest model within the tolerance.
    pub choice: Choice,
    /// What it may change.
    pub bound: Bound,
    /// Rows and columns outside of which no cell ever fires, where those are known.
    pub window: Option<model::Window>,
    /// Seconds of one core for the full model and for this one, modelled; without what the
    /// scene itself takes.
    pub seconds: [f64; 2],
    /// Everything that could be left out.
    pub offers: Vec<Offer>,
}

/// Why there is no plan.
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
    /// Nothing to look at.
    #[error("the scene has no frames")]
    #[diagnostic(help("give a scene with at least one frame"))]
    NoFrames,
    /// A tolerance that is none.
    #[error("the tolerance is {0}")]
    #[diagnostic(help("give a share of the events from 0 to 1"))]
    Tolerance(f64),
    /// The table of costs that comes with the program is damaged.
    #[error("costs.toml: {0}")]
    #[diagnostic(help("this is a fault of amacrine: please report it"))]
    Costs(#[from] toml::de::Error),
}

impl Bounds {
    /// Looks at the scene, and follows every cell through it; `seen` is called after each frame
    /// of either look.
    ///
    /// # Errors
    /// When the scene or the sensor cannot go on.
    pub fn find(
        question: &Question<'_>,
        open: &mut Open<'_>,
        mut seen: impl FnMut(),
    ) -> Result<Self, PlanError> {
        let description = question.description;
        let present = Present::of(description);
        // Where the drive is a straight line, frames in between say nothing new.
        let upsampled = question.upsample.is_some()
            && present.followed
            && present.straight
            && !present.strays
            && !present.jitter;
        let mut scene = || -> Result<Box<dyn Scene>, SceneError> {
            match question.upsample {
                Some(contrast) if !upsampled => upsample::by_contrast(open()?, Some(contrast)),
                _ => open(),
            }
        };
        let contrast = question.upsample.filter(|_| upsampled);
        let light = Light::of(&mut *scene()?, description, contrast, &mut seen)?;
        let models = models::Models::of(present, description, &light, question.formats, upsampled);
        let readout = question.readout;
        let readout = readout.filter(|r| !matches!(r, Readout::Ideal(_)));
        let within = bounds::within(question.within, &present, readout.is_some(), upsampled);
        let followed = if present.followed {
            let off = &models.off;
            let scene = &mut *scene()?;
            Some(follow::follow(
                scene,
                description,
                question.seed,
                &light,
                off,
                within,
                &mut seen,
            )?)
        } else {
            None
        };
        Ok(Self {
            present,
            description: description.clone(),
            light,
            followed,
            models,
            within,
            readout,
            inserts: question.upsample.is_some(),
            upsampled,
            crop: question.crop,
        })
    }

    /// Every choice for which something can be said.
    pub fn choices(&self, formats: &[Format]) -> impl Iterator<Item = (Choice, Bound)> {
        let alone = |effect: &Effect| self.effect(*effect).is_some();
        let effects: Vec<Effect> = Effect::ALL.into_iter().filter(alone).collect();
        let mut formats = formats.to_vec();
        formats.insert(0, Format::F64);
        formats.into_iter().flat_map(move |format| {
            let effects = effects.clone();
            (0..1_u32 << effects.len()).filter_map(move |set| {
                let taken = effects.iter().enumerate();
                let taken = taken.filter(|(n, _)| set >> n & 1 == 1);
                let without = taken.map(|(_, effect)| *effect).collect();
                let choice = Choice { format, without };
                let bound = self.of(&choice)?;
                Some((choice, bound))
            })
        })
    }
}

/// Makes the plan.
///
/// # Errors
/// When the tolerance is not from 0 to 1, or the scene or the sensor cannot go on.
pub fn plan(
    question: &Question<'_>,
    open: &mut Open<'_>,
    seen: impl FnMut(),
) -> Result<Plan, PlanError> {
    let tolerance = question.tolerance;
    if !(0.0..=1.0).contains(&tolerance) {
        return Err(PlanError::Tolerance(tolerance));
    }
    let bounds = Bounds::find(question, open, seen)?;
    let costs = Costs::shipped()?;
    let full = Choice::full();
    let mut best = (full.clone(), Bound::NOTHING, costs.seconds(&bounds, &full));
    let seconds = best.2;
    if tolerance > 0.0 {
        for (choice, bound) in bounds.choices(question.formats) {
            let cost = costs.seconds(&bounds, &choice);
            if bound.share <= tolerance && cost < best.2 {
                best = (choice, bound, cost);
            }
        }
    }
    let (choice, bound, cheapest) = best;
    Ok(Plan {
        events: bounds.events(),
        offers: bounds.offers(question.formats, &choice),
        window: bounds.window(),
        light: bounds.light,
        choice,
        bound,
        seconds: [seconds, cheapest],
    })
}
