//! Studies: many sensors on one scene, and what each loses.

pub mod plan;
pub mod quantisation;
