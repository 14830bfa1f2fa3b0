//! `amacrine trade`: error against seconds, for every plainer model of a sensor or a program in a
//! scene.

mod program;
mod sensor;
mod table;

use std::{fmt, time::Instant};

use miette::miette;

use self::table::Table;
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
    memory::Need,
    number::Format,
    photoreceptor::Response,
    rig::guard::Warning,
    scene::{Observation, Scene, kept::Kept, part::First},
    stop::Stop,
    study::{
        pilot::{Family, Look, Survey, plan::KEPT},
        trade::{Ask, OF_PROGRAM, OF_SENSOR, Trade, told::Told, trade},
    },
    unit::{Micros, counted},
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
    #[arg(long, conflicts_with = "sensor", value_parser = domain, help = format!("Arithmetic of the full model: {} [default: silicon]", Arithmetic::names()), help_heading = heading::PROGRAM)]
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
    /// Largest shift in time of an event that does not count as changed
    #[arg(long, default_value = "100us", value_name = "TIME", help_heading = heading::MODELS)]
    within: Micros,
    /// Part of the sensor that is run, such as 10%; at least twelve tiles
    #[arg(long, default_value = "5%", value_name = "PERCENT", value_parser = part, help_heading = heading::MODELS)]
    sample: f64,
    /// Number of runs of a model that share the cost of knowing its error
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..), help_heading = heading::MODELS)]
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

/// The scene, in memory, and how long it took to read.
struct Scened {
    kept: Kept,
    observation: Observation,
    reading: f64,
}

impl Arguments {
    /// The number formats to try: these where none are named.
    fn formats(&self, usual: &[&str]) -> Vec<Format> {
        let usual = || usual.iter().filter_map(|name| name.parse().ok()).collect();
        self.formats.clone().unwrap_or_else(usual)
    }

    fn scene(&self) -> miette::Result<Scened> {
        let observation = Observation::new();
        let start = Instant::now();
        let scene = self.given.open(&observation)?;
        let mut scene = First::new(scene, self.frames.unwrap_or(u64::MAX));
        let pixels = scene.frames().unwrap_or(0) as u128 * scene.size().pixels() as u128;
        let need = budget::of_scene(&scene).and("the scene, at least a byte a pixel", pixels);
        let what = format!("a trade on {}", scene.size());
        budget::check(&need, &what, "take a shorter or smaller scene")?;
        let most = usize::try_from(need.left(budget::budget())).unwrap_or(KEPT);
        let Some(kept) = Kept::new(&mut scene, most.min(KEPT))? else {
            return Err(miette!(
                help = "take a shorter or smaller scene, such as the first seconds of this one",
                "{} is too long to be kept in memory, and every model looks at all of it",
                self.given.scene
            ));
        };
        let reading = start.elapsed().as_secs_f64();
        if kept.len() < 3 {
            return Err(miette!(
                help = "give a scene of at least three frames",
                "{} has {}: nothing can be measured",
                self.given.scene,
                counted(kept.len(), "frame")
            ));
        }
        Ok(Scened {
            kept,
            observation,
            reading,
        })
    }

    /// Refuses what there is no room for: the scene, the models on it, and events.
    fn check(kept: &Kept, sensor: u128) -> miette::Result<()> {
        let need = Need::new()
            .and("frames of the scene", kept.scene().outline().bytes)
            .and("two models", 2 * sensor);
        let what = format!("a trade on {}", kept.size());
        budget::check(&need, &what, "take a smaller scene")
    }

    /// What is told of a trade, of this sensor or program, of a full model that is called so.
    fn told<'a, M>(
        &'a self,
        (of, full): (&'a str, &'a str),
        scened: &'a Scened,
        command: &'a dyn Fn(&M) -> String,
    ) -> Table<'a, M> {
        Table {
            arguments: self,
            scened,
            told: Told {
                of,
                scene: &self.given.scene,
                fps: scened.kept.scene().fps(),
                full,
                verify: self.verify,
                runs: self.runs,
                command,
            },
        }
    }

    /// Measures, tells, draws.
    fn trade<F>(
        &self,
        family: &F,
        scened: &Scened,
        models: Vec<F::Model>,
        (alternative, free): Rules<'_, F::Model>,
        (table, response): (&Table<'_, F::Model>, Response),
    ) -> miette::Result<()>
    where
        F: Family,
        F::Model: fmt::Display,
    {
        let start = Instant::now();
        let clock = || start.elapsed().as_secs_f64();
        let progress = Progress::new("models", None);
        let ask = Ask {
            survey: Survey {
                kept: &scened.kept,
                upsample: self.upsample,
                within: self.within,
                seed: self.seed,
                clock: &clock,
                sample: self.sample,
                stop: Stop::NEVER,
            },
            models,
            alternative,
            free,
            verify: self.verify,
            runs: self.runs,
            begin: &|_| progress.tick(),
        };
        let trade: Trade<F::Model> = trade(family, &ask)?;
        progress.finish();
        light::warn(&Warning::of_scene(&scened.observation, response));
        if let Some(path) = &self.output {
            path.draw(&table.told.drawing(&trade))?;
        }
        if self.json {
            let mut json = table.json(&trade)?;
            json["light"] = light::json(&scened.observation);
            super::say(&format!("{json}\n"));
        } else {
            super::say(&(table.text(&trade) + &light::line(&scened.observation)));
        }
        Ok(())
    }
}

/// Which models are alternatives, and which are free.
type Rules<'a, M> = (
    &'a dyn Fn(&M) -> bool,
    &'a dyn Fn(&M, &Look) -> Option<&'static str>,
);
