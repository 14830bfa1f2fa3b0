//! Events on silicon: filters tried on moving light, where it is known with what a result is compared.
//!
//! - [`trial`]: a filter, tried as the chip errs; [`f1_score`]: how many events it keeps.
//! - [`dead_leaves`]: the light that it is tried on.
//! - [`selection`]: the plan that keeps most.

pub mod dead_leaves;
pub(super) mod f1_score;
mod selection;
pub(super) mod trial;
