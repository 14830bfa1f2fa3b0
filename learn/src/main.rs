//! `amacrine-learn`: learns the arms of a task.

use clap::Parser;

fn main() -> miette::Result<()> {
    amacrine_learn::cli::run(amacrine_learn::cli::Arguments::parse())
}
