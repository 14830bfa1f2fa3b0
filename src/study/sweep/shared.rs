//! A memo: what several points need is made once, by whichever needs it first.

use std::{
    collections::{BTreeMap, HashMap, VecDeque},
    path::{Path, PathBuf},
    sync::{Arc, Mutex, OnceLock, PoisonError},
};

use super::{build::LevelProgram, refusal::Refusal, table::Row};
use crate::study::equivalent::Ladder;

/// A memo of what several points need.
#[derive(Debug, Default)]
pub(super) struct Shared {
    truths: Mutex<VecDeque<(String, Truth)>>,
    programs: Mutex<Vec<(String, Made)>>,
    pilots: Mutex<HashMap<String, Pilot>>,
    figures: Mutex<HashMap<String, Figures>>,
    /// Where pilots are kept.
    folder: Option<PathBuf>,
}

/// The limits of plainer models, by name, or why there are none.
pub(super) type Pilot = Arc<OnceLock<Result<BTreeMap<String, f64>, Refusal>>>;

/// The figures of a model on a scene, or why there are none.
pub(super) type Figures = Arc<OnceLock<Result<Row, Refusal>>>;

/// The place of a key in a memo.
fn slot<T: Default>(all: &Mutex<HashMap<String, Arc<T>>>, key: &str) -> Arc<T> {
    let mut all = all.lock().unwrap_or_else(PoisonError::into_inner);
    Arc::clone(all.entry(key.to_owned()).or_default())
}

/// What the f64 sensor says, or why there is nothing.
pub(super) type Truth = Arc<OnceLock<Result<Ladder, Refusal>>>;

/// A program, or why there is none.
pub(super) type Made = Arc<OnceLock<Result<LevelProgram, Refusal>>>;

/// Ladders that are kept: points come task by task.
const KEPT: usize = 8;

impl Shared {
    /// Nothing yet; pilots are kept in this folder, if there is one.
    pub fn new(folder: Option<PathBuf>) -> Self {
        Self {
            folder,
            ..Self::default()
        }
    }

    /// Where pilots are kept.
    pub fn pilots(&self) -> Option<&Path> {
        self.folder.as_deref()
    }

    /// What a pilot says of a family of sensors on a scene.
    pub fn pilot(
        &self,
        key: &str,
        make: impl FnOnce() -> Result<BTreeMap<String, f64>, Refusal>,
    ) -> Pilot {
        let slot = slot(&self.pilots, key);
        slot.get_or_init(make);
        slot
    }

    /// The figures of a model that stands for several points.
    pub fn figures(&self, key: &str, make: impl FnOnce() -> Result<Row, Refusal>) -> Figures {
        let slot = slot(&self.figures, key);
        slot.get_or_init(make);
        slot
    }

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
    pub fn program(&self, key: &str, make: impl FnOnce() -> Result<LevelProgram, Refusal>) -> Made {
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
