//! H.264 in mp4: the boxes and tables are read here, the video by `rust_h264`; its luma.
//!
//! Nothing that the file says about itself is believed before it is held against the bytes that
//! are there: every box lies in its parent, every table in its box, and no loop is longer than
//! the file. [`limits`] has the bounds that do not follow from the file's length.

#[cfg(feature = "mp4")]
mod boxes;
#[cfg(feature = "mp4")]
mod clip;
#[cfg(feature = "mp4")]
mod colour;
#[cfg(feature = "mp4")]
mod edit;
#[cfg(feature = "mp4")]
mod fragment;
#[cfg(feature = "mp4")]
mod parameters;
#[cfg(feature = "mp4")]
mod table;
#[cfg(feature = "mp4")]
mod track;
#[cfg(feature = "mp4")]
mod turn;

use std::path::Path;

use crate::scene::{
    error::SceneError, frame::Scene, light::conversion::Source, options::OpenOptions,
};

#[cfg(not(feature = "mp4"))]
pub(in crate::scene) fn open(
    path: &Path,
    _options: OpenOptions,
) -> Result<(Box<dyn Scene>, Source), SceneError> {
    Err(SceneError::NoMp4 { path: path.into() })
}

#[cfg(feature = "mp4")]
pub(in crate::scene) fn open(
    path: &Path,
    options: OpenOptions,
) -> Result<(Box<dyn Scene>, Source), SceneError> {
    let clip = clip::H264::new(path, options)?;
    let (source, turn) = (clip.source(), clip.turn());
    Ok((turn::Turned::scene(clip, turn), source))
}
