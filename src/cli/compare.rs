//! `amacrine compare`.

/// What `compare` is asked to do.
#[derive(Debug, Default, clap::Args)]
pub struct Arguments {}

/// Runs the verb.
///
/// # Errors
/// One diagnostic that names what was wrong.
pub fn run(_arguments: &Arguments) -> miette::Result<()> {
    Err(miette::miette!("not built yet"))
}
