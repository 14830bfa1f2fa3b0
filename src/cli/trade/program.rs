//! The trade of a program.

use miette::miette;

use super::Arguments;
use crate::{
    array::{Arithmetic, Schedule},
    cli::{
        input::opened_program::Source,
        output::{command_line::CommandLine, files::Input},
    },
    photoreceptor::Response,
    rig::Larger,
    study::{
        execution::CellOptions,
        pilot::{Chips, ErrorTerm},
        trade::{OF_PROGRAM, Programs, Setup},
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
    let scened = arguments.scene()?;
    let size = scened.kept.size();
    Larger::check(
        &format!("--scene {}", arguments.given.scene),
        size,
        &opened.device,
    )?;
    let domain = arguments.domain.unwrap_or(Arithmetic::Silicon { seed: 0 });
    let domain = domain.with_seed(arguments.seed);
    Arguments::check(&scened.kept, domain.bytes(&opened.device, size))?;
    let mut settings = CellOptions::default().settings(&opened.program, &opened.device);
    settings.threads = Some(rayon::current_num_threads());
    let family = Programs {
        chips: Chips {
            name: &opened.program.file,
            code: &opened.expansion.code,
            device: &opened.device,
            settings,
            arithmetic: domain,
            reads_all: false,
        },
        schedule: Schedule::for_size(size),
    };
    let formats = arguments.formats(&OF_PROGRAM);
    let alternative = |setup: &Setup| family.alternative(setup);
    let free = |setup: &Setup, _: &_| family.free(setup);
    let full = format!("{domain}, {}", family.schedule);
    let command = |setup: &_| command(arguments, path, scened.kept.len(), setup);
    let table = arguments.told((&opened.program.file, &full), &scened, &command);
    let models = family.models(&formats);
    let rules = (&alternative as &_, &free as &_);
    let told = (&table, Response::IDENTITY);
    arguments.trade(&family, &scened, models, rules, told)
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
