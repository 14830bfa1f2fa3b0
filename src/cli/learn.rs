//! `amacrine learn`: hands over to `amacrine-learn`, which is built apart from this program.

use std::{
    env,
    ffi::OsString,
    io,
    path::{Path, PathBuf},
    process::Command,
};

use miette::{IntoDiagnostic, WrapErr, miette};

use super::arguments::{budget::budget, threads};
use crate::memory::Origin;

/// What `learn` is asked to do.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  amacrine learn tasks/interpolation.toml -o runs/interpolation\n  amacrine learn tasks/interpolation.toml -o runs/interpolation --arm ternary --resume\n  amacrine learn report runs/interpolation\n\n`amacrine-learn --help` lists all options; docs/guides/learn-a-kernel.md goes through them."
)]
pub struct Arguments {
    /// Arguments of `amacrine-learn`: TASK.toml -o RUN and options, or report RUN
    #[arg(
        value_name = "ARGUMENTS",
        trailing_var_arg = true,
        allow_hyphen_values = true
    )]
    handed_over: Vec<OsString>,
}

/// The program that learns.
const NAME: &str = "amacrine-learn";

/// Runs the verb.
///
/// # Errors
/// When there is no `amacrine-learn`, or it cannot be started.
pub fn run(arguments: &Arguments) -> miette::Result<()> {
    let program = find().ok_or_else(|| {
        miette!(
            help = "build it in the repository: cargo install --path learn",
            "there is no `{NAME}`, neither beside this program nor on the PATH"
        )
    })?;
    let mut command = Command::new(&program);
    // Given before what is handed over they are options of every verb.
    if let Some(threads) = threads::asked() {
        command.arg(format!("--threads={threads}"));
    }
    let budget = budget();
    if budget.by == Origin::Asked {
        command.arg(format!("--max-memory={}", budget.bytes));
    }
    command.args(&arguments.handed_over);
    become_it(command)
        .into_diagnostic()
        .wrap_err_with(|| format!("{}: it cannot be started", program.display()))?
}

/// Runs it in place of this program, so that a signal ends what learns.
#[cfg(unix)]
fn become_it(mut command: Command) -> io::Result<miette::Result<()>> {
    use std::os::unix::process::CommandExt as _;
    Err(command.exec())
}

/// Runs it, and ends as it does.
#[cfg(not(unix))]
fn become_it(mut command: Command) -> io::Result<miette::Result<()>> {
    let status = command.status()?;
    if status.success() {
        return Ok(Ok(()));
    }
    // It has said what is wrong.
    let code = status.code().and_then(|code| u8::try_from(code).ok());
    Ok(Err(super::output::print::Ended(code.unwrap_or(2)).into()))
}

/// Beside this program, else on the PATH.
fn find() -> Option<PathBuf> {
    let name = format!("{NAME}{}", env::consts::EXE_SUFFIX);
    let own = env::current_exe().ok();
    let beside = own.as_deref().and_then(Path::parent).map(Path::to_owned);
    let path = env::var_os("PATH").unwrap_or_default();
    let folders = beside.into_iter().chain(env::split_paths(&path));
    folders
        .map(|folder| folder.join(&name))
        .find(|file| file.is_file())
}
