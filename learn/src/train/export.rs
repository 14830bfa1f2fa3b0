//! What was learned, as files that the main program takes.

use std::path::Path;

use amacrine::{config::on_one_line, plane::Plane, reference::Description, save};
use ndarray_npy::WriteNpyExt;

use super::error::TrainError;

/// Writes a kernel as `.npy`, (rows, columns).
///
/// # Errors
/// When it cannot be written.
pub fn kernel(path: &Path, weights: &Plane<f64>) -> Result<(), TrainError> {
    save::save_durably(path, |out| {
        weights.write_npy(out).map_err(std::io::Error::other)
    })?;
    Ok(())
}

/// Writes a sensor file, with what it is of and what is to be said of it.
///
/// # Errors
/// When it cannot be written.
pub fn sensor(
    path: &Path,
    sensor: &Description,
    (source, remarks): (&str, &[String]),
) -> Result<(), TrainError> {
    let text = sensor_text(sensor, source);
    let text = beside(&text, "source = ", ("# ", remarks));
    save::save_durably(path, |out| out.write_all(text.as_bytes()))?;
    Ok(())
}

/// The text of a sensor file: numbers are written so that they are read back to the bit.
#[must_use]
pub fn sensor_text(sensor: &Description, source: &str) -> String {
    let text = sensor.to_toml();
    // After the name, which comes first.
    let (name, rest) = text.split_once('\n').unwrap_or((&text, ""));
    format!("{name}\nsource = {}\n{rest}", on_one_line(source))
}

/// A program's text with what is to be said of it, before what it computes.
#[must_use]
pub fn program_text(text: &str, remarks: &[String]) -> String {
    beside(text, "//! [computes]", ("//! # ", remarks))
}

/// What a sensor file cannot say: noise of the light that its thresholds were set with.
#[must_use]
pub fn light_noise(noise: f64) -> Option<String> {
    (noise > 0.0).then(|| {
        format!(
            "its thresholds were set on light with noise of {noise} (of 255, standard deviation; `light-noise` of the task), which a sensor file does not have: without it there are fewer events"
        )
    })
}

/// The text with remarks before the first line that begins so, each a comment of its own; after what
/// there is where no line does.
fn beside(text: &str, line: &str, (comment, remarks): (&str, &[String])) -> String {
    let at = text.find(line).unwrap_or(text.len());
    let mut told = text[..at].to_owned();
    for remark in remarks {
        told.extend([comment, remark, "\n"]);
    }
    told + &text[at..]
}
