//! All that is printed, and what becomes of the program when nobody takes it.

use std::{
    fmt,
    io::{self, Write},
    panic,
    process::ExitCode,
    sync::atomic::{AtomicBool, Ordering},
};

use miette::{Diagnostic, MietteHandlerOpts, ReportHandler, miette};
use textwrap::{WordSeparator, WordSplitter};

use crate::{save, told::Told};

/// Whether an output goes to standard output, and what is said beside it.
static ASIDE: AtomicBool = AtomicBool::new(false);

/// From now on what is said goes to standard error: standard output has another use.
pub(super) fn aside() {
    ASIDE.store(true, Ordering::Relaxed);
}

/// Prints to standard output. A reader that has gone (`amacrine … | head`) ends the program
/// quietly; anything else that stands in the way ends it with exit code 1.
pub(super) fn say(text: &str) {
    if ASIDE.load(Ordering::Relaxed) {
        return complain(text);
    }
    let mut out = io::stdout().lock();
    let said = out.write_all(text.as_bytes()).and_then(|()| out.flush());
    if let Err(cause) = said {
        // Up to `until_ended`, past whatever is being done: no panic, and nothing is printed.
        panic::resume_unwind(Box::new(Ended(lost(&cause))));
    }
}

/// The program ends with this code; all that is to be said of it has been said.
#[derive(Clone, Copy, Debug, thiserror::Error, miette::Diagnostic)]
#[error("ends with {0}")]
pub(super) struct Ended(pub(super) u8);

/// Runs until all is done, or an output is [`Ended`].
pub(super) fn until_ended(run: impl FnOnce() -> miette::Result<()>) -> miette::Result<()> {
    panic::catch_unwind(panic::AssertUnwindSafe(run)).unwrap_or_else(|payload| {
        match payload.downcast_ref::<Ended>() {
            Some(ended) => Err((*ended).into()),
            None => panic::resume_unwind(payload),
        }
    })
}

/// How errors are printed: lines break at spaces only, so that a name such as `rgc-on-chip` can be
/// copied, and a cause that a message has in it is not told again.
struct Handler;

impl ReportHandler for Handler {
    fn debug(&self, error: &dyn Diagnostic, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let options = MietteHandlerOpts::new()
            .word_separator(WordSeparator::AsciiSpace)
            .word_splitter(WordSplitter::NoHyphenation)
            .break_words(false);
        options.build().debug(&Told::new(error), f)
    }
}

/// From now on errors are printed so.
pub(super) fn handle_errors() {
    // It can only fail where there is a handler already.
    let _ = miette::set_hook(Box::new(|_| Box::new(Handler)));
}

/// Prints to standard error. There is nobody to tell when that fails.
pub(super) fn complain(text: &str) {
    let _ = io::stderr().lock().write_all(text.as_bytes());
}

/// Prints what went wrong; the exit code.
pub(super) fn failed(report: &miette::Report) -> ExitCode {
    if let Some(Ended(code)) = report.downcast_ref() {
        save::remove_all();
        return ExitCode::from(*code);
    }
    if save::reader_is_gone() {
        return ExitCode::SUCCESS;
    }
    complain(&format!("{report:?}\n"));
    ExitCode::from(2)
}

/// Prints help, a version, or what is wrong with the command line; the exit code.
pub(super) fn usage(error: &clap::Error) -> ExitCode {
    if let Some(plain) = unread_number(error) {
        complain(&plain);
        return ExitCode::from(2);
    }
    let printed = error.print();
    if error.use_stderr() {
        return ExitCode::from(2);
    }
    match printed.and_then(|()| io::stdout().flush()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(cause) => ExitCode::from(lost(&cause)),
    }
}

/// What is said of a number that is none, in words that say what is expected.
fn unread_number(error: &clap::Error) -> Option<String> {
    const WORDS: [(&str, &str); 4] = [
        (
            "invalid digit found in string",
            "give a whole number, from 0 on",
        ),
        (
            "cannot parse integer from empty string",
            "give a whole number, from 0 on",
        ),
        (
            "number too large to fit in target type",
            "give a smaller number",
        ),
        ("invalid float literal", "give a number, such as 0.5"),
    ];
    let said = error.render().to_string();
    let (cause, expected) = WORDS.iter().find(|(cause, _)| said.contains(cause))?;
    Some(said.replace(cause, expected))
}

/// Standard output takes no more; the exit code.
fn lost(cause: &io::Error) -> u8 {
    if cause.kind() == io::ErrorKind::BrokenPipe {
        return 0;
    }
    let report = miette!(
        help = "files that were asked for are complete; give standard output a place with room",
        "cannot write to standard output: {cause}"
    );
    complain(&format!("{report:?}\n"));
    1
}
