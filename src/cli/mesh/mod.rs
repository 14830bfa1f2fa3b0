//! `amacrine mesh`: the resistor sheet, solved, stepped, fitted to kernels, and drawn.

mod constants;
mod fit;
mod output;
mod parts;
mod show;
mod solve;
mod step;

use clap::Subcommand;

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
    /// Solve the settled surround of one signal
    Solve(solve::Arguments),
    /// Step the surround of a scene over time
    Step(step::Arguments),
    /// Fit a mesh to kernels: the best fit, and the part that no mesh reaches
    Fit(fit::Arguments),
    /// Draw the surround, its frequency response and its voltages in one picture
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
