//! What a chip does without of the one that it extends.

use super::{Device, Macro, signature::Given};

/// A macro or another name of a register that the extended chip has, and this one cannot have.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOut {
    /// Its name.
    pub name: String,
    /// What it needs and is not there, as a message names it.
    pub lacks: String,
    /// The macro, if it is one.
    pub it: Option<Macro>,
}

impl LeftOut {
    /// Another name of a register.
    pub(super) fn alias(name: &str, register: &str) -> Self {
        Self {
            name: name.to_owned(),
            lacks: format!("register `{register}`"),
            it: None,
        }
    }
}

impl Device {
    /// What of the extended chip is left out here.
    #[must_use]
    pub fn left_out(&self) -> &[LeftOut] {
        &self.left_out
    }

    /// Why this chip does not have a name that the chip below has; none where that has none.
    #[must_use]
    pub fn why_no_name(&self, name: &str) -> Option<String> {
        let mut aliases = self.left_out.iter().filter(|it| it.it.is_none());
        if let Some(left) = aliases.find(|it| it.name == name) {
            return Some(self.without(left));
        }
        let below = self.below(|base| base.value_of(name).is_some())?;
        Some(format!(
            "`{name}` is a register of {below}, and not of {}",
            self.name
        ))
    }

    /// Why this chip does not have a statement that the chip below has and that takes these
    /// arguments; any arguments, where none are given.
    #[must_use]
    pub fn why_no_statement(&self, name: &str, given: Option<&[Given]>) -> Option<String> {
        let takes = |it: &super::Signature| {
            it.name == name && given.is_none_or(|given| it.bind(given).is_ok())
        };
        let left = self.left_out.iter();
        let mut left = left.filter(|left| left.it.as_ref().is_some_and(|it| takes(&it.signature)));
        if let Some(left) = left.next() {
            return Some(self.without(left));
        }
        let below = self.below(|base| base.all_callables().any(|it| takes(it.signature())))?;
        Some(format!(
            "{below} has this `{name}`, and {} does not",
            self.name
        ))
    }

    fn without(&self, left: &LeftOut) -> String {
        let LeftOut { name, lacks, .. } = left;
        format!(
            "`{name}` is left out on {}, which has no {lacks}",
            self.name
        )
    }

    /// The nearest chip below of which this is true.
    fn below(&self, holds: impl Fn(&Self) -> bool) -> Option<&str> {
        let mut base = self.base();
        while let Some(chip) = base {
            if holds(chip) {
                return Some(chip.name());
            }
            base = chip.base();
        }
        None
    }
}
