//! Options of the command line in messages, as Python and a study say them.
//!
//! Messages of the library advise options as they are typed: `--fps 240`. Whoever calls a function has
//! arguments, and a study has keys. [`OPTIONS`] is the list of all options that messages name, with how
//! the others say each; `tests/advice.rs` reads the sources for one that is not in it.
//!
//! Commands in backticks (`` `amacrine convert --sort` ``) are typed in a terminal: they are left as
//! they are.

mod advised;
mod list;
mod python;
mod study;

pub use advised::{Advised, InPython, InStudy};
pub use list::OPTIONS;
pub use python::in_python;
pub use study::in_study;

/// Whether what stands between two backticks is a command, and no option alone.
fn is_command(place: usize, part: &str) -> bool {
    place % 2 == 1 && !part.starts_with("--")
}
