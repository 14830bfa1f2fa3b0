//! From samples to light.
//!
//! - [`image`]: the light of a frame, held as its samples are.
//! - [`coding`]: what samples mean, and who says so; [`conversion`]: range, scale and transfer, applied.
//! - [`pixel`]: pixels of decoded pictures, colour to gray.

pub(super) mod coding;
pub(super) mod conversion;
pub(super) mod image;
pub(super) mod pixel;
