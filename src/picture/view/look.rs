//! What of a packet is shown, and how.

use crate::unit::Micros;

/// What of a packet is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum View {
    /// Everything on one page.
    #[default]
    Overview,
    /// The events of a window.
    Frame,
    /// The last event of each pixel.
    Surface,
    /// Events in x, y and time.
    Cloud,
    /// Events a second.
    Rate,
    /// Times between events of a cell.
    Intervals,
    /// A frame for each kind.
    Kinds,
}

/// How a packet is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Look<'a> {
    /// What the page is called.
    pub title: &'a str,
    /// What of it.
    pub view: View,
    /// Length of a frame's window, and the time constant of a time surface.
    pub window: Micros,
    /// When frame and surface are taken; else at the end of the busiest window.
    pub at: Option<Micros>,
}
