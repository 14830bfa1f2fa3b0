//! Guards: what in a run makes its figures mean something else than they seem to.
//!
//! A sensor that never fires, one of which most cells fire at once, a readout whose slots are
//! full, registers at the end of their range, light on another scale, a cut, frames that repeat.
//! Each guard says what was seen, why that probably is, and what to change.

mod about;
mod crowd;
mod of_comparison;
mod of_readout;
mod of_scene;
mod of_sensor;
mod warning;

pub use about::About;
pub use crowd::Crowd;
pub use warning::Warning;

use crate::{
    event::{Dropped, Packet},
    scene::Frame,
    sensor::Silence,
    unit::Micros,
};

/// Looks at the packets of a run.
#[derive(Clone, Debug, Default)]
pub struct Guard {
    frames: Vec<Micros>,
    warnings: Vec<Warning>,
}

impl Guard {
    /// Nothing seen yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The next frame that the sensors see.
    pub fn frame(&mut self, frame: &Frame) {
        self.frame_at(Micros::from_seconds(frame.seconds));
    }

    /// The same, by its time.
    pub fn frame_at(&mut self, time: Micros) {
        self.frames.push(time);
    }

    /// What a sensor said of all frames so far.
    pub fn packet(&mut self, subject: &str, packet: &Packet) {
        self.packet_of(subject, packet, &Silence::default());
    }

    /// The same of a sensor that knows why it is silent, where it is.
    pub fn packet_of(&mut self, subject: &str, packet: &Packet, silence: &Silence) {
        let Dropped {
            no_slot,
            queue_full,
            unscanned,
            ..
        } = packet.dropped;
        let kept = packet.events.len() as u64;
        if (kept, no_slot, queue_full) == (0, 0, 0) {
            let frames = self.frames.len() as u64;
            self.warn(if unscanned > 0 {
                Warning::no_events_in_rows(subject, frames, unscanned)
            } else {
                Warning::no_events_of(subject, frames, silence)
            });
            return self.lost(subject, packet.dropped, kept);
        }
        let crowd = Crowd::from_packet(packet, &self.frames);
        if crowd.over > 0 {
            self.warn(Warning::most_cells(subject, &crowd));
        }
        self.lost(subject, packet.dropped, kept);
    }

    /// Events that a readout lost, beside so many that were kept.
    pub fn lost(&mut self, subject: &str, dropped: Dropped, kept: u64) {
        if dropped.no_slot > 0 {
            self.warn(Warning::slots(subject, dropped.no_slot, kept));
        }
        if dropped.queue_full > 0 {
            self.warn(Warning::queue(subject, dropped.queue_full, kept));
        }
        if dropped.unscanned > 0 {
            self.warn(Warning::rows(subject, dropped.unscanned, kept));
        }
    }

    /// What is in a file of events, of which no frames are known.
    pub fn recording(&mut self, subject: &str, packet: &Packet) {
        let Dropped {
            no_slot,
            queue_full,
            unscanned,
            ..
        } = packet.dropped;
        let kept = packet.events.len() as u64;
        if (kept, no_slot, queue_full, unscanned) == (0, 0, 0, 0) {
            self.warn(Warning::no_events(subject, None));
        }
        self.lost(subject, packet.dropped, kept);
    }

    /// Another warning. Who is warned of the same is named with the first.
    pub fn warn(&mut self, warning: Warning) {
        let same = self.warnings.iter_mut().find(|w| w.about == warning.about);
        match same {
            Some(same) => {
                for subject in warning.subjects {
                    if !same.subjects.contains(&subject) {
                        same.subjects.push(subject);
                    }
                }
            }
            None => self.warnings.push(warning),
        }
    }

    /// All that there is to warn of.
    #[must_use]
    pub fn warnings(self) -> Vec<Warning> {
        self.warnings
    }
}

impl Extend<Warning> for Guard {
    fn extend<T: IntoIterator<Item = Warning>>(&mut self, warnings: T) {
        for warning in warnings {
            self.warn(warning);
        }
    }
}
