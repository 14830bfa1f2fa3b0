//! Checks of the signals given to a grid.

use super::{error::MeshError, float::Float};
use crate::plane::{Plane, Size};

/// Refuses what is no length of time, in seconds.
pub(super) fn check_time(what: &'static str, value: f64) -> Result<(), MeshError> {
    if value >= 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(MeshError::Time { what, value })
    }
}

/// Refuses what a sheet of this size cannot be moved on with: the signal that it sees `seconds`
/// after the one before.
pub(super) fn check_next<T: Float>(
    signal: &Plane<T>,
    want: Size,
    seconds: f64,
) -> Result<(), MeshError> {
    check_time("time between two frames", seconds)?;
    let got = Size::of(signal);
    if got != want {
        return Err(MeshError::Size { got, want });
    }
    checked_range(signal).map(|_| ())
}

/// The smallest and the largest value of a plane.
///
/// # Errors
/// When a pixel is not finite or beyond [`Float::MOST_SIGNAL`].
pub(super) fn checked_range<T: Float>(plane: &Plane<T>) -> Result<(T, T), MeshError> {
    let most = T::nearest(T::MOST_SIGNAL);
    let fault = || {
        let usable = |value: T| value >= -most && value <= most;
        let ((y, x), value) = plane.indexed_iter().find(|(_, value)| !usable(**value))?;
        Some(MeshError::Signal {
            y,
            x,
            value: value.to_f64(),
            most: T::MOST_SIGNAL,
        })
    };
    let (low, high) = match plane.as_slice() {
        Some(values) => extremes(values, most),
        None => extremes(&plane.iter().copied().collect::<Vec<_>>(), most),
    };
    // A NaN is never within the range.
    if low >= -most && high <= most {
        return Ok((low, high));
    }
    fault().map_or(Ok((low, high)), Err)
}

/// The smallest and the largest of some numbers; beyond `most` if one of them is NaN.
#[multiversion::multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn extremes<T: Float>(values: &[T], most: T) -> (T, T) {
    const LANES: usize = 16;
    let first = values.first().copied().unwrap_or(most);
    let (mut low, mut high) = ([first; LANES], [first; LANES]);
    let mut usable = [true; LANES];
    let (blocks, rest) = values.as_chunks::<LANES>();
    for block in blocks {
        for i in 0..LANES {
            let value = block[i];
            low[i] = if value < low[i] { value } else { low[i] };
            high[i] = if value > high[i] { value } else { high[i] };
            usable[i] &= value >= -most && value <= most;
        }
    }
    for (i, &value) in rest.iter().enumerate() {
        low[i] = if value < low[i] { value } else { low[i] };
        high[i] = if value > high[i] { value } else { high[i] };
        usable[i] &= value >= -most && value <= most;
    }
    if usable.contains(&false) {
        return (most + most, most + most);
    }
    let least = |a: T, b: T| if b < a { b } else { a };
    let largest = |a: T, b: T| if b > a { b } else { a };
    (
        low.into_iter().fold(first, least),
        high.into_iter().fold(first, largest),
    )
}
