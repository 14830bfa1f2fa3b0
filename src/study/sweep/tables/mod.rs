//! Results as tables.
//!
//! - [`table`]: the one schema of all formats; [`column`]: the columns that every study has.
//! - [`parquet`]: as Parquet.
//! - [`report`]: which sensors no other beats; [`task_name`]: what their tasks are called;
//!   [`left_out`]: what plainer models leave out.

pub(super) mod column;
pub mod left_out;
#[cfg(feature = "parquet")]
pub(super) mod parquet;
pub mod report;
pub mod table;
pub mod task_name;
