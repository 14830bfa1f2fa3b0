//! A bar on a terminal while something takes its time; nothing elsewhere.

use indicatif::{ProgressBar, ProgressStyle};

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
            ProgressStyle::with_template("{msg:10} {bar:40} {pos}/{len} {elapsed} left {eta}")
        } else {
            ProgressStyle::with_template("{msg:10} {spinner} {pos} {elapsed}")
        };
        if let Ok(style) = style {
            bar.set_style(style);
        }
        bar.set_message(what);
        Self(bar)
    }

    /// One step is done.
    pub fn tick(&self) {
        self.0.inc(1);
    }

    /// Nothing is left to do.
    pub fn finish(&self) {
        self.0.finish_and_clear();
    }
}
