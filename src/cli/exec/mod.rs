//! `amacrine exec`: a program on the array, and every register written out.

mod arguments;
mod bench;
mod beside;
mod debug;
mod dump;
mod light;
mod moment;
mod pass;
mod pilot;
mod reading;
mod report;
mod set;
mod shows;
mod statistics;
mod strip;
mod trace;

pub use arguments::Arguments;

use miette::miette;

use self::{
    arguments::Assignment,
    bench::Bench,
    pass::Pass,
    pilot::Planned,
    report::{Report, Written},
    shows::Shows,
    statistics::Statistics,
    trace::Tracer,
};
use super::output::files;
use crate::{picture::write_png, program::Cost, save::save};

/// Runs the verb.
///
/// # Errors
/// One diagnostic that names what was wrong.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    for (n, set) in arguments.sets.iter().enumerate() {
        if arguments.sets[..n]
            .iter()
            .any(|other| other.name() == set.name())
        {
            return Err(miette!(
                help = "give each name once",
                "--set {} is given twice",
                set.name()
            ));
        }
        if let Assignment::Register(_, path) = set {
            files::reads(path)?;
        }
    }
    let mut bench = Bench::new(arguments)?;
    bench.check()?;
    let auto = arguments.fidelity.is_auto();
    let mut plan = auto.then(|| pilot::plan(&bench)).transpose()?;
    bench.read = plan.as_mut().and_then(|plan| plan.read.take());
    bench.machine = match &plan {
        Some(plan) => Some(plan.answer.choice.clone()),
        None => bench.left_out()?,
    };
    if let Some(quicker) = plan.as_ref().and_then(|plan| plan.quicker) {
        bench.settings.schedule = Some(quicker.schedule);
    }
    bench.record()?;
    if let Some(folder) = &arguments.dump {
        files::writes(dump::files(&bench.opened.device, folder))?;
    }
    if let Some(runs) = arguments.repeat {
        return repeat(&bench, runs);
    }
    let mut pass = Pass::new(&bench, plan.as_ref().is_some_and(Planned::leaves_out))?;
    if let Some(plan) = plan.as_mut().filter(|plan| plan.leaves_out())
        && pass.packet.dropped.no_slot > 0
    {
        drop(pass);
        plan.give_up();
        bench.machine = Some(plan.answer.choice.clone());
        pass = Pass::new(&bench, false)?;
    }
    let frames = pass.frames;
    let warnings = bench.warnings(
        pass.guard,
        &*pass.chip,
        &pass.packet,
        frames,
        pass.saturation,
    );
    super::arguments::light::warn(&warnings);

    // Before anything is written: it may have nothing to show.
    let drawn = match &arguments.strip {
        Some(path) => Some((path, pass.strip.picture(&bench.opened)?)),
        None => None,
    };
    let trace = pass.tracer.map(Tracer::page).transpose()?;
    if let Some(path) = &arguments.events {
        path.write(&pass.packet)?;
    }
    if let Some(folder) = &arguments.dump {
        dump::dump(&*pass.chip, folder)?;
    }
    if let Some((path, picture)) = drawn {
        path.warn_of_letters(pass.strip.texts(&bench.opened));
        write_png(path, &picture)?;
    }
    let mut notes = bench.notes(frames);
    notes.extend(pass.shows.note());
    if bench.opened.decides {
        notes.extend(report::lost(&pass.chip.ledger(), true));
    }
    if let (Some(path), Some((page, said))) = (&arguments.trace, trace) {
        save(path, |out| out.write_all(page.as_bytes()))?;
        notes.extend(said);
    }
    let written = written(arguments, &bench, &pass.shows);
    let report = Report {
        program: &bench.opened.program.file,
        chip: &*pass.chip,
        arithmetic: bench.arithmetic,
        frames,
        per_frame: (!bench.opened.decides)
            .then(|| Cost::of(&bench.opened.expansion.code.frame, &bench.opened.device)),
        packet: &pass.packet,
        light: &bench.observation,
        warnings: &warnings,
        source_warnings: &bench.source_warnings(),
        notes: &notes,
        decides: bench.opened.decides,
        reads_events: bench.reads_events(),
        posts: &bench.said.posts.borrow(),
        written: &written,
        without: arguments.without.told(),
    };
    print(arguments, &report, plan.as_ref())
}

/// Runs it so often, and tells mean and spread.
fn repeat(bench: &Bench<'_>, runs: u64) -> miette::Result<()> {
    let arguments = bench.arguments;
    let statistics = Statistics::from_runs(bench, arguments.seed(), runs)?;
    super::arguments::light::warn(&statistics.warnings);
    if arguments.json {
        super::say(&format!("{}\n", statistics.json()));
    } else {
        super::say(&statistics.table());
    }
    Ok(())
}

fn print(arguments: &Arguments, report: &Report<'_>, plan: Option<&Planned>) -> miette::Result<()> {
    if arguments.json {
        let mut json = report.json();
        if let Some(plan) = plan {
            json["fidelity"] = pilot::json(plan, arguments)?;
        }
        super::say(&format!("{json}\n"));
        return Ok(());
    }
    super::say(&report.table());
    if let Some(plan) = plan {
        super::say(&pilot::lines(plan, arguments));
    }
    if let Some(path) = &arguments.events {
        super::say(&super::convert::opened(path));
    }
    Ok(())
}

/// The files of a run.
fn written(arguments: &Arguments, bench: &Bench<'_>, shows: &Shows<'_>) -> Vec<Written> {
    let files = [&arguments.events, &arguments.strip, &arguments.trace];
    let files = files.into_iter().flatten();
    let mut written: Vec<Written> = files.map(|path| Written::from(&**path)).collect();
    written.extend(arguments.dump.as_ref().map(|folder| Written {
        path: folder.to_path_buf(),
        files: Some(dump::files(&bench.opened.device, folder).len()),
    }));
    written.extend(shows.written());
    written
}
