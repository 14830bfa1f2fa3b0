//! What verbs print and write.
//!
//! - [`print`]: all that is printed; [`progress`]: a bar while something takes its time.
//! - [`files`]: the files of one command; [`content`]: what they hold, by their endings;
//!   [`event_output`]: the events of a run; [`signals`]: what is removed when a signal ends the program.
//! - [`readout_table`]: the ways to read a frame's events, as a table; [`command_line`]: commands that
//!   are printed for a shell.
//! - [`thread_clock`], [`timed`]: how long a thread or a sensor took.

pub(super) mod command_line;
pub(super) mod content;
pub(super) mod event_output;
pub(super) mod files;
pub(super) mod print;
pub(super) mod progress;
pub(super) mod readout_table;
pub(super) mod signals;
pub(super) mod thread_clock;
pub(super) mod timed;
