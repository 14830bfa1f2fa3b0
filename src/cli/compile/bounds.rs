//! Between which numbers the fewest words of a filter lie.

use serde_json::json;

use crate::compile::bound::{LowerBound, Proof};

/// Between which numbers the fewest words of a filter lie.
pub(super) struct Bounds {
    /// No program has fewer.
    pub(super) lower: LowerBound,
    /// So many were found.
    pub(super) upper: usize,
    /// How many kernels the filter has.
    pub(super) kernels: usize,
}

impl Bounds {
    fn is_optimal(&self) -> bool {
        self.upper <= usize::from(self.lower.words)
    }

    /// In words.
    pub(super) fn words(&self) -> String {
        let of = if self.kernels > 1 {
            "one of these kernels alone"
        } else {
            "this kernel"
        };
        let lower = self.lower.words;
        let why = match self.lower.proof {
            Proof::Exhaustive => "every one was tried, with any number of registers",
            Proof::Reach => "its weights lie too far away, or are too large",
        };
        if self.upper == 0 {
            "optimal: no word is needed".to_owned()
        } else if lower == 0 {
            format!(
                "at most {}; whether fewer make {of} is not known",
                crate::unit::counted(self.upper, "word")
            )
        } else if self.is_optimal() {
            format!("optimal: no program of fewer words makes {of} ({why})")
        } else {
            format!(
                "between {lower} and {} words: no program of fewer than {lower} makes {of} ({why}); whether one of fewer than {} does is not known",
                self.upper, self.upper
            )
        }
    }

    pub(super) fn json(&self) -> serde_json::Value {
        json!({
            "lower": self.lower.words,
            "upper": self.upper,
            "is_optimal": self.is_optimal(),
            "proof": self.lower.proof,
        })
    }
}
