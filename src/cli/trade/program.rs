//! The trade of a program.

use miette::miette;

use super::{
    super::{files::Input, opened::Source, quoted::quoted},
    Arguments,
};
use crate::{
    array::{Arithmetic, Schedule, Settings},
    number::Format,
    photoreceptor::Response,
    rig::Larger,
    study::{
        pilot::{Chips, ErrorTerm},
        trade::{Programs, Setup},
    },
};

/// Domains that are tried where none are named.
const FORMATS: [&str; 4] = ["exact", "f32", "f16", "q8.8"];

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
        &format!("--scene {}", arguments.scene),
        size,
        &opened.device,
    )?;
    let domain = arguments.domain.unwrap_or(Arithmetic::Silicon { seed: 0 });
    let domain = domain.with_seed(arguments.seed);
    Arguments::check(&scened.kept, domain.bytes(&opened.device, size))?;
    let mut settings = Settings::from_device(&opened.device);
    let own = &opened.program.settings;
    settings.clip = own.clip.unwrap_or(settings.clip);
    settings.edge = own.edge.unwrap_or(settings.edge);
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
    let formats: Vec<Format> = match &arguments.formats {
        Some(formats) => formats.clone(),
        None => FORMATS
            .iter()
            .filter_map(|name| name.parse().ok())
            .collect(),
    };
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
    let mut words = vec![
        "amacrine exec".to_owned(),
        quoted(&path.display().to_string()),
        "--image".to_owned(),
        quoted(&arguments.scene),
    ];
    let mut add = |name: &str, value: &str| words.push(format!("--{name} {}", quoted(value)));
    add("frames", &frames.to_string());
    if let Some(chip) = &arguments.chip {
        add("chip", chip);
    }
    for (name, value) in &arguments.constants {
        add("const", &format!("{name}={value}"));
    }
    arguments.light(&mut add);
    let domain = match setup.machine.format {
        Some(format) => Arithmetic::Number(format),
        None => Arithmetic::Silicon { seed: 0 },
    };
    add("domain", &domain.to_string());
    if arguments.seed != 0 {
        add("seed", &arguments.seed.to_string());
    }
    let without: Vec<_> = setup
        .without()
        .iter()
        .copied()
        .map(ErrorTerm::word)
        .collect();
    if !without.is_empty() {
        add("without", &without.join(","));
    }
    if setup.ordered {
        add("schedule", &setup.schedule.to_string());
    }
    words.join(" ")
}
