//! The search for the plan of fewest words.
//!
//! - [`register_count`]: the entry, [`Request::filter`](super::Request::filter), which searches with each
//!   number of registers; [`solve`]: the best plan that an effort finds with
//!   some of them.
//! - [`beam`]: beam search, from the goals back to the input.
//! - [`bound`]: lower bounds, and the exhaustive search; [`plan_table`]: plans from its table.
//! - [`memo`]: what the last searches have found.

mod beam;
pub mod bound;
pub(super) mod memo;
mod plan_table;
mod register_count;
pub(super) mod solve;
