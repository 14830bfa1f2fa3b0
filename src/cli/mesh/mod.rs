//! `amacrine mesh`: the resistor sheet, solved, stepped, fitted to kernels, and drawn.

mod fit;
mod show;
mod solve;
mod step;

use clap::Subcommand;

use crate::{
    cli::{exec::write_npy, files::Output},
    mesh::{MeshError, Sheet},
    picture::{panel, write_png},
    plane::Plane,
};

/// What `mesh` is asked to do.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  amacrine mesh solve --lambda 10 --input P.npy --output H.npy\n  amacrine mesh step --lambda 10 --tau 1ms --scene clip.mp4 --output H.npy\n  amacrine mesh fit dvs csdvs-5 laplacian dog sobel-x\n  amacrine mesh show --lambda 3 --output mesh.png\n\nλ is the space constant in pixels: λ² is transverse over lateral resistance (docs/mesh.md)."
)]
pub struct Arguments {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// The settled surround of one signal
    Solve(solve::Arguments),
    /// The surround of a scene over time
    Step(step::Arguments),
    /// What a mesh makes of kernels: the unreachable part, the best fit
    Fit(fit::Arguments),
    /// The surround, its frequency response, its voltages, in one picture
    Show(show::Arguments),
}

/// Runs the verb.
///
/// # Errors
/// When an input cannot be read or solved for, or an output not be written.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    match &arguments.verb {
        Verb::Solve(arguments) => solve::run(arguments),
        Verb::Step(arguments) => step::run(arguments),
        Verb::Fit(arguments) => fit::run(arguments),
        Verb::Show(arguments) => show::run(arguments),
    }
}

/// The space constants of a sheet, as they are asked for.
#[derive(Debug, clap::Args)]
struct Constants {
    /// Space constant in pixels, 0 or more: λ² is transverse over lateral resistance
    #[arg(long, value_name = "L", allow_negative_numbers = true)]
    lambda: f64,
    /// Another space constant down the columns
    #[arg(long, value_name = "L", allow_negative_numbers = true)]
    lambda_y: Option<f64>,
}

impl Constants {
    fn sheet(&self) -> Result<Sheet, MeshError> {
        Sheet::anisotropic(self.lambda_y.unwrap_or(self.lambda), self.lambda)
    }
}

/// What of the sheet is written.
#[derive(Clone, Copy, Debug, Default, clap::ValueEnum)]
enum Show {
    /// H, the surround
    #[default]
    Surround,
    /// P - H, what a Center Surround DVS is driven by
    Difference,
}

/// A plane as `.npy` (float64), or as a picture from its least to its most.
fn write(path: &Output, plane: &Plane<f64>) -> miette::Result<()> {
    if path.ending() == "png" {
        let (low, high) = extremes(plane);
        return Ok(write_png(path, &panel::frame(plane, low, high))?);
    }
    write_npy(path, plane)
}

/// The least and the most.
fn extremes(plane: &Plane<f64>) -> (f64, f64) {
    let infinite = (f64::INFINITY, f64::NEG_INFINITY);
    plane
        .iter()
        .fold(infinite, |(low, high), v| (low.min(*v), high.max(*v)))
}
