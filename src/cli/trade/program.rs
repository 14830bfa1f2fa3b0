//! The trade of a program.

use miette::miette;

use super::{Arguments, watched};
use crate::{
    array::Arithmetic,
    cli::{
        arguments::light,
        input::opened_program::Source,
        output::{command_line::CommandLine, files::Input},
    },
    photoreceptor::Response,
    rig::Larger,
    scene::Observation,
    study::{
        execution::CellOptions,
        pilot::{Chips, ErrorTerm},
        trade::{Setup, answer::of_program},
    },
};

pub fn run(arguments: &Arguments, path: &Input) -> miette::Result<()> {
    let source = Source::new(
        path.clone(),
        arguments.chip.clone(),
        arguments.constants.clone(),
    );
    let opened = source.open(&[])?;
    if opened.expansion.bare {
        return Err(miette!(
            help = "give a program with `init` and `frame` that reads events out",
            "{} is bare statements: it says no events",
            path.display()
        ));
    }
    let observation = Observation::new();
    let held = arguments.held(&observation)?;
    let size = held.kept.size();
    Larger::check(
        &format!("--scene {}", arguments.given.scene),
        size,
        &opened.device,
    )?;
    let domain = arguments.domain.unwrap_or(Arithmetic::Silicon { seed: 0 });
    Arguments::check(&held.kept, domain.bytes(&opened.device, size))?;
    let chips = Chips {
        name: &opened.program.file,
        code: &opened.expansion.code,
        device: &opened.device,
        settings: CellOptions::default().settings(&opened.program, &opened.device),
        arithmetic: domain,
        reads_all: false,
    };
    let asked = arguments.asked(&opened.program.file);
    let command = |setup: &_| command(arguments, path, held.kept.len(), setup);
    let answer = watched(&observation, Response::IDENTITY, |watch| {
        of_program(chips, &asked, &held, watch, &command)
    })?;
    arguments.tell(&answer, &held, &light::line(&observation))
}

/// The command that runs a model.
fn command(arguments: &Arguments, path: &Input, frames: usize, setup: &Setup) -> String {
    let mut line = CommandLine::new("exec");
    line.word(&path.display().to_string());
    line.option("image", &arguments.given.scene);
    line.option("frames", &frames.to_string());
    if let Some(chip) = &arguments.chip {
        line.option("chip", chip);
    }
    for (name, value) in &arguments.constants {
        line.option("const", &format!("{name}={value}"));
    }
    line.options(arguments.given.samples.written());
    let domain = match setup.machine.format {
        Some(format) => Arithmetic::Number(format),
        None => Arithmetic::Silicon { seed: 0 },
    };
    line.option("domain", &domain.to_string());
    if arguments.seed != 0 {
        line.option("seed", &arguments.seed.to_string());
    }
    let without: Vec<_> = setup
        .without()
        .iter()
        .copied()
        .map(ErrorTerm::word)
        .collect();
    if !without.is_empty() {
        line.option("without", &without.join(","));
    }
    if setup.ordered {
        line.option("schedule", &setup.schedule.to_string());
    }
    line.to_string()
}
