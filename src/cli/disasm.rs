//! `amacrine disasm`.

use super::input::opened_program::{Opened, Source};
use crate::program::vendor_text;

/// What `disasm` is asked to do.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: amacrine disasm convolve/sobel > words.scamp")]
pub struct Arguments {
    #[command(flatten)]
    source: Source,
}

/// Runs the verb.
///
/// # Errors
/// One diagnostic that names what was wrong.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    let Opened {
        program,
        device,
        expansion,
        ..
    } = arguments.source.open(&[])?;
    super::say(&program.settings.names_line());
    super::say(&vendor_text(&expansion.code, expansion.bare, &device));
    Ok(())
}
