//! Studies: many sensors on one scene, and what each loses.

pub mod design;
pub mod quantisation;
pub mod waterfall;
