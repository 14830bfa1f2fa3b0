//! What is seen of a scene while it is watched, and what is not shown as it is.
//!
//! - [`observed`]: a scene, watched; [`cut`]: its cuts; [`repeated_frames`]: frames that are shown again.
//! - [`aliasing`]: what a pattern draws too fine or too fast; [`playback`]: how a player would show a
//!   clip.
//! - [`seen_light`]: what studies tell of the light.

pub(super) mod aliasing;
pub(super) mod cut;
pub(super) mod observed;
pub(super) mod playback;
pub(super) mod repeated_frames;
pub(super) mod seen_light;
