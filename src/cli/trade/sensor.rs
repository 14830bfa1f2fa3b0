//! The trade of a sensor file.

use super::Arguments;
use crate::{
    cli::{
        output::{command_line::CommandLine, files::Input},
        run::read_sensor,
    },
    number::Format,
    reference::{Effect, Reference},
    study::{
        pilot::{Choice, Floats},
        trade::OF_SENSOR,
    },
};

pub fn run(arguments: &Arguments, sensor: &Input) -> miette::Result<()> {
    let description = read_sensor(sensor)?;
    let scened = arguments.scene()?;
    let bytes = <Reference>::bytes(&description, scened.kept.size());
    Arguments::check(&scened.kept, bytes)?;
    let full = Choice::full();
    let family = Floats {
        description: &description,
        seed: arguments.seed,
        base: &full,
    };
    let formats = arguments.formats(&OF_SENSOR);
    let alternative = |choice: &Choice| family.alternative(choice);
    let free = |choice: &Choice, look: &_| family.free(choice, look);
    let of = sensor.display().to_string();
    let command = |choice: &_| command(arguments, sensor, choice);
    let table = arguments.told(
        (&of, "f64, with all effects of the file"),
        &scened,
        &command,
    );
    let models = family.models(&formats, arguments.upsample.is_some());
    let rules = (&alternative as &_, &free as &_);
    let told = (&table, description.response);
    arguments.trade(&family, &scened, models, rules, told)
}

/// The command that runs a model.
fn command(arguments: &Arguments, sensor: &Input, choice: &Choice) -> String {
    let mut line = CommandLine::new("run");
    line.option("scene", &arguments.given.scene);
    line.option("sensor", &sensor.display().to_string());
    line.options(arguments.given.samples.written());
    if let Some(contrast) = arguments.upsample
        && !choice.leaves_out(Effect::InsertedFrames)
    {
        line.option("upsample", &contrast.to_string());
    }
    if arguments.seed != 0 {
        line.option("seed", &arguments.seed.to_string());
    }
    if choice.format != Format::F64 {
        line.option("format", &choice.format.to_string());
    }
    let without = choice.without.iter().map(|effect| effect.word());
    let without: Vec<_> = { without }
        .filter(|key| *key != Effect::InsertedFrames.word())
        .collect();
    if !without.is_empty() {
        line.option("without", &without.join(","));
    }
    line.to_string()
}
