//! `sample = { method = "search" }`: successive halving. All candidates are tried on a small part of
//! the scene, the best of them on a larger part, and what is left on the whole scene.
//!
//! ```text
//! candidates ─► a 32nd of the scene ─ survivors ─► an eighth ─ survivors ─► the whole, as any point
//! ```
//!
//! A part of a scene is some frames of it, beginning at a frame that a hash draws, and the square
//! of the array in which most changes there. What is tried there is measured as any point is, and
//! kept by content in `pilots/` of the folder: a search that is gone on with chooses as before.
//! Jamieson & Talwalkar 2016 for one objective; here who survives is who is on the front of error
//! and cost (`survivors`).

use std::{
    collections::{HashMap, HashSet},
    sync::{Arc, Mutex, PoisonError},
};

use serde_json::json;
use sha2::{Digest, Sha256};

use super::{
    cached_scene::{CachedScene, Part, hex},
    error::Kept,
    measure::{described, measure, without_figures},
    pilot_file::PilotFile,
    plan::{Entry, Plan},
    provenance::Provenance,
    record::{Record, is_failed},
    report::no_error,
    run::{Failed, Run},
    sample::Search,
    shared::Shared,
    store::Store,
    study::{COSTS, Settings},
    survivors::survivors,
    table::{self, Row},
};
use crate::{order::Order, rng::Hash, scene::SceneError, study::front::Cost};

/// What a rung did.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Rung {
    /// Points that were tried.
    pub points: usize,
    /// Of these, those that were tried now; the others were known.
    pub tried: usize,
    /// What they saw, in frames of the whole sensor.
    pub point_frames: f64,
}

/// What a search did.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Searched {
    /// The rungs, and at their end the whole scene.
    pub rungs: Vec<Rung>,
    /// What all of it saw, in frames of the whole sensor.
    pub point_frames: f64,
    /// What all candidates would have seen.
    pub of: f64,
    /// Points that went no further since a rung has no error or no cost of them, with the reason.
    pub nothing: Vec<Failed>,
}

/// What a search comes to.
#[derive(Debug, Default)]
pub(super) struct Chosen {
    /// Numbers of the points that are to be computed on the whole scene.
    pub points: HashSet<usize>,
    pub did: Searched,
    /// Points that were given up in a rung.
    pub failed: Vec<Failed>,
}

/// What the reason of a point begins with that was given up in a rung.
const IN_A_RUNG: &str = "on a part of the scene: ";

impl Chosen {
    /// Points that were given up in a rung are rows, until a run gets further with them.
    pub fn keep_failed(
        &self,
        plan: &Plan,
        store: &Store,
        records: &HashMap<String, Record>,
    ) -> Kept<()> {
        let failed = self.failed.iter();
        let failed: HashMap<usize, &str> = failed.map(|f| (f.point, &*f.reason)).collect();
        for (point, entry) in plan.entries.iter().enumerate() {
            let held = records.get(&entry.id);
            if let Some(reason) = failed.get(&point) {
                if !held.is_some_and(Record::is_final) {
                    let row = without_figures(described(plan, entry), "failed", reason);
                    let provenance = Provenance::here();
                    store.keep(&entry.id, &Record { row, provenance })?;
                }
            } else if held.is_some_and(|held| {
                is_failed(&held.row) && table::cell(&held.row, "reason").starts_with(IN_A_RUNG)
            }) {
                store.forget(&entry.id)?;
            }
        }
        Ok(())
    }
}

/// The part of the scene that a rung sees, and the share of the candidates that come to it; the
/// last rung is the whole.
const RUNGS: [(f64, f64); 2] = [(1.0 / 32.0, 1.0), (1.0 / 8.0, 0.125)];

/// The fewest points that are computed on the whole scene.
const FEWEST: usize = 8;

/// A rung that sees more of a scene than this is left out: it saves too little.
const MUCH: f64 = 0.5;

impl Run<'_> {
    /// Tries candidates rung by rung.
    pub(super) fn search(
        &self,
        search: Search,
        store: &Store,
        done: &(impl Fn() + Sync),
    ) -> Kept<Chosen> {
        let plan = self.plan;
        let all = plan.entries.len();
        let finish = ((search.finish * all as f64).ceil() as usize).max(FEWEST);
        let mut left: Vec<usize> = (0..all).collect();
        let mut failed = Vec::new();
        let mut did = Searched {
            of: plan.entries.iter().map(|e| e.scene.frames as f64).sum(),
            ..Searched::default()
        };
        for (number, (part, share)) in (0..).zip(RUNGS) {
            let quota = ((share * all as f64).ceil() as usize).max(finish);
            left.truncate(quota);
            if left.len() <= finish {
                break;
            }
            let Some(rung) = Cut::new(plan, &left, (part, Hash::new(search.seed).with(number)))
            else {
                continue;
            };
            let tried = self.try_rung(&rung, search, store, done)?;
            did.rungs.push(tried.rung);
            let numbered = |list: Vec<(usize, String)>| {
                let of = |(i, reason)| {
                    Some(Failed {
                        point: *left.get(i)?,
                        reason,
                    })
                };
                list.into_iter().filter_map(of).collect::<Vec<_>>()
            };
            did.nothing.extend(numbered(tried.nothing));
            failed.extend(numbered(tried.failed));
            let ranked = tried.ranked.into_iter();
            left = ranked.filter_map(|i| left.get(i).copied()).collect();
        }
        did.nothing.order_by_key(|nothing| nothing.point);
        left.truncate(finish);
        did.rungs.push(Rung {
            points: left.len(),
            tried: 0,
            point_frames: seen(
                { left.iter() }.filter_map(|i| Some(plan.entries.get(*i)?.scene.frames as f64)),
            ),
        });
        did.point_frames = seen(did.rungs.iter().map(|rung| rung.point_frames));
        Ok(Chosen {
            points: left.into_iter().collect(),
            did,
            failed,
        })
    }

    /// Tries the points of a rung. What failed is not kept: the next run tries it again.
    fn try_rung(
        &self,
        cut: &Cut,
        search: Search,
        store: &Store,
        done: &(impl Fn() + Sync),
    ) -> Kept<Tried> {
        let folder = store.pilots()?;
        let known = |entry: &Entry| PilotFile::read(&folder, &entry.id);
        let entries = cut.plan.entries.iter().enumerate();
        let work: Vec<_> = entries
            .filter(|(_, entry)| known(entry).is_none())
            .collect();
        let tried = work.len();
        let run = Run {
            plan: &cut.plan,
            shard: None,
            ..*self
        };
        let failed = Mutex::new(Vec::new());
        // A disk that does not take them is no reason to go without.
        let made = Mutex::new(HashMap::new());
        run.on_threads(work, &Shared::new(None), |i, entry, shared| {
            let row = run.computed(entry, || measure(run.plan, entry, shared, run.limits));
            if is_failed(&row) {
                let reason = format!("{IN_A_RUNG}{}", table::cell(&row, "reason"));
                let mut failed = failed.lock().unwrap_or_else(PoisonError::into_inner);
                failed.push((i, reason));
            } else {
                let file = tried_file(&entry.id, &row);
                file.write(&folder);
                let mut made = made.lock().unwrap_or_else(PoisonError::into_inner);
                made.insert(i, file);
            }
            done();
            Ok(())
        })?;
        let mut failed = failed.into_inner().unwrap_or_else(PoisonError::into_inner);
        failed.order_by_key(|(i, _)| *i);
        let mut made = made.into_inner().unwrap_or_else(PoisonError::into_inner);
        let mut costs = Vec::new();
        let mut numbers = Vec::new();
        let mut nothing = Vec::new();
        for (i, entry) in cut.plan.entries.iter().enumerate() {
            let file = made.remove(&i).or_else(|| known(entry));
            let Some(PilotFile {
                figures, reason, ..
            }) = file
            else {
                continue;
            };
            let figure = |column: &str| figures.get(column).copied();
            if let (Some(y), Some(x)) = (figure("error"), figure(search.cost)) {
                costs.push(Cost { x, y });
                numbers.push(i);
            } else {
                let reason = reason.unwrap_or_else(|| format!("it has no {}", search.cost));
                nothing.push((i, format!("{IN_A_RUNG}{reason}")));
            }
        }
        let ranked = survivors(&costs, costs.len()).into_iter();
        Ok(Tried {
            ranked: ranked.filter_map(|i| numbers.get(i).copied()).collect(),
            rung: Rung {
                points: cut.plan.entries.len(),
                tried,
                point_frames: cut.point_frames,
            },
            nothing,
            failed,
        })
    }
}

/// What came of a rung; points are counted within it.
struct Tried {
    /// The best first.
    ranked: Vec<usize>,
    rung: Rung,
    /// Points without an error or a cost, and why.
    nothing: Vec<(usize, String)>,
    /// Points that were given up, and why.
    failed: Vec<(usize, String)>,
}

/// What a rung keeps of a point.
fn tried_file(id: &str, row: &Row) -> PilotFile {
    let number = |column: &str| row.get(column)?.as_f64().filter(|n| n.is_finite());
    let columns = ["error"].into_iter().chain(COSTS);
    let figures = columns.filter_map(|column| Some((column.to_owned(), number(column)?)));
    let refused = table::cell(row, "reason");
    PilotFile {
        id: id.to_owned(),
        figures: figures.collect(),
        reason: if refused.is_empty() {
            no_error(&[row])
        } else {
            Some(refused)
        },
    }
}

/// Frames in all; the sum of no floats is -0.
fn seen(frames: impl Iterator<Item = f64>) -> f64 {
    frames.sum::<f64>() + 0.0
}

/// A part of a scene, and its share of all.
type Shown = (Arc<CachedScene>, f64);

/// Points on a part of their scenes.
struct Cut {
    plan: Plan,
    point_frames: f64,
}

impl Cut {
    /// Of these points of a plan; none where a part would be much of a scene, or it cannot be read.
    fn new(plan: &Plan, left: &[usize], (part, hash): (f64, Hash)) -> Option<Self> {
        let mut scenes: Vec<(String, bool, Option<Shown>)> = Vec::new();
        let mut entries = Vec::new();
        let mut point_frames = 0.0;
        for i in left {
            let entry = plan.entries.get(*i)?;
            // Slots are the whole array's.
            let whole = entry.point.word("readout") == Some("chip");
            let digest = &entry.scene.digest;
            let found = scenes
                .iter()
                .find(|(known, all, _)| known == digest && *all == whole);
            let cut = if let Some((_, _, cut)) = found {
                cut.clone()
            } else {
                let cut = cut(&entry.scene, part, whole, hash).ok().flatten();
                scenes.push((digest.clone(), whole, cut.clone()));
                cut
            };
            let (scene, seen) = cut?;
            point_frames += seen * entry.scene.frames as f64;
            entries.push(Entry {
                id: identity(entry, &scene, &plan.study.settings),
                task: format!("{} {}", entry.task, scene.digest),
                scene,
                ..entry.clone()
            });
        }
        let mut study = plan.study.clone();
        study.settings = Settings {
            threshold_equivalent: false,
            tolerance: None,
            ..study.settings
        };
        let named = entries.len() as u64;
        Some(Self {
            plan: Plan {
                study,
                entries,
                named,
            },
            point_frames,
        })
    }
}

fn identity(entry: &Entry, scene: &CachedScene, settings: &Settings) -> String {
    let all = json!(["rung", entry.id, scene.digest, settings.measured()]);
    hex(&Sha256::digest(all.to_string().as_bytes())[..16])
}

/// The fewest frames of a part, and the fewest rows and columns.
const LEAST_FRAMES: u64 = 5;
const LEAST_SIDE: usize = 24;

/// A part of a scene, and its share of all; none where that is much. `whole`: all of the array.
fn cut(
    scene: &CachedScene,
    part: f64,
    whole: bool,
    hash: Hash,
) -> Result<Option<Shown>, SceneError> {
    let each = if whole { part } else { part.sqrt() };
    let all = scene.frames;
    let frames = ((each * all as f64).ceil() as u64)
        .max(LEAST_FRAMES)
        .min(all);
    let space = if whole {
        1.0
    } else {
        (part * all as f64 / frames as f64).min(1.0).sqrt()
    };
    let side = |length: usize| {
        let side = (space * length as f64).ceil() as usize;
        // An even number: patterns of sensors are 2x2.
        side.max(LEAST_SIDE).next_multiple_of(2).min(length)
    };
    let size = (side(scene.size.height), side(scene.size.width));
    let share = frames as f64 / all as f64 * (size.0 * size.1) as f64 / scene.size.pixels() as f64;
    if share > MUCH {
        return Ok(None);
    }
    let first = (hash.uniform() * (all - frames + 1) as f64) as u64;
    let cut = scene.cut(&Part {
        frames: first..first + frames,
        size,
    })?;
    Ok(Some((Arc::new(cut), share)))
}
