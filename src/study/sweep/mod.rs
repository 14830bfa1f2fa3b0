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

mod build;
mod entry;
mod error;
mod footage;
pub mod grid;
pub mod key;
mod measure;
#[cfg(feature = "parquet")]
mod parquet;
pub mod plan;
pub mod point;
mod read;
pub mod report;
pub mod run;
pub mod sample;
pub mod schema;
mod sensor;
mod shared;
mod sides;
pub mod store;
pub mod study;
pub mod table;
pub mod value;

pub use error::StoreError;
pub use measure::Clock;
pub use plan::Plan;
pub use report::Report;
pub use run::{Shard, run};
pub use store::Store;
pub use study::Study;

/// The version of the results: of what is measured and how. It is part of every identity.
pub const SCHEMA: u32 = 1;

/// The version of the numbers: raised whenever the same input gives other events, counts,
/// voxels, programs or levels. `tests/same_bits.rs` holds hashes of them.
pub const NUMERICS: u32 = 1;
