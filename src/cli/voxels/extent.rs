//! What is to be known of an event file before its array.

use super::arguments::Arguments;
use crate::{
    cli::arguments::recording,
    event::{
        Event,
        file::{self, Reader},
    },
    plane::Size,
    unit::Micros,
};

/// What a file holds, and when.
pub struct Extent {
    pub size: Size,
    pub channels: u8,
    pub names: Vec<String>,
    pub events: u64,
    pub start: Micros,
    pub end: Micros,
    pub size_known: bool,
}

impl Extent {
    pub fn of(arguments: &Arguments) -> miette::Result<Self> {
        let mut reader = Reader::open(&arguments.file, &arguments.recording.opening(None))?;
        let mut block: Vec<Event> = Vec::new();
        let (mut first, mut last, mut events) = (None, Micros(0), 0);
        // Only the events themselves say where they end and what they reach.
        while reader.next_block(&mut block)? {
            first = first.or_else(|| block.first().map(|event| event.t));
            last = block.last().map_or(last, |event| event.t);
            events += block.len() as u64;
        }
        let stated = reader.about().span.map(|(start, _)| start);
        let (packet, size_known) = {
            let (loaded, damage, _) = file::up_to(&mut reader, 0);
            if let Some(damage) = damage {
                return Err(damage.into());
            }
            (loaded.packet, loaded.size_known)
        };
        if packet.size.pixels() == 0 {
            return Err(recording::sizeless(&arguments.file));
        }
        Ok(Self {
            size: packet.size,
            channels: packet.channels,
            names: packet.names,
            events,
            // A span may be stated that begins after the first event.
            start: { stated.into_iter().chain(first) }
                .min()
                .unwrap_or_default(),
            end: last.max(packet.span.1),
            size_known,
        })
    }
}
