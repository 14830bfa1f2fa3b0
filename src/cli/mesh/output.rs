//! What of a sheet is written, and how.

use miette::IntoDiagnostic;

use crate::{
    cli::{input::npy, output::files::Output, say},
    picture::{panel, write_png},
    plane::Plane,
};

/// What of the sheet is written.
#[derive(Clone, Copy, Debug, Default, clap::ValueEnum)]
pub(super) enum Show {
    /// The surround H
    #[default]
    Surround,
    /// The difference P - H, which drives a Center Surround DVS
    Difference,
}

/// A plane as `.npy` (float64), or as a picture from its least to its most.
pub(super) fn write(path: &Output, plane: &Plane<f64>) -> miette::Result<()> {
    if path.ending() == "png" {
        let (low, high) = extremes(plane);
        return Ok(write_png(path, &panel::frame(plane, low, high))?);
    }
    npy::write(path, plane)
}

/// The least and the most.
pub(super) fn extremes(plane: &Plane<f64>) -> (f64, f64) {
    let infinite = (f64::INFINITY, f64::NEG_INFINITY);
    plane
        .iter()
        .fold(infinite, |(low, high), v| (low.min(*v), high.max(*v)))
}

/// An answer for machines.
pub(super) fn say_json<T: serde::Serialize>(json: &T) -> miette::Result<()> {
    let json = serde_json::to_string(json).into_diagnostic()?;
    say(&format!("{json}\n"));
    Ok(())
}
