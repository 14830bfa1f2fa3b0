//! The window of matches, as every verb that judges events asks for it.

use super::heading;
use crate::{compare::window, unit::Micros};

/// Which events match.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(in crate::cli) struct Window {
    /// Largest time difference of events that match [default: 100ms, or a frame interval if longer]
    ///
    /// Events that match are of the same pixel, kind and sign.
    #[arg(long, value_name = "TIME", help_heading = heading::COMPARISON)]
    pub within: Option<Micros>,
}

impl Window {
    /// The window at this many frames a second.
    pub(in crate::cli) fn at(self, fps: f64) -> Micros {
        self.within.unwrap_or_else(|| window::headline(fps))
    }
}
