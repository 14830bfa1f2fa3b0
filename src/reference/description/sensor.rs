//! Everything that a sensor file states.

use crate::{event::kind_names, photoreceptor::Response, reference::noise::Noise};

use super::{
    channel::Channel,
    rules::{Border, MemoryRule, PolarityRule, Refractory},
};

/// Everything that makes one sensor different from another.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// What it is called.
    pub name: String,
    /// From light to signal.
    pub response: Response,
    /// What an event does to the memory.
    pub memory: MemoryRule,
    /// Whether all kinds of a pixel have one memory of it; only with [`MemoryRule::RawSnap`].
    pub shared: bool,
    /// Where an event's sign comes from.
    pub polarity: PolarityRule,
    /// What lies off the array.
    pub border: Border,
    /// How long a cell is silent after an event.
    pub refractory: Refractory,
    /// What disturbs it.
    pub noise: Noise,
    /// The kinds of cells, at least one.
    pub channels: Vec<Channel>,
}

impl Description {
    /// What the kinds of cells are called, for packets and files: of several, of which one has a
    /// name; none otherwise.
    #[must_use]
    pub fn names(&self) -> Vec<String> {
        kind_names(self.channels.iter().map(|kind| kind.name.as_deref()))
    }
}
