//! How long a list may become.

/// What to do when a list would grow beyond its bound.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum WhenFull {
    /// Stop with an error.
    #[default]
    Stop,
    /// Drop further events and count them in [`crate::event::Dropped::over_limit`].
    Drop,
}

/// A bound on the length of an event list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limit {
    /// How many events a packet may hold.
    pub events: usize,
    /// What happens beyond.
    pub when_full: WhenFull,
}

impl Default for Limit {
    /// A hundred million events, 1.6 GB, then an error.
    fn default() -> Self {
        Self {
            events: 100_000_000,
            when_full: WhenFull::Stop,
        }
    }
}
