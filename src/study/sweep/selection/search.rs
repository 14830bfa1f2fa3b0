//! `sample = { method = "search" }`: successive halving. All candidates are tried on a small part of
//! the scene, the best of them on a larger part, and what is left on the whole scene.
//!
//! ```text
//! candidates ─► a 32nd of the scene ─ survivors ─► an eighth ─ survivors ─► the whole, as any point
//! ```
//!
//! What is tried on a part of a scene (`cut`) is measured as any point is, and kept by content in
//! `pilots/` of the folder: a search that is gone on with chooses as before. A rung leaves out only
//! what it has ranked (`contenders`): where no rung saves anything, all points are computed.
//! Jamieson & Talwalkar 2016 for one objective; here who survives is who is on the front of error
//! and cost (`survivors`).

use std::{
    collections::{HashMap, HashSet},
    ops::ControlFlow,
    sync::{Mutex, PoisonError},
};

use super::{contenders::Contenders, cut::Cut, survivors::survivors};
use crate::{
    order::Order,
    rng::Hash,
    study::{
        front::Cost,
        sweep::{
            measurement::{
                measure::{described, measure, without_figures},
                memo::Shared,
                run::{Failed, Run},
            },
            points::{
                plan::{Entry, Plan},
                sample::Search,
            },
            results::{
                error::{Kept, StoreError},
                pilot_file::PilotFile,
                provenance::Provenance,
                record::{Record, is_failed},
                store::Store,
            },
            study_file::study::COSTS,
            tables::{
                report::no_error,
                table::{self, Row},
            },
        },
    },
};

/// What a rung did.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Rung {
    /// Points that were tried.
    pub points: usize,
    /// Of these, those that were tried now; the others were known.
    pub tried: usize,
    /// Of these, those that saw the whole of their scene, of which a part would be too much.
    pub whole: usize,
    /// Of these, those that it could not rank: on a part nothing came of them.
    pub unranked: usize,
    /// What they saw, in frames of the whole sensor; what an earlier rung saw counts there.
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
    /// Points that went no further, with the reason: they cannot be, have no such cost, or nothing
    /// comes of them on the whole of their scene.
    pub nothing: Vec<Failed>,
    /// Points that were left out behind all others since nothing came of them on parts of their
    /// scene, with the reason of the last part.
    pub unranked: Vec<Failed>,
    /// Whether no rung chose, since parts of the scenes would be too much of them: all points are
    /// computed.
    pub computed_all: bool,
}

/// What a search comes to.
#[derive(Debug, Default)]
pub(in crate::study::sweep) struct Chosen {
    /// Numbers of the points that are to be computed on the whole scene.
    pub points: HashSet<usize>,
    pub did: Searched,
    /// Points that were given up in a rung.
    pub failed: Vec<Failed>,
}

/// What the reason of a point begins with that was given up in a rung.
const ON_A_PART: &str = "on a part of the scene: ";

/// The same where its rung looked at the whole of its scene.
const ON_THE_WHOLE: &str = "in a rung of the search: ";

/// Which of both.
const fn in_a_rung(on_the_whole: bool) -> &'static str {
    if on_the_whole {
        ON_THE_WHOLE
    } else {
        ON_A_PART
    }
}

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
                let reason = table::cell(&held.row, "reason");
                let mut begins = [ON_A_PART, ON_THE_WHOLE].into_iter();
                is_failed(&held.row) && begins.any(|begin| reason.starts_with(begin))
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

/// A cost that each sensor has that watched its scene.
const WATCHED: &str = "seconds_per_frame";

impl Run<'_> {
    /// Tries candidates rung by rung; where `done` says so, no other is begun.
    pub(in crate::study::sweep) fn search(
        &self,
        search: Search,
        store: &Store,
        done: &(impl Fn() -> ControlFlow<()> + Sync),
    ) -> Kept<Chosen> {
        let plan = self.plan;
        let all = plan.entries.len();
        let finish = ((search.finish * all as f64).ceil() as usize).max(FEWEST);
        let mut contenders = Contenders::new(all);
        let mut looked_at = HashSet::new();
        let mut failed = Vec::new();
        let mut did = Searched {
            of: plan.entries.iter().map(|e| e.scene.frames as f64).sum(),
            ..Searched::default()
        };
        for (number, (part, share)) in (0..).zip(RUNGS) {
            let quota = ((share * all as f64).ceil() as usize).max(finish);
            contenders.cut_ranked(quota);
            if contenders.points().len() <= finish {
                break;
            }
            let hash = Hash::new(search.seed).with(number);
            let Some(rung) = Cut::new(plan, contenders.points(), (part, hash))? else {
                continue;
            };
            let tried = self.try_rung(&rung, search, store, done)?;
            did.rungs.push(Rung {
                point_frames: seen(
                    rung.looks().filter_map(|(id, frames)| {
                        looked_at.insert(id.to_owned()).then_some(frames)
                    }),
                ),
                ..tried.rung
            });
            let numbered = |list: Vec<(usize, String)>| {
                let of = |(i, reason)| {
                    Some(Failed {
                        point: *contenders.points().get(i)?,
                        reason,
                    })
                };
                list.into_iter().filter_map(of).collect::<Vec<_>>()
            };
            did.nothing.extend(numbered(tried.nothing));
            failed.extend(numbered(tried.failed));
            contenders.put_in_order(&tried.ranked, tried.unranked, hash);
        }
        did.nothing.order_by_key(|nothing| nothing.point);
        did.computed_all = !contenders.are_tried() && all > finish;
        let left;
        (left, did.unranked) = contenders.finish(finish);
        did.rungs.push(Rung {
            points: left.len(),
            tried: 0,
            whole: left.len(),
            unranked: 0,
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
        done: &(impl Fn() -> ControlFlow<()> + Sync),
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
        let made = Mutex::new(HashMap::new());
        run.on_threads(work, &Shared::new(None), |i, entry, shared| {
            let row = run.computed(entry, || measure(run.plan, entry, shared, run.limits));
            if is_failed(&row) {
                let begin = in_a_rung(cut.is_whole(i));
                let reason = format!("{begin}{}", table::cell(&row, "reason"));
                let mut failed = failed.lock().unwrap_or_else(PoisonError::into_inner);
                failed.push((i, reason));
            } else {
                let file = tried_file(&entry.id, &row);
                file.write(&folder)?;
                let mut made = made.lock().unwrap_or_else(PoisonError::into_inner);
                made.insert(i, file);
            }
            match done() {
                ControlFlow::Continue(()) => Ok(()),
                ControlFlow::Break(()) => Err(StoreError::Stopped),
            }
        })?;
        let mut failed = failed.into_inner().unwrap_or_else(PoisonError::into_inner);
        failed.order_by_key(|(i, _)| *i);
        let mut made = made.into_inner().unwrap_or_else(PoisonError::into_inner);
        let mut costs = Vec::new();
        let mut numbers = Vec::new();
        let (mut nothing, mut unranked) = (Vec::new(), Vec::new());
        for (i, entry) in cut.plan.entries.iter().enumerate() {
            let file = made.remove(&i).or_else(|| known(entry));
            let Some(PilotFile {
                figures, reason, ..
            }) = file
            else {
                continue;
            };
            let figure = |column: &str| figures.get(column).copied();
            let cost = figure(search.cost);
            if let (Some(y), Some(x)) = (figure("error"), cost) {
                let x = x * cut.counted_up(i, search.cost);
                costs.push(Cost { x, y });
                numbers.push(i);
                continue;
            }
            // What cannot be has not been watched; that, and which costs a sensor has, is the same
            // on any scene.
            let hangs_on_the_part = figures.contains_key(WATCHED) && cost.is_some();
            let reason = reason.unwrap_or_else(|| format!("it has no {}", search.cost));
            let told = (i, format!("{}{reason}", in_a_rung(cut.is_whole(i))));
            if hangs_on_the_part && !cut.is_whole(i) {
                unranked.push(told);
            } else {
                nothing.push(told);
            }
        }
        let ranked = survivors(&costs, costs.len()).into_iter();
        Ok(Tried {
            ranked: ranked.filter_map(|i| numbers.get(i).copied()).collect(),
            rung: Rung {
                points: cut.plan.entries.len(),
                tried,
                whole: cut.whole(),
                unranked: unranked.len(),
                point_frames: 0.0,
            },
            nothing,
            unranked,
            failed,
        })
    }
}

/// What came of a rung; points are counted within it.
struct Tried {
    /// The best first.
    ranked: Vec<usize>,
    rung: Rung,
    /// Points of which nothing comes on any scene or on the whole of theirs, and why.
    nothing: Vec<(usize, String)>,
    /// Points of which nothing came on a part, and why.
    unranked: Vec<(usize, String)>,
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

#[cfg(test)]
mod tests {
    use std::{fs, path::Path};

    use super::*;
    use crate::study::sweep::Study;

    const STUDY: &str = "scene = \"pattern:noise?width=56&height=48&frames=36&fps=100&speed=40\"\nkernel = \"dvs\"\nthreshold = [8, 16, 24, 32]\nthreshold-equivalent = false\nmetrics = \"f1\"\n";

    const SEARCH: &str = "sample = { method = \"search\", points = 100, cost = \"bits\" }\n[[side]]\nside = \"reference\"\nformat = [\"f64\", \"f32\", \"f16\", \"q8.8\"]\n";

    fn plan(text: &str) -> Plan {
        let study = Study::parse("study.toml", text).unwrap();
        Plan::new(study, Path::new("")).unwrap()
    }

    /// No other point is begun, what was tried is kept, and the next run tries the rest.
    #[test]
    fn a_search_that_is_stopped_in_a_rung_goes_on() {
        let plan = plan(&format!("{STUDY}{SEARCH}"));
        let run = Run::unlimited(&plan, 1);
        let folder = tempfile::tempdir().unwrap();
        let store = Store::open(folder.path(), &plan.manifest()).unwrap();
        let begin = |_| panic!("a stopped search computes points");
        let stopped = run.complete_until(&store, begin, || ControlFlow::Break(()));
        assert!(matches!(stopped, Err(StoreError::Stopped)), "{stopped:?}");
        let tried = fs::read_dir(folder.path().join("pilots")).unwrap().count();
        assert_eq!(tried, 1);
        let searched = run.complete(&store, |_| {}, || {}).unwrap().search.unwrap();
        assert_eq!(
            (searched.rungs[0].points, searched.rungs[0].tried),
            (16, 15)
        );
    }

    /// As a disk that has no room for it: an error, as of a point that cannot be kept.
    #[test]
    fn what_cannot_be_kept_of_a_pilot_is_told() {
        let auto =
            "fidelity = \"auto\"\n[[side]]\nside = \"reference\"\nformat = [\"f64\", \"f32\"]\n";
        for text in [SEARCH, auto] {
            let plan = plan(&format!("{STUDY}{text}"));
            let run = Run::unlimited(&plan, 1);
            let folder = tempfile::tempdir().unwrap();
            let store = Store::open(folder.path(), &plan.manifest()).unwrap();
            let pilots = folder.path().join("pilots");
            let spoil = || {
                if pilots.is_dir() {
                    fs::remove_dir_all(&pilots).unwrap();
                    fs::write(&pilots, "").unwrap();
                }
            };
            // A search has tried a point by then.
            let told = run.complete(&store, |_| spoil(), spoil);
            let Err(StoreError::Save { path, .. }) = &told else {
                panic!("{told:?}");
            };
            assert!(path.starts_with(&pilots), "{}", path.display());
        }
    }
}
