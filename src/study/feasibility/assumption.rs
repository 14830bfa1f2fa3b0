//! What is taken as given.

use super::{Question, SceneSummary, readout::ReadoutOrder};
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
            format!(
                "Light, 0 to 255, {}; one frame is one shot: both sensors decide once a frame (memory filtered-snap), with zeros beyond the border.",
                if scene.is_linear {
                    "is linear"
                } else {
                    "is taken from the samples as they are, and linear only if they are: an encoding, such as the gamma of video, was not undone (--transfer undoes it)"
                }
            ),
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
                None => "No exposure was given, so it does not limit. The longest that the frame rate allows is stated.".to_owned(),
            },
        );
        assume(
            Evidence::Modelled,
            match question.order {
                ReadoutOrder::Overlapped => "The photodiodes integrate on while the array works and while events are read (--readout overlapped): a frame takes the longer of exposure, and array then readout.",
                ReadoutOrder::Sequential => "Exposure runs while the array works; the readout comes after both and holds up the next frame (--readout sequential).",
            }.to_owned(),
        );
        assume(
            Evidence::Modelled,
            "The readout is the cheapest that loses none of this scene's events: slots for its busiest frame, or whole bit planes. Another scene may need more.".to_owned(),
        );
        assume(
            Evidence::Guess,
            format!(
                "One chip is that of the seed, with the values of the chip's data. {} more are drawn from the intervals that the public data allow, each number independently of the others, with mismatch and noise of its own.",
                question.chips
            ),
        );
        assume(
            Evidence::Modelled,
            "An event costs one address word: row, column and sign. Time is arrival and costs nothing.".to_owned(),
        );
        assume(
            Evidence::Modelled,
            "A word is taken to need the same energy as at the full instruction rate. The power of the waiting array, of a scan and of the host is not public, and is in no sum. 180 nm numbers of 2013 do not predict a modern stacked part.".to_owned(),
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
