//! Whether long work is to end early: the person no longer waits for it.

use std::sync::atomic::{AtomicBool, Ordering};

/// A flag that somebody else sets. What ends by it is thrown away: it need not be whole.
#[derive(Clone, Copy, Debug, Default)]
pub struct Stop(Option<&'static AtomicBool>);

impl Stop {
    /// Nobody asks: work goes on to its end.
    pub const NEVER: Self = Self(None);

    /// Asked for once the flag is set.
    #[must_use]
    pub const fn when(flag: &'static AtomicBool) -> Self {
        Self(Some(flag))
    }

    /// Whether it is asked for.
    #[must_use]
    pub fn is_asked(self) -> bool {
        self.0.is_some_and(|flag| flag.load(Ordering::Relaxed))
    }
}

/// It is no part of a question: what is found does not depend on it.
impl PartialEq for Stop {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Eq for Stop {}
