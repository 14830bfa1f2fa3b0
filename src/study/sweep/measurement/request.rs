//! What is asked of a sweep, the same on the command line and in Python: which points of a study,
//! and what they may take.

use std::{ops::ControlFlow, path::Path};

use super::{
    limits::{Clock, Limits},
    run::{Did, Run, Shard},
};
use crate::{
    config::Faults,
    memory::{Budget, Need, TooMuch},
    study::sweep::{
        points::plan::Plan,
        results::{
            error::Kept,
            store::{Store, Tables},
        },
        study_file::study::Study,
    },
};

/// What is asked.
#[derive(Clone, Copy)]
pub struct Request<'a> {
    /// Only the points of one shard.
    pub shard: Option<Shard>,
    /// How many points at a time, each on one thread.
    pub jobs: usize,
    /// Seconds for a sensor to watch its scene; what takes longer is given up.
    pub seconds: Option<f64>,
    /// What scenes and points may hold, all together.
    pub budget: Budget,
    /// The present time.
    pub clock: Clock<'a>,
}

/// Why a sweep cannot begin.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum RequestError {
    /// A search compares all points with each other.
    #[error("--shard of a search, whose points are chosen by comparing all of them")]
    #[diagnostic(help("leave --shard out, or sweep the whole grid on several machines"))]
    Shard,
    /// The study, or something that it names.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Study(#[from] Faults),
    /// Its scenes do not fit.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Memory(#[from] TooMuch),
}

/// What came of a sweep.
#[derive(Debug)]
pub struct Swept {
    /// What this run did.
    pub did: Did,
    /// What the tables hold now, and warn of.
    pub tables: Tables,
}

impl Request<'_> {
    /// Opens all that a study names, files in `folder`.
    ///
    /// # Errors
    /// As [`Plan::new`], and when one shard of a search is asked for.
    pub fn plan(&self, study: Study, folder: &Path) -> Result<Plan, RequestError> {
        let search = study.sample.is_some_and(|sample| sample.search.is_some());
        if search && self.shard.is_some() {
            return Err(RequestError::Shard);
        }
        Ok(Plan::new(study, folder)?)
    }

    /// How a plan is computed: points share what its scenes leave of the memory.
    ///
    /// # Errors
    /// When they leave nothing.
    pub fn run<'a>(&'a self, plan: &'a Plan) -> Result<Run<'a>, RequestError> {
        let need = Need::new().and("scenes that are kept", plan.held());
        need.within(self.budget, "a sweep", "take smaller scenes, or fewer")?;
        Ok(Run {
            plan,
            shard: self.shard,
            jobs: self.jobs,
            limits: Limits {
                clock: self.clock,
                seconds: self.seconds,
                bytes: Some(need.left(self.budget) / self.jobs.max(1) as u64),
            },
        })
    }
}

impl Run<'_> {
    /// Makes a folder of results, or goes on with it, and writes its tables; `begin` and `done` as
    /// of [`complete_until`](Run::complete_until).
    ///
    /// # Errors
    /// As [`Store::open`] and [`complete_until`](Run::complete_until).
    pub fn sweep(
        &self,
        output: &Path,
        parquet: bool,
        begin: impl FnOnce(u64),
        done: impl Fn() -> ControlFlow<()> + Sync,
    ) -> Kept<Swept> {
        let store = Store::open(output, &self.plan.manifest())?;
        let did = self.complete_until(&store, begin, done)?;
        let tables = store.write_tables(parquet)?;
        Ok(Swept { did, tables })
    }
}
