//! Bars of progress.

use std::io::IsTerminal;

use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::{task::Task, train::State};

/// A bar for each job that is being trained; none where nobody looks.
pub(super) struct Bars {
    all: MultiProgress,
    own: Vec<ProgressBar>,
}

impl Bars {
    pub(super) fn new(task: &Task, jobs: usize) -> Self {
        let hidden = !std::io::stderr().is_terminal();
        let target = if hidden {
            ProgressDrawTarget::hidden()
        } else {
            ProgressDrawTarget::stderr()
        };
        let bar = |_| {
            let hidden = ProgressDrawTarget::hidden();
            ProgressBar::with_draw_target(Some(task.steps), hidden)
        };
        Self {
            all: MultiProgress::with_draw_target(target),
            own: (0..jobs).map(bar).collect(),
        }
    }

    pub(super) fn begin(&self, n: usize, name: &str) {
        let template = "{prefix} {bar:30} {pos}/{len} {eta} {msg}";
        if let Ok(style) = ProgressStyle::with_template(template) {
            self.own[n].set_style(style);
        }
        self.own[n].set_prefix(format!("{}/{} {name}", n + 1, self.own.len()));
        self.all.add(self.own[n].clone());
        self.own[n].reset();
    }

    pub(super) fn step(&self, n: usize, state: &State) {
        let [loss, rate] = state.means;
        let words = state
            .words
            .map_or(String::new(), |words| format!(", {words} words"));
        self.own[n].set_position(state.step);
        self.own[n].set_message(format!("loss {loss:.5}, {rate:.4} events/px/pair{words}"));
    }

    pub(super) fn end(&self, n: usize) {
        self.own[n].finish_and_clear();
    }
}
