//! What a writer needs to know before the events.

use super::about::About;
use crate::{
    event::{Dropped, Packet},
    plane::Size,
    unit::Micros,
};

/// How the packets of an AEDAT4 file are compressed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Compression {
    /// LZ4: every reader knows it.
    #[default]
    Lz4,
    /// Zstandard: smaller; not all readers know it.
    Zstd,
    /// Not compressed.
    None,
}

impl Compression {
    /// Its name in `--compression`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Lz4 => "lz4",
            Self::Zstd => "zstd",
            Self::None => "none",
        }
    }
}

/// All of a packet but its events, which a file may say at its start.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Head {
    /// Size of the sensor.
    pub size: Size,
    /// Kinds of cells.
    pub channels: u8,
    /// What each is called; empty where nobody says so.
    pub names: Vec<String>,
    /// The time watched, where it is known to be another than that of the events.
    pub span: Option<(Micros, Micros)>,
    /// What is missing, where that is known.
    pub dropped: Option<Dropped>,
}

impl Head {
    /// That of a packet.
    #[must_use]
    pub fn from_packet(packet: &Packet) -> Self {
        Self {
            size: packet.size,
            channels: packet.channels,
            names: packet.names.clone(),
            span: Some(packet.span),
            dropped: Some(packet.dropped),
        }
    }

    /// All of it, for a file that can say all.
    pub(super) fn about(&self) -> About {
        About {
            size: Some(self.size),
            channels: Some(self.channels),
            names: self.names.clone(),
            span: self.span,
            dropped: self.dropped,
            ..About::NOTHING
        }
    }
}
