//! Computes the points of a plan on all cores, each point on one thread.

use std::{
    collections::HashMap,
    ops::ControlFlow,
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicBool, AtomicUsize, Ordering},
    },
    thread,
};

use super::{
    limits::Limits,
    measure::{described, measure, without_figures},
    memo::Shared,
};
use crate::{
    catch_panic,
    order::Order,
    study::sweep::{
        points::plan::{Entry, Plan},
        results::{
            damage::Damage,
            error::{Kept, StoreError},
            pilot_file,
            provenance::Provenance,
            record::{Record, is_failed},
            store::Store,
        },
        selection::search::{Chosen, Searched},
        tables::table::{self, Row},
    },
};

/// One part of a study, for one of several machines: the points whose number leaves `index`
/// when it is divided by `of`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// From 0.
    pub index: u64,
    /// How many shards there are.
    pub of: u64,
}

/// No shard.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("`{text}` is no shard")]
#[diagnostic(help("give i/n with i from 0 to n - 1, such as 0/4, 1/4, 2/4 and 3/4"))]
pub struct ShardError {
    /// What was given.
    pub text: String,
}

impl std::str::FromStr for Shard {
    type Err = ShardError;

    fn from_str(text: &str) -> Result<Self, ShardError> {
        let parts = text
            .split_once('/')
            .and_then(|(index, of)| Some((index.parse().ok()?, of.parse().ok()?)));
        match parts {
            Some((index, of)) if index < of => Ok(Self { index, of }),
            _ => Err(ShardError { text: text.into() }),
        }
    }
}

impl Shard {
    /// Whether a point is its.
    #[must_use]
    pub const fn has(self, point: u64) -> bool {
        point % self.of == self.index
    }
}

/// A plan, and how it is computed.
#[derive(Clone, Copy, Debug)]
pub struct Run<'a> {
    /// The points.
    pub plan: &'a Plan,
    /// Only those of one shard.
    pub shard: Option<Shard>,
    /// How many points at a time, each on one thread.
    pub jobs: usize,
    /// What each may take.
    pub limits: Limits<'a>,
}

/// What a run did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Did {
    /// Points that were computed now, those that failed among them.
    pub computed: usize,
    /// Points that were there already.
    pub found: usize,
    /// Points that failed now.
    pub failed: Vec<Failed>,
    /// Files of points that were damaged, and set aside.
    pub damaged: Vec<Damage>,
    /// What a search did.
    pub search: Option<Searched>,
    /// Pilots of plainer models that were measured now.
    pub pilots: usize,
    /// Their seconds, each on one thread.
    pub pilot_seconds: f64,
}

/// A point of which nothing came.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Failed {
    /// Its number.
    pub point: usize,
    /// Why.
    pub reason: String,
}

impl Run<'_> {
    /// Computes what is missing, what has failed before, and what is damaged. `begin` hears how
    /// many points that are, `done` of each.
    ///
    /// # Errors
    /// When the folder does not take a result; all that was finished before is kept.
    pub fn complete(
        &self,
        store: &Store,
        begin: impl FnOnce(u64),
        done: impl Fn() + Sync,
    ) -> Kept<Did> {
        self.complete_until(store, begin, || {
            done();
            ControlFlow::Continue(())
        })
    }

    /// As [`complete`](Self::complete); where `done` says so, no other point is begun.
    ///
    /// # Errors
    /// As [`complete`](Self::complete), and [`StoreError::Stopped`].
    pub fn complete_until(
        &self,
        store: &Store,
        begin: impl FnOnce(u64),
        done: impl Fn() -> ControlFlow<()> + Sync,
    ) -> Kept<Did> {
        let (plan, limits) = (self.plan, self.limits);
        self.complete_by(store, begin, done, |entry, shared| {
            measure(plan, entry, shared, limits)
        })
    }

    fn complete_by(
        &self,
        store: &Store,
        begin: impl FnOnce(u64),
        done: impl Fn() -> ControlFlow<()> + Sync,
        compute: impl Fn(&Entry, &Shared) -> Row + Sync,
    ) -> Kept<Did> {
        let held = store.held()?;
        store.set_aside(&held.damaged)?;
        let is_there = |entry: &Entry| held.records.get(&entry.id).is_some_and(Record::is_final);
        let mut mine = self.mine();
        let search = self.plan.study.sample.and_then(|sample| sample.search);
        let mut damaged = held.damaged;
        let goes_by_pilots = search.is_some() || self.plan.study.settings.tolerance.is_some();
        let pilots = if goes_by_pilots {
            let folder = store.pilots()?;
            let pilots = pilot_file::damaged(&folder)?;
            store.set_aside(&pilots)?;
            damaged.extend(pilots);
            Some(folder)
        } else {
            None
        };
        let searched = match search {
            Some(search) => {
                let searched = self.search(search, store, &done)?;
                mine.retain(|(point, _)| searched.points.contains(point));
                searched.keep_failed(self.plan, store, &held.records)?;
                searched
            }
            None => Chosen::default(),
        };
        let all = mine.len();
        let work: Vec<_> = mine
            .into_iter()
            .filter(|(_, entry)| !is_there(entry))
            .collect();
        let mut did = Did {
            computed: work.len(),
            found: all - work.len(),
            damaged,
            search: search.map(|_| searched.did),
            ..Did::default()
        };
        begin(work.len() as u64);
        let failed = Mutex::new(searched.failed);
        let provenance = Provenance::here();
        let shared = Shared::new(pilots);
        self.on_threads(work, &shared, |point, entry, shared| {
            store.begin(&entry.id)?;
            let row = self.computed(entry, || compute(entry, shared));
            if is_failed(&row) {
                let reason = table::cell(&row, "reason");
                let mut failed = failed.lock().unwrap_or_else(PoisonError::into_inner);
                failed.push(Failed { point, reason });
            }
            let provenance = provenance.clone();
            store.keep(&entry.id, &Record { row, provenance })?;
            shared.pilots_are_kept()?;
            match done() {
                ControlFlow::Continue(()) => Ok(()),
                ControlFlow::Break(()) => Err(StoreError::Stopped),
            }
        })?;
        did.failed = failed.into_inner().unwrap_or_else(PoisonError::into_inner);
        did.failed.order_by_key(|failed| failed.point);
        (did.pilots, did.pilot_seconds) = shared.pilot_cost();
        Ok(did)
    }

    /// The points of the shard, each with its number.
    pub(in crate::study::sweep) fn mine(&self) -> Vec<(usize, &Entry)> {
        let all = self.plan.entries.iter().enumerate();
        let mine = all.filter(|(index, _)| {
            let shard = self.shard;
            shard.is_none_or(|shard| shard.has(*index as u64))
        });
        mine.collect()
    }

    /// The row of a point, also where its computation panics.
    pub(in crate::study::sweep) fn computed(
        &self,
        entry: &Entry,
        measure: impl FnOnce() -> Row,
    ) -> Row {
        catch_panic::catch(measure).unwrap_or_else(|words| {
            let why = format!("its computation panicked, which is a defect of amacrine: {words}");
            without_figures(described(self.plan, entry), "failed", &why)
        })
    }

    /// Does something with each of these points, task by task; the first error ends it.
    pub(in crate::study::sweep) fn on_threads(
        &self,
        mut work: Vec<(usize, &Entry)>,
        shared: &Shared,
        each: impl Fn(usize, &Entry, &Shared) -> Kept<()> + Sync,
    ) -> Kept<()> {
        task_by_task(&mut work);
        let (next, stop) = (AtomicUsize::new(0), AtomicBool::new(false));
        let failed = Mutex::new(None);
        let worker = || {
            while !stop.load(Ordering::Relaxed) {
                let Some((point, entry)) = work.get(next.fetch_add(1, Ordering::Relaxed)) else {
                    return;
                };
                if let Err(error) = each(*point, entry, shared) {
                    stop.store(true, Ordering::Relaxed);
                    let mut failed = failed.lock().unwrap_or_else(PoisonError::into_inner);
                    failed.get_or_insert(error);
                }
            }
        };
        thread::scope(|scope| {
            for _ in 0..self.jobs.clamp(1, work.len().max(1)) {
                scope.spawn(|| alone(worker));
            }
        });
        match failed.into_inner().unwrap_or_else(PoisonError::into_inner) {
            Some(error) => Err(error),
            None => Ok(()),
        }
    }
}

/// Points of one task after each other: they share what they are measured against.
fn task_by_task(work: &mut [(usize, &Entry)]) {
    let mut first = HashMap::new();
    for (at, (_, entry)) in work.iter().enumerate() {
        first.entry(entry.task.clone()).or_insert(at);
    }
    work.order_by_key(|(_, entry)| first.get(&entry.task).copied());
}

/// Does work in a pool of one thread, so that what would spread over the cores does not.
pub(in crate::study::sweep) fn alone<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    match rayon::ThreadPoolBuilder::new().num_threads(1).build() {
        Ok(pool) => pool.install(work),
        // No thread can be had: then here.
        Err(_) => work(),
    }
}

#[cfg(test)]
impl<'a> Run<'a> {
    /// All points on so many threads, without limits.
    pub(in crate::study::sweep) fn unlimited(plan: &'a Plan, jobs: usize) -> Self {
        Self {
            plan,
            shard: None,
            jobs,
            limits: Limits {
                clock: &|| 0.0,
                seconds: None,
                bytes: None,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use std::{fs, path::Path, sync::Arc};

    use super::*;
    use crate::study::sweep::{Study, results::store};

    /// One of three points panics: it is a row, the others are done, and the next run mends it.
    #[test]
    fn a_point_that_panics_is_a_row_and_the_others_go_on() {
        let text = "scene = \"pattern:disc?width=16&height=12&frames=3&radius=3\"\nkernel = \"dvs\"\nthreshold = [10, 20, 30]\n[[side]]\nside = \"reference\"\n";
        let study = Study::parse("study.toml", text).unwrap();
        let plan = Plan::new(study, Path::new("")).unwrap();
        let run = Run::unlimited(&plan, 2);
        let folder = tempfile::tempdir().unwrap();
        let store = Store::open(folder.path(), &plan.manifest()).unwrap();
        let bad = &plan.entries[1].id;
        let compute = |entry: &Entry, shared: &Shared| {
            assert!(entry.id != *bad, "a defect");
            measure(&plan, entry, shared, run.limits)
        };
        let all = || ControlFlow::Continue(());
        let did = run.complete_by(&store, |_| {}, all, compute).unwrap();
        let [failed] = &*did.failed else {
            panic!("{:?}", did.failed);
        };
        assert_eq!((did.computed, failed.point), (3, 1));
        assert!(failed.reason.contains("panicked") && failed.reason.contains("a defect"));
        let tables = store.write_tables(false).unwrap();
        assert_eq!((tables.finished, tables.failed), (2, 1));
        let rows = store::read(folder.path()).unwrap().1;
        assert_eq!(table::cell(&rows[1], "outcome"), "failed");
        assert_eq!(table::cell(&rows[1], "threshold_on"), "20.0");
        // Now there is no room for it.
        let little = Run {
            limits: Limits {
                bytes: Some(1000),
                ..run.limits
            },
            ..run
        };
        let did = little.complete(&store, |_| {}, || {}).unwrap();
        assert!(did.failed[0].reason.contains("bytes") && did.failed[0].reason.contains("1000"));
        assert_eq!((did.computed, did.found), (1, 2));
        let did = run.complete(&store, |_| {}, || {}).unwrap();
        assert_eq!((did.computed, did.found), (1, 2));
        assert_eq!(store.write_tables(false).unwrap().finished, 3);
    }

    /// A scene that is read for each point is another by the second: that is no point with numbers
    /// of another scene.
    #[test]
    fn a_point_whose_scene_was_changed_is_failed() {
        let folder = tempfile::tempdir().unwrap();
        let clip = folder.path().join("clip");
        fs::create_dir(&clip).unwrap();
        let picture = |shift: usize| {
            let mut picture = b"P5 16 12 255\n".to_vec();
            picture.extend((0..16 * 12).map(|at| (31 * (at + shift) % 251) as u8));
            picture
        };
        for frame in 0..6 {
            fs::write(clip.join(format!("{frame}.pgm")), picture(frame)).unwrap();
        }
        let text = "scene = \"clip\"\nkernel = \"dvs\"\nthreshold = [10, 20]\n[[side]]\nside = \"reference\"\n";
        let study = Study::parse("study.toml", text).unwrap();
        let mut plan = Plan::new(study, folder.path()).unwrap();
        let scene = Arc::new(plan.entries[0].scene.as_if_too_long());
        for entry in &mut plan.entries {
            entry.scene = Arc::clone(&scene);
        }
        let run = Run::unlimited(&plan, 1);
        let store = Store::open(&folder.path().join("out"), &plan.manifest()).unwrap();
        let replaced = clip.join("3.pgm");
        let replace = || {
            let other = folder.path().join("other");
            fs::write(&other, picture(100)).unwrap();
            fs::rename(&other, &replaced).unwrap();
            ControlFlow::Continue(())
        };
        let did = run.complete_until(&store, |_| {}, replace).unwrap();
        let [failed] = &*did.failed else {
            panic!("{:?}", did.failed);
        };
        let told = format!("the scene {} changed", replaced.display());
        assert!(failed.reason.contains(&told), "{}", failed.reason);
        assert_eq!((did.computed, failed.point), (2, 1));
        let held = store.held().unwrap();
        let row = &held.records[&plan.entries[1].id].row;
        assert_eq!(table::cell(row, "outcome"), "failed");
        assert_eq!(table::cell(row, "events"), "");
        // It is computed again: the next run opens the scene anew.
        assert!(!held.records[&plan.entries[1].id].is_final());
        fs::remove_dir_all(&clip).unwrap();
        let did = run.complete(&store, |_| {}, || {}).unwrap();
        assert_eq!((did.computed, did.found, did.failed.len()), (1, 1, 1));
    }

    /// What is stopped keeps what is finished, and the next run does the rest.
    #[test]
    fn a_run_that_is_stopped_goes_on() {
        let text = "scene = \"pattern:disc?width=16&height=12&frames=3&radius=3\"\nkernel = \"dvs\"\nthreshold = [10, 20, 30]\n[[side]]\nside = \"reference\"\n";
        let study = Study::parse("study.toml", text).unwrap();
        let plan = Plan::new(study, Path::new("")).unwrap();
        let run = Run::unlimited(&plan, 1);
        let folder = tempfile::tempdir().unwrap();
        let store = Store::open(folder.path(), &plan.manifest()).unwrap();
        let stopped = run.complete_until(&store, |_| {}, || ControlFlow::Break(()));
        assert!(matches!(stopped, Err(StoreError::Stopped)), "{stopped:?}");
        let did = run.complete(&store, |_| {}, || {}).unwrap();
        assert_eq!((did.computed, did.found), (2, 1));
    }

    #[test]
    fn shards_take_every_point_once() {
        for of in 1..6 {
            for point in 0..50 {
                let takers = (0..of).filter(|index| Shard { index: *index, of }.has(point));
                assert_eq!(takers.count(), 1);
            }
        }
        assert_eq!("1/4".parse(), Ok(Shard { index: 1, of: 4 }));
        for wrong in ["4/4", "0/0", "1", "-1/4", "1/4/2", "a/b", ""] {
            assert!(wrong.parse::<Shard>().is_err(), "{wrong}");
        }
    }
}
