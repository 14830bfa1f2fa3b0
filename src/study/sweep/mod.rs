//! Sweeps: many points of a study, each computed once, wherever and however often it is asked
//! for.
//!
//! ```text
//! study.toml ─ [study] axes ─┬─ [grid]   every combination ─┐
//!                            └─ [sample] drawn from it ─────┴─ [plan] points with identities
//!                                                                      │
//!            report ─ front ─ tables ─ [store] one file a point ─ [run] measured on all cores
//! ```
//!
//! - `study_file`: the study file, its keys, and what the command line sets of it.
//! - `points`: points, the grid, samples of it, the plan.
//! - `scene`, `sensor`: what the points watch, and what watches.
//! - `measurement`: the points of a plan, measured.
//! - `selection`: searches of many points for the best.
//! - `results`: the folder of results.
//! - `tables`: results as tables, and the report.
//!
//! `docs/sweeps.md` has a worked example, every key and every column.

mod measurement;
mod points;
mod results;
mod scene;
mod selection;
mod sensor;
mod study_file;
mod tables;

pub use self::{
    measurement::{
        limits::{self, Clock, Limits},
        request::{self, Request},
        run::{self, Run, Shard},
    },
    points::{
        grid,
        plan::{self, Plan},
        point, sample, thresholds, value,
    },
    results::{
        damage::{self, Damage},
        error::StoreError,
        manifest::{self, Manifest},
        merge::{self, merge},
        provenance::{self, NUMERICS, Provenance, SCHEMA},
        record,
        store::{self, Store},
        verify,
    },
    selection::{
        ask::{self, Asked},
        search, survivors,
    },
    study_file::{
        key,
        overrides::{self, Override},
        schema,
        study::{self, Study},
    },
    tables::{
        left_out,
        report::{self, Report},
        table, task_name,
    },
};
