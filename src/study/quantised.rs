//! What the verb `quantise` and Python's function answer: kernels in few values, and with thresholds
//! what these are on a chip, one kernel alone or all of them in one program.

use serde::Serialize;

use super::{
    StudyError,
    design::{Design, DesignError},
    joint::Joint,
    quantisation::{self, QuantisationError, Question},
};
use crate::{
    compare::window,
    compile::{DriveMemory, Effort},
    isa::Device,
    kernel::{
        Kernel,
        quantise::{QuantiseError, Quantised, Quantiser, Sum, Summary},
    },
    photoreceptor::Response,
    rig::guard::{Guard, Warning},
    scene::{Observation, Reopen, Scene as _, SeenLight},
    unit::Micros,
};

/// What is asked of kernels.
#[derive(Clone, Copy, Debug)]
pub struct Asked<'a> {
    /// What each is called.
    pub names: &'a [String],
    /// The kernels.
    pub kernels: &'a [Kernel],
    /// The quantisers, a row each.
    pub to: &'a [Quantiser],
    /// What levels must sum to.
    pub sum: Sum,
    /// Seed of stochastic rounding, of the searches and of the silicon.
    pub seed: u64,
}

/// What is asked of them on a chip.
#[derive(Clone, Copy, Debug)]
pub struct OnChip<'a> {
    /// A threshold for each kernel, in kernel times light (0 to 255).
    pub thresholds: &'a [f64],
    /// The chip.
    pub device: &'a Device,
    /// How long to search for each program.
    pub effort: Effort,
    /// What a program of several remembers; none for the first memory that fits.
    pub memory: Option<DriveMemory>,
    /// Events that are at most this far apart match; none for the window of headlines.
    pub within: Option<Micros>,
}

/// Who looks on, and where the scene comes from.
pub struct Watch<'a> {
    /// Opens the scene.
    pub open: &'a Reopen<'a>,
    /// What was seen of it.
    pub observation: &'a Observation,
    /// Called for each frame.
    pub frame: &'a dyn Fn(),
}

/// A kernel in the values of one quantiser.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// The quantiser.
    pub to: String,
    /// What became of it.
    #[serde(flatten)]
    pub few: Few,
}

/// The kernel in few values, or why it is not to be had in them.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub enum Few {
    /// Its numbers.
    Numbers(Summary),
    /// Why there are none.
    Refused {
        /// In words.
        refused: String,
    },
}

/// A quantiser, and what it makes of the kernel.
pub type Tried = (Quantiser, Result<Quantised, QuantiseError>);

/// One kernel in few values.
#[derive(Clone, Debug, Serialize)]
pub struct Kind {
    /// What it is called, where there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Its weights, row by row, row 0 to the north.
    pub kernel: Vec<Vec<f64>>,
    /// Their sum.
    pub sum: f64,
    /// A row for each quantiser.
    pub quantised: Vec<Row>,
    /// The levels of each.
    #[serde(skip)]
    pub tried: Vec<Tried>,
}

/// The answer.
#[derive(Debug, Serialize)]
#[serde(untagged)]
pub enum Answer {
    /// Of one kernel.
    One(Box<One>),
    /// Of several.
    Several(Several),
}

/// What one kernel is in few values.
#[derive(Debug, Serialize)]
pub struct One {
    /// The kernel.
    #[serde(flatten)]
    pub kind: Kind,
    /// Each version on the chip, beside the float kernel.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chip: Option<quantisation::Answer>,
    /// What was seen of the light that these were shown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub light: Option<SeenLight>,
    /// What makes these figures mean something else than they seem to.
    pub warnings: Vec<Warning>,
}

/// What several kernels are.
#[derive(Debug, Serialize)]
pub struct Several {
    /// Each on its own.
    pub kernels: Vec<Kind>,
    /// All of them in one program, for each quantiser.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub together: Vec<Joint>,
    /// What was seen of the light that these were shown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub light: Option<SeenLight>,
    /// What makes these figures mean something else than they seem to.
    pub warnings: Vec<Warning>,
}

impl Answer {
    /// The warnings: those of the scene, of the levels, of what ran.
    #[must_use]
    pub fn warnings(&self) -> &[Warning] {
        match self {
            Self::One(one) => &one.warnings,
            Self::Several(several) => &several.warnings,
        }
    }
}

/// Why there is no answer.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum QuantisedError {
    /// No kernel was given.
    #[error("no kernel")]
    #[diagnostic(help("give one, or several"))]
    Nothing,
    /// A kernel that is not to be had in any of the values.
    #[error("{name} cannot be {to}")]
    #[diagnostic(forward(cause))]
    Refused {
        /// What it is called.
        name: String,
        /// The first quantiser.
        to: Quantiser,
        /// Why.
        #[source]
        cause: QuantiseError,
    },
    /// One kernel cannot be run.
    #[error(transparent)]
    #[diagnostic(transparent)]
    One(#[from] QuantisationError),
    /// Several cannot.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Several(#[from] StudyError),
}

/// Quantises each kernel; with thresholds compiles them and runs them beside the float kernels.
///
/// # Errors
/// When a kernel is not to be had in any of the values, a threshold is not positive, or the scene or
/// a sensor cannot go on.
pub fn answer(
    asked: &Asked<'_>,
    chip: Option<&OnChip<'_>>,
    watch: &Watch<'_>,
) -> Result<Answer, QuantisedError> {
    let mut kinds = asked.kinds()?;
    let each = kinds.iter().zip(asked.kernels);
    let erased: Vec<Warning> = each
        .flat_map(|(kind, kernel)| kind.warnings(kernel))
        .collect();
    let is_several = kinds.len() > 1;
    let light = || chip.and_then(|_| watch.observation.seen_light());
    let of_scene = || match chip {
        Some(_) => Warning::of_scene(watch.observation, Response::IDENTITY),
        None => Vec::new(),
    };
    if is_several {
        let mut guard = Guard::new();
        let together = chip.map(|chip| asked.together(chip, watch, &mut guard));
        let together = together.transpose()?.unwrap_or_default();
        return Ok(Answer::Several(Several {
            kernels: kinds,
            together,
            light: light(),
            warnings: [of_scene(), erased, guard.warnings()].concat(),
        }));
    }
    let kind = kinds.pop().ok_or(QuantisedError::Nothing)?;
    let chip = chip.map(|chip| asked.alone(chip, watch)).transpose()?;
    // On a chip its own answer tells of what is erased.
    let own = chip.as_ref().map_or(erased, |chip| chip.warnings.clone());
    Ok(Answer::One(Box::new(One {
        light: light(),
        warnings: [of_scene(), own].concat(),
        kind,
        chip,
    })))
}

impl Asked<'_> {
    /// Each kernel in few values.
    ///
    /// # Errors
    /// When one is not to be had in any of them.
    pub fn kinds(&self) -> Result<Vec<Kind>, QuantisedError> {
        let is_several = self.kernels.len() > 1;
        let kind = |(name, kernel): (&String, &Kernel)| {
            Ok(Kind {
                name: is_several.then(|| name.clone()),
                ..Kind::new(kernel, self.tried(name, kernel)?)
            })
        };
        self.names.iter().zip(self.kernels).map(kind).collect()
    }

    /// The kernel in each of the ways that were asked for, or why not; an error where it is not to be
    /// had in any of them.
    fn tried(&self, name: &str, kernel: &Kernel) -> Result<Vec<Tried>, QuantisedError> {
        let mut all: Vec<Tried> = { self.to.iter() }
            .map(|to| (*to, to.quantise(kernel, self.sum, self.seed)))
            .collect();
        if all.iter().all(|(_, quantised)| quantised.is_err())
            && let Some((to, Err(cause))) = all.drain(..).next()
        {
            return Err(QuantisedError::Refused {
                name: name.to_owned(),
                to,
                cause,
            });
        }
        Ok(all)
    }

    /// The one kernel's versions, each compiled, and run beside the float kernel.
    fn alone(
        &self,
        chip: &OnChip<'_>,
        watch: &Watch<'_>,
    ) -> Result<quantisation::Answer, QuantisationError> {
        let designs = self.designs(chip)?;
        let missing = || QuantisationError::Packet("float".to_owned());
        let question = Question {
            design: *designs.first().ok_or_else(missing)?,
            quantisers: self.to,
            sum: self.sum,
            within: chip.window((watch.open)()?.fps()),
        };
        quantisation::ask(&question, watch.open, |_| (watch.frame)())
    }

    /// All kernels in one program, for each quantiser, run beside the float sensor.
    fn together(
        &self,
        chip: &OnChip<'_>,
        watch: &Watch<'_>,
        guard: &mut Guard,
    ) -> Result<Vec<Joint>, StudyError> {
        let floats = self.designs(chip)?;
        let mut programs = Vec::new();
        for to in self.to {
            let mut scene = (watch.open)()?;
            programs.push(Joint::new(
                self.names,
                &floats,
                (*to, self.sum, chip.memory),
                (chip.window(scene.fps()), &mut *scene),
                guard,
                watch.frame,
            )?);
        }
        Ok(programs)
    }

    /// The float cells.
    fn designs<'b>(&'b self, chip: &'b OnChip<'_>) -> Result<Vec<Design<'b>>, DesignError> {
        let is_none = |threshold: &&f64| !(**threshold > 0.0 && threshold.is_finite());
        if let Some(threshold) = chip.thresholds.iter().find(is_none) {
            return Err(DesignError::Threshold(*threshold));
        }
        let search = (chip.effort, self.seed);
        Ok(Design::each(
            self.kernels,
            chip.thresholds,
            chip.device,
            search,
        ))
    }
}

impl OnChip<'_> {
    fn window(&self, fps: f64) -> Micros {
        self.within.unwrap_or_else(|| window::headline(fps))
    }
}

impl Kind {
    /// It in the values in which it is to be had.
    pub fn good(&self) -> impl Iterator<Item = &Quantised> {
        self.tried.iter().filter_map(|(_, few)| few.as_ref().ok())
    }

    fn new(kernel: &Kernel, tried: Vec<Tried>) -> Self {
        let row = |(to, quantised): &Tried| Row {
            to: to.to_string(),
            few: match quantised {
                Ok(quantised) => Few::Numbers(Summary::new(kernel, quantised)),
                Err(error) => Few::Refused {
                    refused: error.to_string(),
                },
            },
        };
        Self {
            name: None,
            kernel: kernel.rows(),
            sum: kernel.sum(),
            quantised: tried.iter().map(row).collect(),
            tried,
        }
    }

    /// What few values have taken from the kernel.
    fn warnings(&self, kernel: &Kernel) -> Vec<Warning> {
        let mut guard = Guard::new();
        for (to, quantised) in &self.tried {
            for erasure in quantised.iter().flat_map(|q| q.erasures(kernel)) {
                let name = self.name.as_ref();
                let own = name.map_or_else(|| to.to_string(), |name| format!("{name} as {to}"));
                guard.warn(Warning::erased(&own, erasure));
            }
        }
        guard.warnings()
    }
}
