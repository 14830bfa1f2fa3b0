//! Checks that every source of light shares.

use std::{fs::File, io::BufReader, path::Path};

use super::SceneError;
use crate::plane::{Plane, Size};

/// The most pixels that a frame may have: far above any sensor, far below memory.
const MOST_PIXELS: usize = 1 << 26;

/// A size that a sensor can watch, or an error that names the file.
pub(super) fn checked_size(path: &Path, height: usize, width: usize) -> Result<Size, SceneError> {
    let size = Size::new(height, width);
    if height == 0 || width == 0 {
        return Err(SceneError::NoPixels {
            path: path.into(),
            size,
        });
    }
    match height.checked_mul(width) {
        Some(pixels) if pixels <= MOST_PIXELS => Ok(size),
        _ => Err(SceneError::TooLarge {
            path: path.into(),
            size,
            most: MOST_PIXELS,
        }),
    }
}

/// A plane from numbers in row order; `None` when their count is not the size's.
pub(super) fn plane(size: Size, numbers: Vec<f64>) -> Option<Plane<f64>> {
    Plane::from_shape_vec(size.shape(), numbers).ok()
}

/// Opens a file for reading.
pub(super) fn open_file(path: &Path) -> Result<BufReader<File>, SceneError> {
    let file = File::open(path).map_err(|cause| SceneError::unreadable(path, cause))?;
    Ok(BufReader::with_capacity(1 << 16, file))
}
