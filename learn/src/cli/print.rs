//! All that is printed, and what becomes of the program when nobody takes it.

use std::{
    fmt,
    io::{self, Write},
    process::ExitCode,
};

use amacrine::told::Told;
use miette::{Diagnostic, MietteHandlerOpts, Report, ReportHandler, Result, miette};

/// The program ends with this code; all that is to be said of it has been said.
#[derive(Clone, Copy, Debug, thiserror::Error, miette::Diagnostic)]
#[error("ends with {0}")]
struct Ended(u8);

/// Prints to standard output.
///
/// # Errors
/// When it takes no more: a reader that has gone (`amacrine-learn … | head`) ends the program quietly.
pub(super) fn say(text: &str) -> Result<()> {
    let mut out = io::stdout().lock();
    let said = out.write_all(text.as_bytes()).and_then(|()| out.flush());
    said.map_err(|cause| lost(&cause).into())
}

/// Prints to standard error. There is nobody to tell when that fails.
pub(super) fn complain(text: &str) {
    let _ = io::stderr().lock().write_all(text.as_bytes());
}

/// How errors are printed: a cause that a message has in it is not told again.
struct Handler;

impl ReportHandler for Handler {
    fn debug(&self, error: &dyn Diagnostic, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let handler = MietteHandlerOpts::new().build();
        handler.debug(&Told::new(error), f)
    }
}

/// From now on errors are printed so.
pub(super) fn handle_errors() {
    // It can only fail where there is a handler already.
    let _ = miette::set_hook(Box::new(|_| Box::new(Handler)));
}

/// Prints what went wrong; the exit code.
#[must_use]
pub fn failed(report: &Report) -> ExitCode {
    if let Some(Ended(code)) = report.downcast_ref() {
        return ExitCode::from(*code);
    }
    complain(&format!("{report:?}\n"));
    ExitCode::from(2)
}

/// Standard output takes no more.
fn lost(cause: &io::Error) -> Ended {
    if cause.kind() == io::ErrorKind::BrokenPipe {
        return Ended(0);
    }
    let report = miette!(
        help = "files that were made are complete; give standard output a place with room",
        "cannot write to standard output: {cause}"
    );
    complain(&format!("{report:?}\n"));
    Ended(1)
}
