//! What was learned, as files that the main program takes.

use std::{fmt::Write as _, path::Path};

use amacrine::{
    kernel::Kernel,
    photoreceptor::{Curve, Response},
    plane::Plane,
    reference::{Border, Channel, Description, MemoryRule, Threshold},
    save,
};
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

fn response(response: Response) -> String {
    let round = if response.round_f32 {
        ", round = \"f32\""
    } else {
        ""
    };
    match response.curve {
        Curve::Identity => "\"identity\"".to_owned(),
        Curve::Linear { white } => format!("{{ linear = {{ white = {white:?}{round} }} }}"),
        Curve::Log { white, offset } => {
            format!("{{ log = {{ white = {white:?}, offset = {offset:?}{round} }} }}")
        }
        Curve::LinLog { knee } => format!("{{ lin-log = {{ knee = {knee:?}{round} }} }}"),
    }
}

fn rows(kernel: &Kernel) -> String {
    let row = |row: ndarray::ArrayView1<'_, f64>| {
        let weights: Vec<_> = row.iter().map(|w| format!("{w:?}")).collect();
        format!("[{}]", weights.join(", "))
    };
    let rows: Vec<_> = kernel.weights().outer_iter().map(row).collect();
    format!("[{}]", rows.join(", "))
}

fn threshold(threshold: &Threshold) -> String {
    let Threshold { on, off, sigma } = threshold;
    format!("{{ on = {on:?}, off = {off:?}, sigma = {sigma:?} }}")
}

/// The text of a sensor file: numbers are written so that they are read back to the bit.
#[must_use]
pub fn sensor_text(sensor: &Description, source: &str) -> String {
    let mut text = format!("name = {:?}\nsource = {source:?}\n", sensor.name);
    let memory = match sensor.memory {
        MemoryRule::RawSnap => "raw-snap",
        MemoryRule::FilteredSnap => "filtered-snap",
        MemoryRule::FilteredStep => "filtered-step",
        MemoryRule::AuthorsPixelStep => "authors-pixel-step",
    };
    let border = match sensor.border {
        Border::Replicate => "replicate",
        Border::Zero => "zero",
    };
    let _ = writeln!(text, "response = {}", response(sensor.response));
    let _ = writeln!(text, "memory = \"{memory}\"\nborder = \"{border}\"");
    if sensor.refractory.us > 0.0 {
        let _ = writeln!(text, "refractory = {{ us = {:?} }}", sensor.refractory.us);
    }
    for Channel {
        kernels,
        thresholds,
        ..
    } in &sensor.channels
    {
        let all: Vec<_> = kernels.iter().map(rows).collect();
        let of: Vec<_> = thresholds.iter().map(threshold).collect();
        let _ = if let ([kernel], [threshold]) = (&all[..], &of[..]) {
            writeln!(
                text,
                "\n[[channel]]\nkernel = {kernel}\nthreshold = {threshold}"
            )
        } else {
            writeln!(
                text,
                "\n[[channel]]\npattern = \"2x2\"\nkernel = [{}]\nthreshold = [{}]",
                all.join(",\n  "),
                of.join(", ")
            )
        };
    }
    text
}
