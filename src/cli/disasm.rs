//! `amacrine disasm`.

use super::input::opened_program::Source;

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
    let opened = arguments.source.open(&[])?;
    super::say(&arguments.source.words(&opened));
    Ok(())
}
