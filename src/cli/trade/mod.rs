//! `amacrine trade`: error against seconds, for every plainer model of a sensor or a program in a
//! scene.

mod program;
mod sensor;
mod table;

use std::time::Instant;

use miette::IntoDiagnostic as _;

use super::{
    arguments::{budget, clip::GivenScene, heading, light, quantiser::number_format},
    output::{
        content::Content,
        files::{Input, Named, Output},
        progress::Progress,
    },
};
use crate::{
    array::Arithmetic,
    compare::metric::Short,
    memory::Need,
    number::Format,
    photoreceptor::Response,
    rig::guard::Warning,
    scene::{Observation, Scene, kept::Kept, part::First},
    stop::Stop,
    study::{
        defaults,
        pilot::plan::KEPT,
        trade::{
            OF_PROGRAM, OF_SENSOR,
            answer::{Answer, Asked, Held, TradeError, Watch},
        },
    },
    unit::Micros,
};

/// What `trade` is asked to do.
#[derive(Debug, clap::Args)]
#[command(
    group = clap::ArgGroup::new("what").required(true).args(["sensor", "program"]),
    after_help = "Examples:\n  amacrine trade --scene bundled --sensor rgc -o trade.svg\n  amacrine trade --scene bundled --program dvs/snap -o trade.svg\n  amacrine trade --scene bundled --sensor csdvs --upsample 0.2 --verify\n\nEach model runs on the same sample of tiles beside the full one. docs/fidelity.md says what the\nlimit of a change means, and what a sample cannot see."
)]
pub struct Arguments {
    #[command(flatten)]
    given: GivenScene,
    /// Sensor file; the full model has all its effects, in f64
    ///
    /// Excludes --program and its options.
    #[arg(long)]
    sensor: Option<Input>,
    /// Program; the full model is that of --domain
    ///
    /// Excludes --sensor and --upsample.
    #[arg(long)]
    program: Option<Input>,
    /// Name of a shipped chip, or folder of your own [default: as the program's settings say]
    #[arg(long, conflicts_with = "sensor", help_heading = heading::PROGRAM)]
    chip: Option<Named>,
    /// Constant of the program to set; may be repeated
    #[arg(long = "const", value_name = "NAME=VALUE", value_parser = super::input::opened_program::constant, conflicts_with = "sensor", help_heading = heading::PROGRAM)]
    constants: Vec<(String, f64)>,
    #[arg(long, conflicts_with = "sensor", value_parser = domain, help = format!("Arithmetic of the full model: {} [default: {}]", Arithmetic::names(), defaults::DOMAIN), help_heading = heading::PROGRAM)]
    domain: Option<Arithmetic>,
    /// Number of frames of the scene that the program sees, 3 or more [default: all]
    #[arg(long, conflicts_with = "sensor", value_parser = clap::value_parser!(u64).range(3..), help_heading = heading::PROGRAM)]
    frames: Option<u64>,
    /// Insert frames, as `amacrine run` does
    ///
    /// Excludes --program.
    #[arg(long, value_name = "CONTRAST", value_parser = light::contrast, conflicts_with = "program", help_heading = heading::SCENE)]
    upsample: Option<f64>,
    /// Seed of mismatch and noise, and of the choice of tiles
    #[arg(long, default_value_t = 0, help_heading = heading::MODELS)]
    seed: u64,
    #[arg(long, help = format!("Number formats to try in place of the full model's: {} [default: {} for a sensor, {} for a program]", Format::names(), OF_SENSOR.join(","), OF_PROGRAM.join(",")), value_delimiter = ',', value_name = "FORMATS", value_parser = number_format, help_heading = heading::MODELS)]
    formats: Option<Vec<Format>>,
    #[arg(long, help = format!("Largest shift in time of an event that does not count as changed [default: {}]", Short(defaults::TRADE_WITHIN)), value_name = "TIME", help_heading = heading::MODELS)]
    within: Option<Micros>,
    #[arg(long, help = format!("Part of the sensor that is run, such as 10%; at least twelve tiles [default: {}%]", 100.0 * defaults::SAMPLE), value_name = "PERCENT", value_parser = part, help_heading = heading::MODELS)]
    sample: Option<f64>,
    /// Number of runs of a model that share the cost of knowing its error
    #[arg(long, default_value_t = defaults::RUNS, value_parser = clap::value_parser!(u32).range(1..), help_heading = heading::MODELS)]
    runs: u32,
    /// Run every model on the whole scene, too, and take its times and changes from there
    #[arg(long)]
    verify: bool,
    /// Draw error against seconds (.svg or .png)
    #[arg(short, long, value_name = "FILE", value_parser = Content::Drawing)]
    output: Option<Output>,
    /// Print JSON in place of text
    #[arg(long)]
    json: bool,
}

fn domain(text: &str) -> Result<Arithmetic, String> {
    text.parse()
        .map_err(|error: crate::array::ArithmeticError| {
            let help = miette::Diagnostic::help(&error).map(|help| help.to_string());
            format!("{error}: {}", help.unwrap_or_default())
        })
}

/// A part of the sensor above 0.
fn part(text: &str) -> Result<f64, String> {
    match super::arguments::fidelity::percent(text) {
        Ok(part) if part > 0.0 => Ok(part),
        _ => Err(format!(
            "`{text}` is no part of a sensor: give percent, above 0 and up to 100, such as 5%"
        )),
    }
}

/// Runs the verb.
///
/// # Errors
/// When the scene, the sensor file or the program is not what it should be, or the picture cannot
/// be written.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    match (&arguments.sensor, &arguments.program) {
        (Some(sensor), _) => sensor::run(arguments, sensor),
        (None, Some(program)) => program::run(arguments, program),
        (None, None) => Ok(()),
    }
}

impl Arguments {
    /// What is asked of a sensor or a program that is called so.
    fn asked<'a>(&'a self, of: &'a str) -> Asked<'a> {
        Asked {
            of,
            upsample: self.upsample,
            formats: self.formats.as_deref(),
            within: self.within.unwrap_or(defaults::TRADE_WITHIN),
            sample: self.sample.unwrap_or(defaults::SAMPLE),
            runs: self.runs,
            verify: self.verify,
            seed: self.seed,
        }
    }

    /// The scene, in memory; what is seen of it is noted.
    fn held(&self, observation: &Observation) -> miette::Result<Held> {
        let start = Instant::now();
        let scene = self.given.open(observation)?;
        let mut scene = First::new(scene, self.frames.unwrap_or(u64::MAX));
        let pixels = scene.frames().unwrap_or(0) as u128 * scene.size().pixels() as u128;
        let need = budget::of_scene(&scene).and("the scene, at least a byte a pixel", pixels);
        let what = format!("a trade on {}", scene.size());
        budget::check(&need, &what, "take a shorter or smaller scene")?;
        let most = usize::try_from(need.left(budget::budget())).unwrap_or(KEPT);
        let clock = || start.elapsed().as_secs_f64();
        let name = &self.given.scene;
        Ok(Held::new(
            name,
            &mut scene,
            most.min(KEPT),
            observation,
            &clock,
        )?)
    }

    /// Refuses what there is no room for: the scene, the models on it, and events.
    fn check(kept: &Kept, sensor: u128) -> miette::Result<()> {
        let need = Need::new()
            .and("frames of the scene", kept.scene().outline().bytes)
            .and("two models", 2 * sensor);
        let what = format!("a trade on {}", kept.size());
        budget::check(&need, &what, "take a smaller scene")
    }

    /// Tells and draws an answer.
    fn tell<M>(&self, answer: &Answer<'_, M>, held: &Held, light: &str) -> miette::Result<()> {
        if let Some(path) = &self.output {
            path.draw(&answer.drawing())?;
        }
        if self.json {
            let json = serde_json::to_value(answer).into_diagnostic()?;
            super::say(&format!("{json}\n"));
        } else {
            super::say(&(table::text(self, answer, held) + light));
        }
        Ok(())
    }
}

/// Measures with a bar, and warns of the scene.
fn watched<T>(
    observation: &Observation,
    response: Response,
    answer: impl FnOnce(&Watch<'_>) -> Result<T, TradeError>,
) -> miette::Result<T> {
    let start = Instant::now();
    let progress = Progress::new("models", None);
    let answer = answer(&Watch {
        clock: &|| start.elapsed().as_secs_f64(),
        begin: &|_| progress.tick(),
        stop: Stop::NEVER,
    })?;
    progress.finish();
    light::warn(&Warning::of_scene(observation, response));
    Ok(answer)
}
