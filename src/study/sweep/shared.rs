//! A memo: what several points need is made once, by whichever needs it first.

use std::{
    collections::VecDeque,
    sync::{Arc, Mutex, OnceLock, PoisonError},
};

use super::{build::Programmed, refusal::Refusal};
use crate::study::equivalent::Ladder;

/// A memo of what several points need.
#[derive(Debug, Default)]
pub(super) struct Shared {
    truths: Mutex<VecDeque<(String, Truth)>>,
    programs: Mutex<Vec<(String, Made)>>,
}

/// What the f64 sensor says, or why there is nothing.
pub(super) type Truth = Arc<OnceLock<Result<Ladder, Refusal>>>;

/// A program, or why there is none.
pub(super) type Made = Arc<OnceLock<Result<Programmed, Refusal>>>;

/// Ladders that are kept: points come task by task.
const KEPT: usize = 8;

impl Shared {
    /// What points of a task are measured against.
    pub fn truth(&self, task: &str, make: impl FnOnce() -> Result<Ladder, Refusal>) -> Truth {
        let slot = {
            let mut all = self.truths.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some((_, slot)) = all.iter().find(|(known, _)| known == task) {
                Arc::clone(slot)
            } else {
                let slot = Truth::default();
                all.push_back((task.to_owned(), Arc::clone(&slot)));
                if all.len() > KEPT {
                    all.pop_front();
                }
                slot
            }
        };
        slot.get_or_init(make);
        slot
    }

    /// A program, the scale of its levels, and what they lose.
    pub fn program(&self, key: &str, make: impl FnOnce() -> Result<Programmed, Refusal>) -> Made {
        let slot = {
            let mut all = self.programs.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some((_, slot)) = all.iter().find(|(known, _)| known == key) {
                Arc::clone(slot)
            } else {
                let slot = Made::default();
                all.push((key.to_owned(), Arc::clone(&slot)));
                slot
            }
        };
        slot.get_or_init(make);
        slot
    }
}
