//! What the verb `design` and Python's function answer: what was found, and what is taken of it.

use serde::Serialize;

use super::{Exploration, ExplorationError, Question};
use crate::{
    photoreceptor::Response,
    rig::guard::Warning,
    scene::{Observation, SeenLight},
};

/// The answer.
#[derive(Clone, Debug, Serialize)]
pub struct Answer<'a> {
    /// What was found.
    #[serde(flatten)]
    pub found: &'a Exploration,
    /// The candidate that is taken, from 0.
    pub picked: usize,
    /// What the scene is called.
    pub scene: &'a str,
    /// The chip.
    pub chip: &'a str,
    /// What was seen of the light.
    pub light: Option<SeenLight>,
    /// What there is to warn of, of the scene, of all that was found, and of what is taken.
    pub warnings: Vec<Warning>,
}

impl Exploration {
    /// All that is told of it, where a candidate is taken, in a scene that is called so.
    ///
    /// # Errors
    /// When the kernels are not to be had in the few values of that candidate.
    pub fn answer<'a>(
        &'a self,
        question: &'a Question<'_>,
        picked: usize,
        scene: &'a str,
        observation: &Observation,
    ) -> Result<Answer<'a>, ExplorationError> {
        let mut warnings = Warning::of_scene(observation, Response::IDENTITY);
        if let Some(candidate) = self.candidates.get(picked) {
            warnings.extend(self.doubts(question, candidate)?);
        }
        Ok(Answer {
            found: self,
            picked,
            scene,
            chip: question.device.name(),
            light: observation.seen_light(),
            warnings,
        })
    }
}
