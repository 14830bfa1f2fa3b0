//! `amacrine-learn`: learns the arms of a task.

use std::process::ExitCode;

use amacrine_learn::cli::{Arguments, failed, run};
use clap::Parser;

fn main() -> ExitCode {
    match run(Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(report) => failed(&report),
    }
}
