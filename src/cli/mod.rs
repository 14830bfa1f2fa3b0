//! The command line: one file or folder a verb, and the only place that prints.
//!
//! - [`arguments`]: options that several verbs share.
//! - [`input`]: what verbs read.
//! - [`output`]: what they print and write.

mod arguments;
pub mod asm;
pub mod compare;
pub mod compile;
pub mod completions;
pub mod convert;
pub mod demo;
pub mod design;
pub mod disasm;
pub mod exec;
pub mod feasibility;
mod input;
pub mod learn;
pub mod list;
pub mod man;
pub mod merge;
pub mod mesh;
pub mod new;
mod output;
pub mod packets;
pub mod plan;
pub mod quantise;
pub mod report;
pub mod run;
pub mod schema;
pub mod show;
pub mod sweep;
pub mod trade;
pub mod voxels;
pub mod waterfall;

use std::{any::TypeId, process::ExitCode};

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

use self::{
    arguments::{budget, heading, threads},
    output::{
        files,
        print::{self, complain, say},
        signals,
    },
};
use crate::{catch_panic, memory::Budget, unit::Micros};

/// Of an option of every verb, behind those of its own.
const BEHIND: usize = 900;

/// What real silicon does to the retina's computation.
#[derive(Debug, Parser)]
#[command(name = "amacrine", version, about, after_help = examples())]
struct Arguments {
    /// Memory limit, such as 500M or 4G (powers of 1024) [default: three quarters of the machine's]
    ///
    /// Work that needs more is refused before it starts.
    #[arg(long, global = true, value_name = "SIZE", display_order = BEHIND, help_heading = heading::RESOURCES)]
    max_memory: Option<Budget>,
    /// Number of threads; it does not change the results [default: one for each core]
    #[arg(long, global = true, value_name = "N", value_parser = threads::number, display_order = BEHIND, help_heading = heading::RESOURCES)]
    threads: Option<usize>,
    #[command(subcommand)]
    verb: Option<Verb>,
}

/// Makes the verbs from their list.
macro_rules! verbs {
    ($(#[$about:meta] $verb:ident => $file:ident,)+) => {
        #[derive(Debug, Subcommand)]
        enum Verb {
            $(#[$about] $verb($file::Arguments),)+
        }

        fn run(arguments: Arguments) -> miette::Result<()> {
            match arguments.verb {
                None => Ok(()),
                $(Some(Verb::$verb(arguments)) => $file::run(&arguments),)+
            }
        }
    };
}

// The list: a file for each verb, with its `Arguments` and `run`, in the order of the help.
verbs! {
    /// Show a clip to float sensors and to their programs on the array, and compare the events
    Demo => demo,
    /// Run a sensor on a scene: events, counts, voxels
    Run => run,
    /// Run a program on the array: events, registers, pictures
    Exec => exec,
    /// Check a program: macro expansion, instruction words, microseconds, registers
    Asm => asm,
    /// Print the instruction words of a program, as text that reads back to the same words
    Disasm => disasm,
    /// Quantise a kernel (the weights of a receptive field): levels, scale, and what is lost
    Quantise => quantise,
    /// Compile kernels to a program of shifts, additions and halvings, with the proof
    Compile => compile,
    /// Show where the float sensor's events go on the way to the chip, over frame rate and step by step
    Waterfall => waterfall,
    /// Solve, step, fit or draw the resistor mesh (resistive grid)
    Mesh => mesh,
    /// Design a sensor for kernels and a scene: thresholds for a rate, quantiser, memory, program, report
    Design => design,
    /// Find whether a kernel can run on a chip, and what is lost: a page to forward
    Feasibility => feasibility,
    /// Compare two event files: every metric with its floor and ceiling
    Compare => compare,
    /// Convert an event file to another format
    Convert => convert,
    /// Tell what a packet (the events of a sensor over a scene) costs on a link, and what a readout makes of it
    Packets => packets,
    /// Turn an event file into the arrays that networks take: voxels, time surfaces or event frames
    Voxels => voxels,
    /// Find what a model may leave out in a scene, with the limit that allows it
    Plan => plan,
    /// Weigh error against seconds: every plainer model of a sensor in a scene, the front, its knee
    Trade => trade,
    /// Draw a packet: frames, surfaces, clouds, rates, intervals, kinds; or print a sensor by name
    Show => show,
    /// Compute the points of a study on all cores, resumable: results as CSV and JSON lines
    Sweep => sweep,
    /// Merge the folders of a sweep's shards into one
    Merge => merge,
    /// Learn kernels and thresholds for a task, judged at equal bits (with the package `amacrine-learn`)
    Learn => learn,
    /// Find the points of a sweep that no other beats: error against time, bits or instruction words
    Report => report,
    /// Print the keys of a kind of file as JSON Schema: sensor, kernel, study, readout, program, chip
    Schema => schema,
    /// List what comes with the program: sensors, programs, kernels, studies, readouts, chips
    List => list,
    /// Write a file to start from: sensor, kernel, study, readout, program, chip
    New => new,
    /// Print what a shell needs to complete the command line
    Completions => completions,
    /// Write a manual page for each verb
    Man => man,
}

/// Parses the command line, runs the verb, prints what went wrong.
///
/// Exit code 0 when all went well, or nobody reads standard output any more; 1 when standard
/// output takes no more; 2 for bad input, and for outputs that cannot be written.
#[must_use]
pub fn main() -> ExitCode {
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        if !catch_panic::is_catching() {
            hook(panic);
        }
    }));
    print::handle_errors();
    signals::watch();
    let matches = match command().try_get_matches() {
        Ok(matches) if matches.subcommand().is_some() => Ok(matches),
        Ok(_) => command().try_get_matches_from(["amacrine", "demo"]),
        Err(error) => Err(error),
    };
    let parsed = matches.and_then(|matches| {
        let arguments = Arguments::from_arg_matches(&matches)?;
        Ok((matches, arguments))
    });
    let (matches, arguments) = match parsed {
        Ok(parsed) => parsed,
        Err(error) => return print::usage(error, command),
    };
    budget::allow(arguments.max_memory);
    let run = || {
        threads::start(arguments.threads)?;
        files::check(&command(), &matches)?;
        run(arguments)
    };
    match print::until_ended(run) {
        Ok(()) => ExitCode::SUCCESS,
        Err(report) => print::failed(&report),
    }
}

/// The whole command line.
fn command() -> clap::Command {
    fn negative(command: clap::Command) -> clap::Command {
        command
            .mut_args(|argument| {
                // That a number below 0 is none is for whoever reads it to say.
                let takes = argument.get_action().takes_values();
                let time = argument.get_value_parser().type_id() == TypeId::of::<Micros>();
                match (takes, time) {
                    (false, _) => argument,
                    (true, false) => argument.allow_negative_numbers(true),
                    (true, true) => argument.allow_hyphen_values(true),
                }
            })
            .mut_subcommands(negative)
    }
    negative(Arguments::command())
}

/// The first example of each verb.
fn examples() -> String {
    let command = Verb::augment_subcommands(clap::Command::new("amacrine"));
    let first = |verb: &clap::Command| {
        let help = verb.get_after_help()?.to_string();
        let at = help.find("amacrine ")?;
        help[at..].lines().next().map(|line| format!("\n  {line}"))
    };
    let each: String = command.get_subcommands().filter_map(first).collect();
    format!("Examples:\n  amacrine{each}\n\ndocs/glossary.md has the terms, a line each.")
}

/// The verbs, with commas between.
fn verbs() -> String {
    let command = Arguments::command();
    let names: Vec<_> = command
        .get_subcommands()
        .map(clap::Command::get_name)
        .collect();
    names.join(", ")
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;

    /// Arguments that are texts, and no names of files.
    const TEXTS: [&str; 10] = [
        "domain", "schedule", "title", "cost", "into", "keep", "explain", "name", "from", "kind",
    ];

    /// Every argument that is a path is of a kind that [`files::check`] finds.
    #[test]
    fn no_path_goes_around_the_door() {
        fn walk(command: &clap::Command, seen: &mut Vec<String>) {
            for argument in command.get_arguments() {
                let kind = argument.get_value_parser().type_id();
                let name = argument.get_id().as_str();
                let path = kind == TypeId::of::<PathBuf>();
                let text = kind == TypeId::of::<String>() && !TEXTS.contains(&name);
                if path || text {
                    seen.push(format!("{} {name}", command.get_name()));
                }
            }
            for verb in command.get_subcommands() {
                walk(verb, seen);
            }
        }
        let mut seen = Vec::new();
        walk(&Arguments::command(), &mut seen);
        assert!(seen.is_empty(), "paths as plain paths or texts: {seen:?}");
    }
}
