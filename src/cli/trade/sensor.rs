//! The trade of a sensor file.

use super::{Arguments, watched};
use crate::{
    cli::{
        arguments::light,
        output::{command_line::CommandLine, files::Input},
        run::read_sensor,
    },
    number::Format,
    reference::{Effect, Reference},
    scene::Observation,
    study::{pilot::Choice, trade::answer::of_sensor},
};

pub fn run(arguments: &Arguments, sensor: &Input) -> miette::Result<()> {
    let description = read_sensor(sensor)?;
    let observation = Observation::new();
    let held = arguments.held(&observation)?;
    let bytes = <Reference>::bytes(&description, held.kept.size());
    Arguments::check(&held.kept, bytes)?;
    let of = sensor.display().to_string();
    let asked = arguments.asked(&of);
    let command = |choice: &_| command(arguments, sensor, choice);
    let answer = watched(&observation, description.response, |watch| {
        of_sensor(&description, &asked, &held, watch, &command)
    })?;
    arguments.tell(&answer, &held, &light::line(&observation))
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
