//! Events and packets: what sensors give, and what is compared.

pub mod address;
pub mod codec;
pub mod file;
mod outside;
pub mod readout;
pub mod tensor;

use std::ops;

pub use outside::Outside;

use crate::{plane::Size, unit::Micros};

/// The sign of an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Polarity {
    /// The drive fell below the negative threshold.
    Off,
    /// The drive rose above the positive threshold.
    On,
}

impl Polarity {
    /// +1 or -1.
    #[inline]
    #[must_use]
    pub const fn sign(self) -> i32 {
        match self {
            Self::Off => -1,
            Self::On => 1,
        }
    }

    /// 1 for ON, 0 for OFF: the `p` of event files.
    #[inline]
    #[must_use]
    pub const fn bit(self) -> u8 {
        match self {
            Self::Off => 0,
            Self::On => 1,
        }
    }

    /// What [`Polarity::bit`] says: ON for a bit that is set.
    #[inline]
    #[must_use]
    pub const fn of(is_on: bool) -> Self {
        if is_on { Self::On } else { Self::Off }
    }
}

/// One address-event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Event {
    /// Time, in whole microseconds.
    pub t: Micros,
    /// Column, in image coordinates: from 0 on the left.
    pub x: u16,
    /// Row, in image coordinates: from 0 at the top.
    pub y: u16,
    /// ON for a rise, OFF for a fall.
    pub polarity: Polarity,
    /// Which kind of ganglion cell, from 0.
    pub channel: u8,
}

/// Events that a sensor made and could not deliver, by reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Dropped {
    /// The readout had fewer slots than there were events.
    pub no_slot: u64,
    /// The bound on the length of the event list was reached.
    pub over_limit: u64,
    /// The queue behind the arbiter was full.
    pub queue_full: u64,
    /// The cell's event before it had not left yet: one request, or one bit, stands for both.
    pub merged: u64,
    /// It lay in a row that the readout does not scan.
    pub unscanned: u64,
}

impl Dropped {
    /// All drops together.
    #[must_use]
    pub const fn total(self) -> u64 {
        self.no_slot
            .saturating_add(self.over_limit)
            .saturating_add(self.queue_full)
            .saturating_add(self.merged)
            .saturating_add(self.unscanned)
    }

    /// Each reason with its count, in words.
    #[must_use]
    pub const fn reasons(self) -> [(&'static str, u64); 5] {
        [
            ("no slot", self.no_slot),
            ("event list full", self.over_limit),
            ("queue full", self.queue_full),
            ("merged with the cell's event before", self.merged),
            ("in rows that are not scanned", self.unscanned),
        ]
    }
}

impl ops::AddAssign for Dropped {
    fn add_assign(&mut self, other: Self) {
        // Counts may come from a file.
        self.no_slot = self.no_slot.saturating_add(other.no_slot);
        self.over_limit = self.over_limit.saturating_add(other.over_limit);
        self.queue_full = self.queue_full.saturating_add(other.queue_full);
        self.merged = self.merged.saturating_add(other.merged);
        self.unscanned = self.unscanned.saturating_add(other.unscanned);
    }
}

/// What kinds of cells are called in packets and files: of several, of which one has a name, the
/// others by their number; none otherwise.
#[must_use]
pub fn kind_names<'a>(kinds: impl Iterator<Item = Option<&'a str>>) -> Vec<String> {
    let kinds: Vec<_> = kinds.collect();
    if kinds.len() < 2 || kinds.iter().all(Option::is_none) {
        return Vec::new();
    }
    let each = kinds.into_iter().enumerate();
    each.map(|(i, name)| name.map_or_else(|| format!("kind {i}"), str::to_owned))
        .collect()
}

/// A packet: all events of one sensor over one scene.
///
/// Events are ordered by time, ties in readout order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Packet {
    /// Size of the sensor.
    pub size: Size,
    /// Number of kinds of cells in each pixel.
    pub channels: u8,
    /// What each kind is called; empty where nobody says so.
    pub names: Vec<String>,
    /// The time span watched: times of the first and of the last frame.
    pub span: (Micros, Micros),
    /// The events.
    pub events: Vec<Event>,
    /// Events that were made and not delivered, by reason.
    pub dropped: Dropped,
}

impl Packet {
    /// A kind by its number, and by what it is called where that is known: `0 centre-on`.
    #[must_use]
    pub fn called(&self, channel: u8) -> String {
        match self.names.get(usize::from(channel)) {
            Some(name) => format!("{channel} {name}"),
            None => channel.to_string(),
        }
    }

    /// Events of each kind, ON and OFF.
    #[must_use]
    pub fn each_kind(&self) -> Vec<[u64; 2]> {
        let mut all = vec![[0; 2]; usize::from(self.channels)];
        for event in &self.events {
            if let Some(own) = all.get_mut(usize::from(event.channel)) {
                own[usize::from(event.polarity == Polarity::Off)] += 1;
            }
        }
        all
    }

    /// An empty packet.
    #[must_use]
    pub const fn new(size: Size, channels: u8) -> Self {
        Self {
            size,
            channels,
            names: Vec::new(),
            span: (Micros(0), Micros(0)),
            events: Vec::new(),
            dropped: Dropped {
                no_slot: 0,
                over_limit: 0,
                queue_full: 0,
                merged: 0,
                unscanned: 0,
            },
        }
    }

    /// Memory of `events` events in a packet, bytes.
    #[must_use]
    pub const fn bytes(events: u64) -> u128 {
        events as u128 * size_of::<Event>() as u128
    }

    /// The first event that lies outside of its size and its channels.
    #[must_use]
    pub fn outside(&self) -> Option<&Event> {
        outside::first(&self.events, self.size, self.channels)
    }

    /// The events in an order that does not depend on the readout:
    /// time, row, column, channel, polarity. Two packets hold the same events exactly when
    /// these are equal.
    #[must_use]
    pub fn canonical(&self) -> Vec<Event> {
        let mut events = self.events.clone();
        events.sort_unstable_by_key(|e| (e.t, e.y, e.x, e.channel, e.polarity));
        events
    }
}
