//! Scenes in memory, to be shown more than once.
//!
//! - [`held`]: frames as they are; [`kept`]: a scene read once, as small as it can be.

pub mod held;
pub mod kept;
