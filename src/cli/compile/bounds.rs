//! Between which numbers the fewest words of a filter lie.

use serde_json::json;

use crate::compile::bound::{LowerBound, Proof};

/// Between which numbers the fewest words of a filter lie.
pub(super) struct Bounds {
    /// No program has fewer bus words.
    pub(super) lower: LowerBound,
    /// So many bus words were found.
    pub(super) stores: usize,
    /// Instruction words that one of them takes on the chip.
    pub(super) each: u64,
    /// How many kernels the filter has.
    pub(super) kernels: usize,
    /// How often its input is halved.
    pub(super) halvings: u32,
    /// Whether the fewest words were searched for.
    pub(super) searched: bool,
}

impl Bounds {
    fn is_optimal(&self) -> bool {
        self.stores <= usize::from(self.lower.words)
    }

    /// No program has fewer instruction words, and so many were found.
    fn ends(&self) -> [u64; 2] {
        [u64::from(self.lower.words), self.stores as u64].map(|stores| stores * self.each)
    }

    /// In words.
    pub(super) fn words(&self) -> String {
        let of = match (self.kernels > 1, self.halvings) {
            (true, 0) => "one of these kernels alone".to_owned(),
            (false, 0) => "this kernel".to_owned(),
            (true, _) => format!("one of these kernels alone, times {}", self.scale()),
            (false, _) => format!("{} of this kernel", self.scale()),
        };
        let [lower, upper] = self.ends();
        let why = match self.lower.proof {
            Proof::Exhaustive => "every one was tried, with any number of registers",
            Proof::Doubled => {
                "doubled back, it would compute the kernel in fewer words than any program: every one was tried"
            }
            Proof::Reach => "its weights lie too far away, or are too large",
        };
        let open = if self.searched {
            "is not known"
        } else {
            "was not asked (--objective words)"
        };
        if upper == 0 {
            "optimal: no word is needed".to_owned()
        } else if lower == 0 {
            format!(
                "at most {}; whether fewer compute {of} {open}",
                crate::unit::counted(upper, "word")
            )
        } else if self.is_optimal() {
            format!("optimal: no program of fewer words computes {of} ({why})")
        } else {
            format!(
                "between {lower} and {upper} words: no program of fewer than {lower} computes {of} ({why}); whether one of fewer than {upper} does {open}"
            )
        }
    }

    /// What the input's halvings make of the kernel: `1/4`.
    fn scale(&self) -> String {
        format!("1/{}", 2f64.powi(self.halvings.min(1000) as i32))
    }

    pub(super) fn json(&self) -> serde_json::Value {
        let [lower, upper] = self.ends();
        json!({
            "lower": lower,
            "upper": upper,
            "is_optimal": self.is_optimal(),
            "proof": self.lower.proof,
            "of_halved_input": self.halvings > 0,
        })
    }
}
