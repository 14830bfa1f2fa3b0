//! An answer for machines, and what was seen of its light.

use serde::Serialize;

use crate::scene::{Observation, SeenLight};

/// An answer with the light that was shown for it, as `light`.
#[derive(Clone, Debug, Serialize)]
pub struct WithLight<'a, T> {
    #[serde(flatten)]
    answer: &'a T,
    light: Option<SeenLight>,
}

impl<'a, T: Serialize> WithLight<'a, T> {
    /// The answer with it.
    pub fn new(answer: &'a T, observation: &Observation) -> Self {
        Self {
            answer,
            light: observation.seen_light(),
        }
    }
}
