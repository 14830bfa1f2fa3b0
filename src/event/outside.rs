//! Events that their own packet has no cell for.

use super::Event;
use crate::{plane::Size, unit::counted};

/// An event that its own packet has no cell for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("an event at x {}, y {} of channel {} in a packet of {size} and {}", event.x, event.y, event.channel, counted(*channels, "channel"))]
#[diagnostic(help("the packet is inconsistent: correct its size, its channels or the event"))]
pub struct Outside {
    /// The event.
    pub event: Event,
    /// Size of its packet.
    pub size: Size,
    /// Channels of its packet.
    pub channels: u8,
}

impl Event {
    /// Whether a sensor of this size with so many kinds of cells has a cell for it.
    pub(crate) fn is_inside(&self, size: Size, channels: u8) -> bool {
        usize::from(self.x) < size.width
            && usize::from(self.y) < size.height
            && self.channel < channels
    }
}

/// The first event that such a sensor has no cell for.
pub(super) fn first(events: &[Event], size: Size, channels: u8) -> Option<&Event> {
    // All of them at once first: this runs in vectors.
    let all = events
        .iter()
        .fold(true, |all, event| all & event.is_inside(size, channels));
    if all {
        return None;
    }
    events.iter().find(|event| !event.is_inside(size, channels))
}

/// Refuses events that such a sensor has no cell for.
pub(super) fn check(events: &[Event], size: Size, channels: u8) -> Result<(), Outside> {
    first(events, size, channels).map_or(Ok(()), |event| {
        Err(Outside {
            event: *event,
            size,
            channels,
        })
    })
}
