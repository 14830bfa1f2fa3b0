//! A bar on a terminal while something takes its time; nothing elsewhere.

use std::{borrow::Cow, fmt, time::Duration};

use indicatif::{HumanDuration, ProgressBar, ProgressFinish, ProgressState, ProgressStyle};

/// From one picture of a spinner to the next.
const TICK: Duration = Duration::from_millis(100);

/// From one time that is shown to the next.
const SECOND: Duration = Duration::from_secs(1);

/// How long the rest takes; before the first step nothing is known of it.
fn left(state: &ProgressState, out: &mut dyn fmt::Write) {
    // What cannot be shown is left out.
    let _ = match state.pos() {
        0 => out.write_str("?"),
        _ => write!(out, "{:#}", HumanDuration(state.eta())),
    };
}

/// How far some work has come.
#[derive(Debug)]
pub struct Progress(ProgressBar);

impl Progress {
    /// Work of so many steps, where that is known.
    #[must_use]
    pub fn new(what: &'static str, steps: Option<u64>) -> Self {
        let bar = match steps {
            Some(steps) => ProgressBar::new(steps),
            None => ProgressBar::no_length(),
        };
        let style = if steps.is_some() {
            ProgressStyle::with_template("{msg:10} {bar:40} {pos}/{len} {elapsed} left {left}")
                .map(|style| style.with_key("left", left))
        } else {
            ProgressStyle::with_template("{msg:10} {spinner} {pos} {elapsed}")
        };
        if let Ok(style) = style {
            bar.set_style(style);
        }
        bar.set_message(what);
        bar.enable_steady_tick(SECOND);
        Self(bar)
    }

    /// One step is done.
    pub fn tick(&self) {
        self.0.inc(1);
    }

    /// So many steps are done.
    pub fn at(&self, step: u64) {
        self.0.set_position(step);
    }

    /// Work that takes its time, and does not say how far it has come.
    #[must_use]
    pub fn spinner(what: impl Into<Cow<'static, str>>) -> Self {
        let bar = ProgressBar::new_spinner().with_finish(ProgressFinish::AndClear);
        if let Ok(style) = ProgressStyle::with_template("{msg} {spinner} {elapsed}") {
            bar.set_style(style);
        }
        bar.set_message(what);
        bar.enable_steady_tick(TICK);
        Self(bar)
    }

    /// Prints something else beside it.
    pub fn aside(&self, print: impl FnOnce()) {
        self.0.suspend(print);
    }

    /// What is done now.
    pub fn says(&self, what: impl Into<Cow<'static, str>>) {
        self.0.set_message(what);
    }

    /// Nothing is left to do.
    pub fn finish(&self) {
        self.0.finish_and_clear();
    }
}
