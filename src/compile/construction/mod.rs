//! Plans that are built forwards, from the input to the kernel.
//!
//! - [`walk`]: a running sum over the places of a kernel, in the order of a [`route`];
//!   [`border_safe`]: one that is right up to the border; [`plan_builder`]: what
//!   these and tours are built with.
//! - [`scale`]: a single weight; [`separable`]: one filter after the other.
//! - [`tour`]: a running sum that stops at few places, with copies of the input.
//! - [`naive_cost`]: no plan, but the number of words of the plainest program.

pub(super) mod border_safe;
pub(super) mod naive_cost;
mod plan_builder;
mod route;
pub(super) mod scale;
pub(super) mod separable;
pub(super) mod tour;
pub(super) mod walk;
