//! `amacrine exec`: a program on the array, and every register written out.

mod arguments;
mod bench;
mod debug;
mod dump;
mod light;
mod moment;
mod pilot;
mod reading;
mod report;
mod saturation;
mod set;
mod shows;
mod statistics;
mod strip;

pub use arguments::Arguments;

use std::ops::ControlFlow;

use self::{
    arguments::Assignment, bench::Bench, debug::Debugger, report::Report, saturation::Saturation,
    shows::Shows, statistics::Statistics, strip::Strip,
};
use super::files;
use crate::{array::Array, event::Packet, picture::write_png, rig::guard::Guard};

/// Runs the verb.
///
/// # Errors
/// One diagnostic that names what was wrong.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    for set in &arguments.sets {
        if let Assignment::Register(_, path) = set {
            files::reads(path)?;
        }
    }
    let mut bench = Bench::new(arguments)?;
    bench.check()?;
    bench.check_events()?;
    let plan = if arguments.fidelity.is_auto() {
        Some(pilot::plan(&bench)?)
    } else {
        None
    };
    bench.machine = match &plan {
        Some(plan) => Some(plan.choice.clone()),
        None => arguments.without.machine(bench.arithmetic)?,
    };
    if let Some(folder) = &arguments.dump {
        files::writes(dump::files(&bench.opened.device, folder))?;
    }
    if let Some(runs) = arguments.repeat {
        let statistics = Statistics::from_runs(&bench, arguments.seed, runs)?;
        if arguments.json {
            super::say(&format!("{}\n", statistics.json()));
        } else {
            super::say(&statistics.table());
        }
        return Ok(());
    }
    let mut chip = bench.chip(arguments.seed)?;
    let mut strip = Strip::default();
    let mut guard = Guard::new();
    let mut saturation = bench.saturation();
    let mut shows = Shows::new(&bench.opened, arguments.displays.as_deref());
    let watching = Watching {
        guard: &mut guard,
        saturation: &mut saturation,
        shows: &mut shows,
        strip: &mut strip,
    };
    let (packet, frames) = watching.watch(&bench, &mut *chip)?;
    if plan.is_some() {
        pilot::check(&packet)?;
    }
    let warnings = bench.warnings(guard, &*chip, &packet, frames, saturation.end());
    super::light::warn(&warnings);

    // Before anything is written: it may have nothing to show.
    let strip = match &arguments.strip {
        Some(path) => Some((path, strip.picture(&bench.opened)?)),
        None => None,
    };
    if let Some(path) = &arguments.events {
        path.write(&packet)?;
    }
    if let Some(folder) = &arguments.dump {
        dump::dump(&*chip, folder)?;
    }
    if let Some((path, picture)) = strip {
        write_png(path, &picture)?;
    }
    let mut written = Vec::new();
    let files = [&arguments.events, &arguments.strip].into_iter().flatten();
    written.extend(files.map(|path| path.display().to_string()));
    if let Some(folder) = &arguments.dump {
        let count = dump::files(&bench.opened.device, folder).len();
        written.push(format!("{} ({count} files)", folder.display()));
    }
    written.extend(shows.written());
    let report = Report {
        program: &bench.opened.program.file,
        chip: &*chip,
        arithmetic: bench.arithmetic,
        without: arguments.without.told(),
        frames,
        packet: &packet,
        light: &bench.observation,
        warnings: &warnings,
        notes: &bench.said.notes(frames),
        written: &written,
    };
    if arguments.json {
        let mut json = report.json();
        if let Some(plan) = &plan {
            json["fidelity"] = pilot::json(plan, arguments)?;
        }
        super::say(&format!("{json}\n"));
    } else {
        super::say(&report.table());
        if let Some(plan) = &plan {
            super::say(&pilot::lines(plan, arguments));
        }
        if let Some(path) = &arguments.events {
            super::say(&super::convert::opened(path));
        }
    }
    Ok(())
}

/// What looks at an array while it runs.
struct Watching<'a, 'b> {
    guard: &'a mut Guard,
    saturation: &'a mut Saturation,
    shows: &'a mut Shows<'b>,
    strip: &'a mut Strip,
}

impl Watching<'_, '_> {
    /// Shows the light to the chip; its events, and how many frames there were.
    fn watch(self, bench: &Bench<'_>, chip: &mut dyn Array) -> miette::Result<(Packet, u64)> {
        let Self {
            guard,
            saturation,
            shows,
            strip,
        } = self;
        if bench.arguments.debug {
            let mut debugger = Debugger::new(&bench.opened);
            let seen = bench.watch(chip, |chip, moment, packet| {
                guard.frame_at(moment.t);
                let flow = debugger.frame(chip, moment, packet)?;
                saturation.frame(chip);
                shows.frame(chip, moment.index)?;
                Ok(flow)
            })?;
            debugger.end(chip)?;
            Ok(seen)
        } else if bench.arguments.strip.is_some() {
            bench.watch(chip, |chip, moment, packet| {
                guard.frame_at(moment.t);
                strip.frame(&bench.opened, chip, moment, packet)?;
                saturation.frame(chip);
                shows.frame(chip, moment.index)?;
                Ok(ControlFlow::Continue(()))
            })
        } else {
            bench.watch(chip, |chip, moment, packet| {
                guard.frame_at(moment.t);
                moment.run(chip, packet)?;
                saturation.frame(chip);
                shows.frame(chip, moment.index)?;
                Ok(ControlFlow::Continue(()))
            })
        }
    }
}
