//! A memo: what several points need is made once, by whichever needs it first.

use std::{
    collections::VecDeque,
    sync::{Arc, Mutex, OnceLock, PoisonError},
};

use super::refusal::Refusal;
use crate::{event::Packet, study::design::Compiled};

/// A memo of what several points need.
#[derive(Debug, Default)]
pub(super) struct Shared {
    references: Mutex<VecDeque<(String, Watched)>>,
    programs: Mutex<Vec<(String, Made)>>,
}

/// A packet, or why there is none.
pub(super) type Watched = Arc<OnceLock<Result<Packet, Refusal>>>;

/// A program, or why there is none.
pub(super) type Made = Arc<OnceLock<Result<(Compiled, f64, f64), Refusal>>>;

/// Reference packets that are kept: points come task by task.
const KEPT: usize = 8;

impl Shared {
    /// The packet that points of a task are measured against.
    pub fn reference(&self, task: &str, make: impl FnOnce() -> Result<Packet, Refusal>) -> Watched {
        let slot = {
            let mut all = self
                .references
                .lock()
                .unwrap_or_else(PoisonError::into_inner);
            if let Some((_, slot)) = all.iter().find(|(known, _)| known == task) {
                Arc::clone(slot)
            } else {
                let slot = Watched::default();
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
    pub fn program(
        &self,
        key: &str,
        make: impl FnOnce() -> Result<(Compiled, f64, f64), Refusal>,
    ) -> Made {
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
