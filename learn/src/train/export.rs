//! What was learned, as files that the main program takes.

use std::path::Path;

use amacrine::{plane::Plane, reference::Description, save};
use ndarray_npy::WriteNpyExt;

use super::error::TrainError;

/// Writes a kernel as `.npy`, (rows, columns).
///
/// # Errors
/// When it cannot be written.
pub fn kernel(path: &Path, weights: &Plane<f64>) -> Result<(), TrainError> {
    save::save(path, |out| {
        weights.write_npy(out).map_err(std::io::Error::other)
    })?;
    Ok(())
}

/// Writes a sensor file.
///
/// # Errors
/// When it cannot be written.
pub fn sensor(path: &Path, sensor: &Description, source: &str) -> Result<(), TrainError> {
    let text = sensor_text(sensor, source);
    save::save(path, |out| out.write_all(text.as_bytes()))?;
    Ok(())
}

/// The text of a sensor file: numbers are written so that they are read back to the bit.
#[must_use]
pub fn sensor_text(sensor: &Description, source: &str) -> String {
    let text = sensor.to_toml();
    // After the name, which comes first.
    let (name, rest) = text.split_once('\n').unwrap_or((&text, ""));
    format!("{name}\nsource = {source:?}\n{rest}")
}
