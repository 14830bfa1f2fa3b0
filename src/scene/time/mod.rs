//! Scenes in time: which frames are shown, and frames between them.
//!
//! - [`frame_rate`]: rates, given or assumed.
//! - [`slice`]: which frames are asked for; [`sliced`]: a scene of those; [`part`]: the first frames of
//!   a scene, or those after them.
//! - [`resample`]: frames at another rate, evenly; [`upsample`]: more of them where light changes fast.

pub(super) mod frame_rate;
pub mod part;
pub mod resample;
pub(super) mod slice;
pub(super) mod sliced;
pub mod upsample;
