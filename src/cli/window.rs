//! The window of matches, as every verb that judges events asks for it.

use crate::{compare::window, unit::Micros};

/// Which events match.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(super) struct Window {
    /// Events of one pixel, kind and sign match when their times differ by at most this
    /// [default: 100ms, or the time from frame to frame where that is longer]
    #[arg(long, value_name = "TIME")]
    pub within: Option<Micros>,
}

impl Window {
    /// The window at this many frames a second.
    pub(super) fn at(self, fps: f64) -> Micros {
        self.within.unwrap_or_else(|| window::headline(fps))
    }
}
