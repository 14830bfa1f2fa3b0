//! All that is printed, and what becomes of the program when nobody takes it.

use std::{
    fmt,
    io::{self, Write},
    panic,
    process::ExitCode,
    sync::atomic::{AtomicBool, Ordering},
};

use clap::error::{ContextKind, ContextValue, ErrorKind};
use miette::{Diagnostic, MietteHandlerOpts, ReportHandler, miette};
use textwrap::{WordSeparator, WordSplitter};

use super::files;
use crate::{config::nearest, save, told::Told};

/// Whether an output goes to standard output, and what is said beside it.
static ASIDE: AtomicBool = AtomicBool::new(false);

/// From now on what is said goes to standard error: standard output has another use.
pub(super) fn aside() {
    ASIDE.store(true, Ordering::Relaxed);
}

/// Prints to standard output. A reader that has gone (`amacrine … | head`) ends the program
/// quietly; anything else that stands in the way ends it with exit code 1.
pub(in crate::cli) fn say(text: &str) {
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
pub(in crate::cli) struct Ended(pub(in crate::cli) u8);

/// Runs until all is done, or an output is [`Ended`].
pub(in crate::cli) fn until_ended(run: impl FnOnce() -> miette::Result<()>) -> miette::Result<()> {
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
pub(in crate::cli) fn handle_errors() {
    // It can only fail where there is a handler already.
    let _ = miette::set_hook(Box::new(|_| Box::new(Handler)));
}

/// Prints to standard error. There is nobody to tell when that fails.
pub(in crate::cli) fn complain(text: &str) {
    let _ = io::stderr().lock().write_all(text.as_bytes());
}

/// Prints what went wrong; the exit code.
pub(in crate::cli) fn failed(report: &miette::Report) -> ExitCode {
    if let Some(Ended(code)) = report.downcast_ref() {
        save::remove_all();
        return ended(*code);
    }
    if save::reader_is_gone() {
        return ended(0);
    }
    complain(&format!("{report:?}\n"));
    ExitCode::from(2)
}

/// Names; of more than three the first three, and how many more.
fn first_of(names: &[String]) -> String {
    const TOLD: usize = 3;
    let (told, more) = names.split_at(names.len().min(TOLD));
    let told = told.join(", ");
    match more.len() {
        0 => told,
        more => format!("{told} and {more} more"),
    }
}

/// The exit code of what ended early since nobody takes an output: files that it was to write as well
/// are no success.
fn ended(code: u8) -> ExitCode {
    if code != 0 {
        return ExitCode::from(code);
    }
    let missing = files::unwritten();
    if missing.is_empty() {
        return ExitCode::SUCCESS;
    }
    let report = miette!(
        help = "read all of the output, or write it to a file",
        "{}: not written, since the reader of another output has gone",
        first_of(&missing)
    );
    complain(&format!("{report:?}\n"));
    ExitCode::from(2)
}

/// Prints help, a version, or what is wrong with the command line; the exit code.
pub(in crate::cli) fn usage(mut error: clap::Error, command: fn() -> clap::Command) -> ExitCode {
    suggest_verb(&mut error, &command());
    suggest_option(&mut error, &command());
    if let Some(plain) = unread_number(&error, command) {
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

/// Adds the verb that was meant to the message of one that is none, where only we find one near.
fn suggest_verb(error: &mut clap::Error, command: &clap::Command) {
    if error.kind() != ErrorKind::InvalidSubcommand
        || error.get(ContextKind::SuggestedSubcommand).is_some()
    {
        return;
    }
    let Some(ContextValue::String(given)) = error.get(ContextKind::InvalidSubcommand) else {
        return;
    };
    let verbs = command.get_subcommands().map(clap::Command::get_name);
    if let Some(near) = nearest(given, verbs) {
        let near = ContextValue::Strings(vec![near.to_owned()]);
        error.insert(ContextKind::SuggestedSubcommand, near);
    }
}

/// What other programs call the cut of a clip, and how ours is asked for.
const CUTS: [(&[&str], &str, &str); 2] = [
    (
        &["--frames", "--start", "--stop", "--end", "--duration"],
        "slice",
        "'--slice ..100' shows the first 100 frames, '--slice 2s..5s' three seconds",
    ),
    (
        &["--width", "--height", "--size"],
        "resize",
        "'--resize 128x96' shows the scene to so many pixels, '--crop 128x96' its middle",
    ),
];

/// Says how a clip is cut where an option of another program was given, and this verb cuts clips.
fn suggest_option(error: &mut clap::Error, command: &clap::Command) {
    let Some(ContextValue::String(given)) = error.get(ContextKind::InvalidArg) else {
        return;
    };
    let given = given.split('=').next().unwrap_or_default();
    let verb = std::env::args().find_map(|word| command.find_subcommand(word));
    let has = |id: &str| verb.is_some_and(|verb| verb.get_arguments().any(|it| it.get_id() == id));
    let cut = { CUTS.iter() }.find(|(names, ours, _)| names.contains(&given) && has(ours));
    if let Some((.., tip)) = cut.filter(|_| error.kind() == ErrorKind::UnknownArgument) {
        error.remove(ContextKind::SuggestedArg);
        // It names the option that was suggested.
        error.remove(ContextKind::Usage);
        let tip = ContextValue::StyledStrs(vec![(*tip).into()]);
        error.insert(ContextKind::Suggested, tip);
    }
}

/// What is said of a number that is none, or beyond what an option takes, in words that say what is
/// expected.
fn unread_number(error: &clap::Error, command: fn() -> clap::Command) -> Option<String> {
    const NO_NUMBER: [&str; 2] = [
        "invalid digit found in string",
        "cannot parse integer from empty string",
    ];
    const WORDS: [(&str, &str); 2] = [
        (
            "number too large to fit in target type",
            "give a smaller number",
        ),
        ("invalid float literal", "give a number, such as 0.5"),
    ];
    let said = error.render().to_string();
    if let Some((cause, expected)) = WORDS.iter().find(|(cause, _)| said.contains(cause)) {
        return Some(said.replace(cause, expected));
    }
    if let Some((cause, expected)) = beyond(&said) {
        return Some(said.replace(&cause, &expected));
    }
    let cause = NO_NUMBER.iter().find(|cause| said.contains(**cause))?;
    let expected = with_0(error, command)
        .and_then(|zero| beyond(&zero))
        .map_or_else(
            || "give a whole number, from 0 on".to_owned(),
            |(_, expected)| expected,
        );
    Some(said.replace(cause, &expected))
}

/// What clap says of a number beyond the range of an option, and the same in words.
fn beyond(said: &str) -> Option<(String, String)> {
    let (before, after) = said.split_once(" is not in ")?;
    let number = before.rsplit(' ').next()?;
    let range = after.split_whitespace().next()?;
    let (least, most) = range.split_once("..").filter(|ends| !ends.0.is_empty())?;
    let most = most.trim_start_matches('=');
    // The ends of the types of numbers are no limits that anybody has set.
    let ends = [u32::MAX.into(), i64::MAX as u64, u64::MAX];
    let is_open = |most: &str| most.parse().map_or(true, |most| ends.contains(&most));
    let words = if is_open(most) {
        format!("give a whole number from {least} on")
    } else {
        format!("give a whole number from {least} to {most}")
    };
    Some((format!("{number} is not in {range}"), words))
}

/// What is said of the same command with 0 in the place of a number that cannot be read: clap names
/// the range of an option only to a number beyond it.
fn with_0(error: &clap::Error, command: fn() -> clap::Command) -> Option<String> {
    let (Some(ContextValue::String(value)), Some(option)) = (
        error.get(ContextKind::InvalidValue),
        error.get(ContextKind::InvalidArg),
    ) else {
        return None;
    };
    let assigned = format!("={value}");
    let arguments = std::env::args_os().map(|argument| {
        let text = argument.to_string_lossy().into_owned();
        if text == *value {
            return "0".into();
        }
        match text.strip_suffix(&assigned) {
            Some(option) => format!("{option}=0").into(),
            None => argument,
        }
    });
    let again = command().try_get_matches_from(arguments).err()?;
    (again.get(ContextKind::InvalidArg) == Some(option)).then(|| again.render().to_string())
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

#[cfg(test)]
mod tests {
    use super::first_of;

    #[test]
    fn of_many_names_the_first_are_told() {
        let names = |count: usize| (1..=count).map(|n| format!("{n}.npy")).collect::<Vec<_>>();
        assert_eq!(first_of(&names(1)), "1.npy");
        assert_eq!(first_of(&names(3)), "1.npy, 2.npy, 3.npy");
        assert_eq!(first_of(&names(42)), "1.npy, 2.npy, 3.npy and 39 more");
    }
}
