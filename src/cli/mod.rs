//! The command line: one file a verb, and the only place that prints.

pub mod asm;
mod budget;
pub mod compare;
pub mod compile;
pub mod content;
pub mod convert;
mod debug;
pub mod demo;
pub mod disasm;
pub mod exec;
pub mod feasibility;
mod fidelity;
pub mod files;
mod kernels;
pub mod merge;
pub mod mesh;
mod opened;
pub mod packets;
pub mod plan;
mod print;
mod progress;
pub mod quantise;
mod readout;
mod recording;
mod registers;
pub mod report;
pub mod run;
pub mod show;
mod signals;
mod statistics;
mod strip;
pub mod sweep;
mod timed;
pub mod waterfall;

use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

use self::print::{complain, say};
use crate::{catch_panic, memory::Budget};

/// One for each verb, as `amacrine help` shows them.
const EXAMPLES: &str = "\
Examples:
  amacrine
  amacrine run --scene clip.mp4 --sensor sensors/dvs.toml --upsample 0.1 --events events.npy
  amacrine exec programs/convolve/sobel.scamp --image frame.png --dump registers
  amacrine asm programs/rgc/centre_surround.scamp
  amacrine quantise rgc-5x5 --to ternary --sum zero
  amacrine compile sobel-x --filter-only
  amacrine waterfall rgc-5x5 --to int-5 --threshold 128 -o waterfall.svg
  amacrine mesh solve --lambda 10 --input P.npy --output H.npy
  amacrine feasibility --kernel rgc-5x5 --threshold 128 -o report.html
  amacrine compare out/reference.npy out/silicon.npy --within 1ms
  amacrine convert recording.raw part.aedat4 --slice 1s..2.5s
  amacrine packets out/silicon.npy --readout arbiter
  amacrine plan --scene clip.mp4 --sensor sensors/dvs-v2e.toml --tolerance 1% --verify
  amacrine show out/silicon.npy -o picture.png
  amacrine sweep studies/formats.toml --output out/formats
  amacrine merge out/shard-0 out/shard-1 --output out/all
  amacrine report out/formats -o front.svg";

/// What real silicon does to the retina's computation.
#[derive(Debug, Parser)]
#[command(name = "amacrine", version, about, after_help = EXAMPLES)]
struct Arguments {
    /// The most memory to hold, such as 500M or 4G (powers of 1024); more is refused before the work [default: three quarters of the machine's]
    #[arg(long, global = true, value_name = "SIZE")]
    max_memory: Option<Budget>,
    #[command(subcommand)]
    verb: Option<Verb>,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// A real clip through the float reference and through a program on the array
    Demo(demo::Arguments),
    /// A scene through a sensor file: events, counts, voxels
    Run(run::Arguments),
    /// A program on the array: every register written out
    Exec(exec::Arguments),
    /// Check a program: expansion, words, microseconds, registers
    Asm(asm::Arguments),
    /// The instruction words of a program, as text that reads back to the same words
    Disasm(disasm::Arguments),
    /// A kernel in few values: levels, scale, and what is lost
    Quantise(quantise::Arguments),
    /// Kernels to a program: shift, add, halve, with the proof
    Compile(compile::Arguments),
    /// Where the events of the float sensor go, step by step, on the way to the chip
    Waterfall(waterfall::Arguments),
    /// The resistor mesh: solve it, step it, fit a kernel to it, draw it
    Mesh(mesh::Arguments),
    /// Whether a kernel can run on a chip, and what is lost, as a page to forward
    Feasibility(feasibility::Arguments),
    /// Compare two event files
    Compare(compare::Arguments),
    /// An event file into another format
    Convert(convert::Arguments),
    /// What a packet costs on a link, and what a readout makes of it
    Packets(packets::Arguments),
    /// What a model may leave out of a scene, with the bound that allows it
    Plan(plan::Arguments),
    /// Pictures of a packet: frames, surfaces, clouds, rates, intervals, kinds
    Show(show::Arguments),
    /// Many points of a study, on all cores, resumable: results as CSV and JSON lines
    Sweep(sweep::Arguments),
    /// The folders of a sweep's shards into one
    Merge(merge::Arguments),
    /// Which points of a sweep no other beats: error against time, bits or words
    Report(report::Arguments),
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
    signals::watch();
    let command = || Arguments::command();
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
        Err(error) => return print::usage(&error),
    };
    budget::allow(arguments.max_memory);
    match files::check(&command(), &matches).and_then(|()| run(arguments)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(report) => print::failed(&report),
    }
}

fn run(arguments: Arguments) -> miette::Result<()> {
    match arguments.verb {
        None => Ok(()),
        Some(Verb::Demo(arguments)) => demo::run(&arguments),
        Some(Verb::Run(arguments)) => run::run(&arguments),
        Some(Verb::Exec(arguments)) => exec::run(&arguments),
        Some(Verb::Asm(arguments)) => asm::run(&arguments),
        Some(Verb::Disasm(arguments)) => disasm::run(&arguments),
        Some(Verb::Quantise(arguments)) => quantise::run(&arguments),
        Some(Verb::Compile(arguments)) => compile::run(&arguments),
        Some(Verb::Waterfall(arguments)) => waterfall::run(&arguments),
        Some(Verb::Mesh(arguments)) => mesh::run(&arguments),
        Some(Verb::Feasibility(arguments)) => feasibility::run(&arguments),
        Some(Verb::Compare(arguments)) => compare::run(&arguments),
        Some(Verb::Convert(arguments)) => convert::run(&arguments),
        Some(Verb::Packets(arguments)) => packets::run(&arguments),
        Some(Verb::Plan(arguments)) => plan::run(&arguments),
        Some(Verb::Show(arguments)) => show::run(&arguments),
        Some(Verb::Sweep(arguments)) => sweep::run(&arguments),
        Some(Verb::Merge(arguments)) => merge::run(&arguments),
        Some(Verb::Report(arguments)) => report::run(&arguments),
    }
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
    use std::{any::TypeId, path::PathBuf};

    use super::*;

    /// Arguments that are texts, and no names of files.
    const TEXTS: [&str; 7] = ["domain", "schedule", "title", "cost", "into", "keep", ""];

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
