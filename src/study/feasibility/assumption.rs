//! What is taken as given.

use super::{Question, SceneSummary};
use crate::isa::Evidence;

/// Something that was taken as given.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Assumption {
    /// The assumption, as a sentence.
    pub what: String,
    /// How well it is known.
    pub evidence: Evidence,
}

impl Assumption {
    /// All of a question.
    pub(super) fn all(question: &Question<'_>, scene: &SceneSummary) -> Vec<Self> {
        let mut all = Vec::new();
        let mut assume = |evidence, what: String| all.push(Self { what, evidence });
        assume(
            Evidence::Modelled,
            "Light is linear, 0 to 255, and one frame is one shot: both sensors decide once a frame (memory filtered-snap), with zeros beyond the border.".to_owned(),
        );
        if scene.fps_is_assumed {
            assume(
                Evidence::Guess,
                format!(
                    "The scene states no frame rate; {} frames/s were assumed.",
                    scene.fps
                ),
            );
        }
        assume(
            Evidence::Guess,
            match question.exposure {
                Some(exposure) => format!("Exposure is {exposure} a frame, as given."),
                None => "Exposure is not limiting: none was given. The longest that the frame rate leaves is stated.".to_owned(),
            },
        );
        assume(
            Evidence::Modelled,
            "Exposure runs while the array works; the readout comes after both and holds up the next frame.".to_owned(),
        );
        assume(
            Evidence::Modelled,
            "The chip's errors are one drawn chip (the seed): transfer, division and mismatch fitted to the one public measurement of SCAMP-5, noise and decay as its data say. Another seed is another chip.".to_owned(),
        );
        assume(
            Evidence::Modelled,
            "An event costs one address word: row, column and sign. Time is arrival and costs nothing.".to_owned(),
        );
        assume(
            Evidence::Quoted,
            "Power is that of the chip at its full instruction rate; what it takes when it waits is not public. 180 nm numbers of 2013 do not predict a modern stacked part.".to_owned(),
        );
        assume(
            Evidence::Guess,
            format!(
                "A bit on the link takes {} to {} pJ, as given.",
                question.link[0], question.link[1]
            ),
        );
        all
    }
}
