//! Computes the points of a plan on all cores, each point on one thread.

use std::{
    collections::HashMap,
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicBool, AtomicUsize, Ordering},
    },
    thread,
};

use super::{
    error::StoreError,
    measure::{Clock, measure},
    plan::{Entry, Plan},
    shared::Shared,
    store::Store,
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

/// What a run did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Did {
    /// Points that were computed now.
    pub computed: usize,
    /// Points that were there already.
    pub found: usize,
}

/// Computes what is missing of a plan, or of one shard of it, on so many threads. `begin`
/// hears how many points that are, `done` of each.
///
/// # Errors
/// When the folder does not take a result; all that was finished before is kept.
pub fn run(
    plan: &Plan,
    store: &Store,
    shard: Option<Shard>,
    jobs: usize,
    clock: Clock<'_>,
    begin: impl FnOnce(u64),
    done: impl Fn() + Sync,
) -> Result<Did, StoreError> {
    let finished = store.finished()?;
    let mine = (0..).zip(&plan.entries);
    let mine = mine.filter(|(index, _)| shard.is_none_or(|shard| shard.has(*index)));
    let mine: Vec<&Entry> = mine.map(|(_, entry)| entry).collect();
    let mut work: Vec<&Entry> = mine
        .iter()
        .copied()
        .filter(|entry| !finished.contains_key(&entry.id))
        .collect();
    let did = Did {
        computed: work.len(),
        found: mine.len() - work.len(),
    };
    begin(work.len() as u64);
    task_by_task(&mut work);

    let (next, stop) = (AtomicUsize::new(0), AtomicBool::new(false));
    let failed = Mutex::new(None);
    let shared = Shared::default();
    let one = |entry: &Entry| -> Result<(), StoreError> {
        store.begin(&entry.id)?;
        let row = measure(plan, entry, &shared, clock);
        store.keep(&entry.id, &row)
    };
    let worker = || {
        while !stop.load(Ordering::Relaxed) {
            let Some(entry) = work.get(next.fetch_add(1, Ordering::Relaxed)) else {
                return;
            };
            match one(entry) {
                Ok(()) => done(),
                Err(error) => {
                    stop.store(true, Ordering::Relaxed);
                    let mut failed = failed.lock().unwrap_or_else(PoisonError::into_inner);
                    failed.get_or_insert(error);
                }
            }
        }
    };
    thread::scope(|scope| {
        for _ in 0..jobs.clamp(1, work.len().max(1)) {
            scope.spawn(|| alone(worker));
        }
    });
    match failed.into_inner().unwrap_or_else(PoisonError::into_inner) {
        Some(error) => Err(error),
        None => Ok(did),
    }
}

/// Points of one task after each other: they share what they are measured against.
fn task_by_task(work: &mut [&Entry]) {
    let mut first = HashMap::new();
    for (at, entry) in work.iter().enumerate() {
        first.entry(entry.task.clone()).or_insert(at);
    }
    work.sort_by_key(|entry| first.get(&entry.task).copied());
}

/// Does work in a pool of one thread, so that what would spread over the cores does not.
fn alone(work: impl FnOnce() + Send) {
    match rayon::ThreadPoolBuilder::new().num_threads(1).build() {
        Ok(pool) => pool.install(work),
        // No thread can be had: then here.
        Err(_) => work(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
