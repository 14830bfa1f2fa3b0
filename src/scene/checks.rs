//! Checks that all sources of frames share.

use std::{fs::File, io::BufReader, path::Path};

use super::{OpenOptions, SceneError};
use crate::{
    limit::{DRAWN_PIXELS, FRAMES, PIXELS},
    memory::{Budget, Need},
    plane::{Plane, Size},
};

/// Bytes of a pixel that are held while frames are taken: of the frame that is given and of the
/// one before it, whose memory is not free at once.
pub(super) const PIXEL_BYTES_HELD: u128 = 2 * PIXEL_BYTES;

/// Bytes of a pixel of a frame.
pub(super) const PIXEL_BYTES: u128 = 8;

/// The size of a frame, checked against the limits; errors name the file.
pub(super) fn checked_size(path: &Path, height: usize, width: usize) -> Result<Size, SceneError> {
    let size = Size::new(height, width);
    if height == 0 || width == 0 {
        return Err(SceneError::NoPixels {
            path: path.into(),
            size,
        });
    }
    if size.is_possible() {
        return Ok(size);
    }
    Err(SceneError::TooLarge {
        path: path.into(),
        size,
        most: PIXELS,
    })
}

/// Refuses frame number `index` where a scene may not have so many frames.
pub(super) fn check_number(path: &Path, index: u64) -> Result<(), SceneError> {
    if index < FRAMES {
        return Ok(());
    }
    Err(SceneError::TooManyFrames {
        path: path.into(),
        most: FRAMES,
    })
}

/// Refuses drawn scenes that are too large in all: few bytes of input, or none, can ask for any
/// number of frames.
pub(super) fn check_drawn(path: &Path, size: Size, frames: u64) -> Result<(), SceneError> {
    check_number(path, frames.saturating_sub(1))?;
    if u128::from(frames) * size.pixels() as u128 <= u128::from(DRAWN_PIXELS) {
        return Ok(());
    }
    Err(SceneError::TooLong {
        path: path.into(),
        frames,
        size,
        most: DRAWN_PIXELS,
    })
}

/// Frames that take so few bytes are read under any limit, so that whoever uses them can refuse
/// with the sum of all that it would hold, and the least that is enough.
const SMALL: u128 = 4 << 20;

/// What a program that reads frames may hold, if that is limited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct MemoryLimit(Option<Budget>);

impl MemoryLimit {
    /// The limit that the options give, or none.
    pub const fn new(options: OpenOptions) -> Self {
        Self(options.memory)
    }

    /// Refuses frames of which so many bytes are held while they are read.
    pub fn check(self, path: &Path, size: Size, bytes: u128) -> Result<(), SceneError> {
        let Some(budget) = self.0.filter(|_| bytes > SMALL) else {
            return Ok(());
        };
        let need = Need::new().and(format!("frames of {size} that are read"), bytes);
        let what = format!("{}: the scene alone", path.display());
        Ok(need.within(budget, &what, "scale the clip down first")?)
    }
}

/// A plane from numbers in row order; `None` when their count does not match the size.
pub(super) fn plane(size: Size, numbers: Vec<f64>) -> Option<Plane<f64>> {
    Plane::from_shape_vec(size.shape(), numbers).ok()
}

/// Opens a file for reading.
pub(super) fn open_file(path: &Path) -> Result<BufReader<File>, SceneError> {
    let file = File::open(path).map_err(|cause| SceneError::unreadable(path, cause))?;
    Ok(BufReader::with_capacity(1 << 16, file))
}

/// Length of what was opened, bytes, where it is a file: a pipe has none.
pub(super) fn known_length(file: &BufReader<File>) -> Option<u64> {
    let data = file.get_ref().metadata().ok();
    data.filter(std::fs::Metadata::is_file)
        .map(|data| data.len())
}

/// Length of a file, bytes.
#[cfg(feature = "mp4")]
pub(super) fn length(path: &Path, file: &BufReader<File>) -> Result<u64, SceneError> {
    let data = file.get_ref().metadata();
    data.map(|data| data.len())
        .map_err(|cause| SceneError::unreadable(path, cause))
}
