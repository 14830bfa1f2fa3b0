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
//! `docs/sweeps.md` has a worked example, every key and every column.

pub mod ask;
mod build;
mod cached_scene;
mod column;
mod contenders;
mod cut;
pub mod damage;
mod difference;
mod drive;
mod error;
mod fidelity;
pub mod grid;
pub mod key;
pub mod left_out;
mod level_program;
pub mod limits;
pub mod manifest;
mod measure;
pub mod merge;
pub mod overrides;
#[cfg(feature = "parquet")]
mod parquet;
mod pilot_file;
pub mod plan;
pub mod point;
pub mod provenance;
mod read;
pub mod record;
mod refusal;
mod regular;
pub mod report;
pub mod request;
pub mod run;
pub mod sample;
pub mod schema;
mod seal;
pub mod search;
mod seen;
mod sensor;
mod shared;
mod sides;
mod stamp;
mod stated;
pub mod store;
pub mod study;
pub mod survivors;
pub mod table;
pub mod task_name;
pub mod thresholds;
mod truth;
pub mod value;
pub mod verify;

pub use ask::Asked;
pub use damage::Damage;
pub use error::StoreError;
pub use limits::{Clock, Limits};
pub use manifest::Manifest;
pub use merge::merge;
pub use overrides::Override;
pub use plan::Plan;
pub use provenance::{NUMERICS, Provenance, SCHEMA};
pub use report::Report;
pub use request::Request;
pub use run::{Run, Shard};
pub use store::Store;
pub use study::Study;
