//! A memo: what several points need is made once, by whichever needs it first.

use std::{
    collections::{BTreeMap, HashMap, VecDeque},
    path::{Path, PathBuf},
    sync::{Arc, Mutex, OnceLock, PoisonError},
};

use super::{ground_truth::Truth, refusal::Refusal};
use crate::study::sweep::{
    results::{
        error::{Kept, StoreError},
        pilot_file::Found,
    },
    scene::cached_scene::Drive,
    sensor::level_program::{LevelProgram, ProgramSpec},
    tables::table::Row,
};

/// A memo of what several points need.
#[derive(Debug, Default)]
pub(in crate::study::sweep) struct Shared {
    truths: Mutex<VecDeque<(String, Known)>>,
    drives: Mutex<VecDeque<(String, DriveSlot)>>,
    programs: Mutex<Vec<(ProgramSpec, Made)>>,
    pilots: Mutex<HashMap<String, Pilot>>,
    figures: Mutex<HashMap<String, Figures>>,
    /// Where pilots are kept.
    folder: Option<PathBuf>,
    /// How many pilots were measured, and their seconds.
    cost: Mutex<(usize, f64)>,
    /// Why a pilot that was measured is not kept.
    unkept: Mutex<Option<StoreError>>,
}

/// The limits of plainer models, by name, or why there are none.
pub(super) type Pilot = Arc<OnceLock<Result<Found, Refusal>>>;

/// The figures of a model on a scene, or why there are none.
pub(super) type Figures = Arc<OnceLock<Result<Row, Refusal>>>;

/// The place of a key in a memo.
fn slot<T: Default>(all: &Mutex<HashMap<String, Arc<T>>>, key: &str) -> Arc<T> {
    let mut all = all.lock().unwrap_or_else(PoisonError::into_inner);
    Arc::clone(all.entry(key.to_owned()).or_default())
}

/// What the f64 sensor says, or why there is nothing.
pub(super) type Known = Arc<OnceLock<Result<Truth, Refusal>>>;

/// A program, or why there is none.
pub(super) type Made = Arc<OnceLock<Result<LevelProgram, Refusal>>>;

/// What sheets make of a scene, if it is kept.
pub(super) type DriveSlot = Arc<OnceLock<Option<Drive>>>;

/// Ladders that are kept: points come task by task.
const KEPT: usize = 8;

/// Drives that are kept: points behind the same sheets come one after the other.
const KEPT_DRIVES: usize = 4;

/// The place of a key in a memo of the last so many.
fn recent<T: Default>(all: &Mutex<VecDeque<(String, Arc<T>)>>, key: &str, most: usize) -> Arc<T> {
    let mut all = all.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((_, slot)) = all.iter().find(|(known, _)| known == key) {
        return Arc::clone(slot);
    }
    let slot = Arc::default();
    all.push_back((key.to_owned(), Arc::clone(&slot)));
    if all.len() > most {
        all.pop_front();
    }
    slot
}

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
    pub fn pilot(&self, key: &str, make: impl FnOnce() -> Result<Found, Refusal>) -> Pilot {
        let slot = slot(&self.pilots, key);
        slot.get_or_init(make);
        slot
    }

    /// That a pilot was measured, in so many seconds.
    pub fn count_pilot(&self, seconds: f64) {
        let mut cost = self.cost.lock().unwrap_or_else(PoisonError::into_inner);
        cost.0 += 1;
        cost.1 += seconds;
    }

    /// That a pilot that was measured cannot be kept.
    pub fn cannot_keep(&self, error: StoreError) {
        let mut unkept = self.unkept.lock().unwrap_or_else(PoisonError::into_inner);
        unkept.get_or_insert(error);
    }

    /// Whether all pilots are kept that were measured.
    ///
    /// # Errors
    /// With the first that is not, once.
    pub fn pilots_are_kept(&self) -> Kept<()> {
        let mut unkept = self.unkept.lock().unwrap_or_else(PoisonError::into_inner);
        unkept.take().map_or(Ok(()), Err)
    }

    /// How many pilots were measured and not known, and in how many seconds of one thread.
    pub fn pilot_cost(&self) -> (usize, f64) {
        *self.cost.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What the pilots say that were asked, by identity.
    pub fn known_pilots(&self) -> BTreeMap<String, Found> {
        let all = self.pilots.lock().unwrap_or_else(PoisonError::into_inner);
        let known = all.iter().filter_map(|(id, pilot)| {
            let found = pilot.get()?.as_ref().ok()?;
            Some((id.clone(), found.clone()))
        });
        known.collect()
    }

    /// The figures of a model that stands for several points.
    pub fn figures(&self, key: &str, make: impl FnOnce() -> Result<Row, Refusal>) -> Figures {
        let slot = slot(&self.figures, key);
        slot.get_or_init(make);
        slot
    }

    /// What sheets make of a scene.
    pub fn drive(&self, key: &str, make: impl FnOnce() -> Option<Drive>) -> DriveSlot {
        let slot = recent(&self.drives, key, KEPT_DRIVES);
        slot.get_or_init(make);
        slot
    }

    /// What points of a task are measured against.
    pub fn truth(&self, task: &str, make: impl FnOnce() -> Result<Truth, Refusal>) -> Known {
        let slot = recent(&self.truths, task, KEPT);
        slot.get_or_init(make);
        slot
    }

    /// A program, the scale of its levels, and what they lose.
    pub fn program(&self, spec: &ProgramSpec) -> Made {
        let slot = {
            let mut all = self.programs.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some((_, slot)) = all.iter().find(|(known, _)| known == spec) {
                Arc::clone(slot)
            } else {
                let slot = Made::default();
                all.push((spec.clone(), Arc::clone(&slot)));
                slot
            }
        };
        slot.get_or_init(|| LevelProgram::new(spec));
        slot
    }
}
