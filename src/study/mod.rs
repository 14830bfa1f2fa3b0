//! Studies: many sensors on one scene, and what each loses.

pub mod all_events;
pub mod balance;
pub mod cells;
pub mod comparison;
pub mod defaults;
pub mod design;
pub mod equivalent;
mod error;
pub mod execution;
pub mod expanded;
pub mod exploration;
pub mod feasibility;
pub mod front;
pub mod joint;
pub mod pilot;
pub mod quantisation;
pub mod quantised;
pub mod rate;
pub mod remade;
pub mod report;
pub mod run_guard;
pub mod saturation;
pub mod spread;
mod stores;
pub mod sweep;
pub mod together;
pub mod trade;
pub mod waterfall;
mod with_light;

pub use error::StudyError;
pub use with_light::WithLight;
