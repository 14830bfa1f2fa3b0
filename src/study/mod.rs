//! Studies: many sensors on one scene, and what each loses.

pub mod design;
pub mod front;
pub mod quantisation;
pub mod sweep;
pub mod waterfall;
