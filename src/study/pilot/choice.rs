//! What a model leaves out of the float model.

use std::fmt;

use crate::{
    number::Format,
    reference::{Description, Effect},
};

/// What a model leaves out: the digits of its numbers, and effects.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Choice {
    /// The format of signals, weights and memory.
    pub format: Format,
    /// What it does without, in the order of [`Effect::ALL`].
    pub without: Vec<Effect>,
}

impl Choice {
    /// Nothing is left out.
    #[must_use]
    pub const fn full() -> Self {
        Self {
            format: Format::F64,
            without: Vec::new(),
        }
    }

    /// Whether it does without `effect`.
    #[must_use]
    pub fn leaves_out(&self, effect: Effect) -> bool {
        self.without.contains(&effect)
    }

    /// The same, without one effect more.
    #[must_use]
    pub fn and_without(mut self, effect: Effect) -> Self {
        self.without.push(effect);
        self.without.sort_unstable();
        self.without.dedup();
        self
    }

    /// The sensor without what the choice does without; the format and the scene are others' work.
    #[must_use]
    pub fn plainer(&self, description: &Description) -> Description {
        let mut plain = description.clone();
        for effect in &self.without {
            effect.leave_out(&mut plain);
        }
        plain
    }
}

impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let without: Vec<_> = self.without.iter().map(Effect::to_string).collect();
        if *self == Self::full() {
            f.write_str("the full model: nothing is left out")
        } else if without.is_empty() {
            self.format.fmt(f)
        } else {
            write!(f, "{}, without {}", self.format, without.join(", "))
        }
    }
}
