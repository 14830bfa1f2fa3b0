//! `amacrine demo`: a real clip through float sensors and through their programs on the array,
//! at two frame rates.

mod cell;
mod choice;
mod files;
mod json;
mod showing;
mod table;

use self::{cell::Cell, files::Moments, showing::Showing};
use super::{
    arguments::light,
    output::{
        content::Content,
        files::{self as outputs, Output},
        progress::Progress,
    },
};
use crate::{
    photoreceptor::Response,
    rig::guard::{Guard, Warning},
    scene::{Observation, Observed, Scene, SceneError, bundled, resample::Resampled},
};

/// Frames for each of the clip's, where the chip looks more often.
const TIMES: u32 = 5;

/// What `demo` is asked to do.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: amacrine demo --output out")]
pub struct Arguments {
    /// Folder of the event files and pictures
    #[arg(short, long, alias = "out", default_value = "out", value_name = "DIR", value_parser = Content::Folder)]
    output: Output,
    /// Seed of the silicon's mismatch and noise
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Print JSON in place of text
    #[arg(long)]
    json: bool,
}

/// Runs the verb.
///
/// # Errors
/// When the output folder cannot be written to.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    outputs::writes(files::events(&arguments.output).into_iter().flatten())?;
    outputs::writes(files::pictures(&arguments.output))?;
    let seed = arguments.seed;
    let cells = cell::all(seed)?;
    let observation = Observation::new();
    let clip = || Ok::<_, SceneError>(Observed::new(bundled()?, &observation));
    let mut own = clip()?;
    let mut faster = Resampled::new(clip()?, own.fps() * f64::from(TIMES))?;
    let frames = own.frames().zip(faster.frames());
    let progress = Progress::new("watching", frames.map(|(a, b)| a + b));
    let mut guard = Guard::new();
    let own = Showing::new(&cells, &mut own, seed, &mut guard, |_| progress.tick())?;
    let mut moments = Moments::default();
    let faster = Showing::new(&cells, &mut faster, seed, &mut guard, |frame| {
        moments.see(frame);
        progress.tick();
    })?;
    progress.finish();
    let mut warnings = Warning::of_scene(&observation, Response::IDENTITY);
    warnings.append(&mut guard.warnings());
    light::warn(&warnings);
    let written = files::write(&arguments.output, &faster, &moments.kept)?;
    let demo = Demo {
        cells: &cells,
        showings: [own, faster],
        observation,
        warnings,
        written,
    };
    if arguments.json {
        super::say(&format!("{}\n", demo.json()));
    } else {
        super::say(&demo.table());
    }
    Ok(())
}

/// All that the demo has to say.
struct Demo<'a> {
    cells: &'a [Cell],
    /// At the clip's own rate, and at one that the chip would run.
    showings: [Showing<'a>; 2],
    observation: Observation,
    warnings: Vec<Warning>,
    written: Vec<std::path::PathBuf>,
}
