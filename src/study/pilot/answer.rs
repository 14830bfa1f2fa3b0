//! The answer: what could be left out, what is, and why.

use super::estimate::ChangeEstimate;

/// Something that could be left out.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Offer<M> {
    /// What is left out, in words.
    pub what: String,
    /// The model that does without it.
    pub model: M,
    /// What it changes; none where that was not measured to the end.
    pub change: Option<ChangeEstimate>,
    /// Seconds that it would take for the whole scene, and the full model's; none where it was
    /// not run.
    pub seconds: Option<[f64; 2]>,
    /// Whether it is left out.
    pub left_out: bool,
    /// Why, or why not.
    pub why: String,
}

/// What a pilot says.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Answer<M> {
    /// The model to run.
    pub choice: M,
    /// What it changes; none where nothing was measured, and nothing but what a rule allows is
    /// left out.
    pub change: Option<ChangeEstimate>,
    /// Everything that was thought of.
    pub offers: Vec<Offer<M>>,
    /// Why the pilot ended where it did.
    pub why: String,
    /// Seconds that the pilot took, the reading of the scene not included.
    pub seconds: f64,
    /// What the full model and the choice are expected to take, seconds; none where nothing was
    /// run.
    pub expected: Option<[f64; 2]>,
}

impl<M> Answer<M> {
    /// The same with the times of this share of the array.
    #[must_use]
    pub(super) fn of_part(mut self, share: f64) -> Self {
        let of_part = |seconds: [f64; 2]| seconds.map(|seconds| seconds * share);
        for offer in &mut self.offers {
            offer.seconds = offer.seconds.map(of_part);
        }
        self.expected = self.expected.map(of_part);
        self
    }
}
