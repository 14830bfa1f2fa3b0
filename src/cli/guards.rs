//! What `run` warns of: the float model has no packet where no list is asked for.

use crate::{
    event::Packet,
    number::Format,
    plane::Size,
    reference::{Description, Firing, Tally},
    rig::{
        Overflow,
        guard::{Crowd, Guard, Warning},
    },
    scene::Frame,
    sensor::Sensor,
};

/// Looks at a run of the float model, frame by frame.
pub struct RunGuard {
    /// What is told of each interval.
    pub firing: Firing,
    name: String,
    crowd: Crowd,
    overflow: Overflow,
    /// What the format makes of its kernels.
    rounded: Option<Warning>,
    /// The spread of thresholds and the least of them, of the kind where it is the largest part.
    spread: Option<(f64, f64)>,
    /// How far a still scene is from the memory, and the threshold that it reaches.
    still: Option<[f64; 2]>,
}

impl RunGuard {
    /// Nothing seen yet.
    pub fn new(description: &Description, size: Size, format: Format) -> Self {
        let kinds = description.channels.len();
        let cells = kinds * size.pixels();
        let losses = description.losses(format);
        let rounded = losses.map(|loss| Warning::rounded(&description.name, kinds, loss));
        Self {
            firing: Firing::new(),
            name: description.name.clone(),
            crowd: Crowd::new(cells as u64),
            overflow: Overflow::new(format, description.response),
            rounded,
            spread: spread(description),
            still: description.still(),
        }
    }

    /// A frame that the sensor has seen. The first one sets the memory, and nobody fires.
    pub fn see(&mut self, frame: &Frame) {
        self.crowd.see(self.firing.cells());
        self.overflow.see(frame);
    }

    /// What there is to warn of, of a sensor that has seen all frames; the packet is what has left the
    /// readout.
    pub fn warnings(&self, tally: &Tally, packet: &Packet, sensor: &dyn Sensor) -> Vec<Warning> {
        let mut guard = Guard::new();
        if let Some(warning) = &self.rounded {
            guard.warn(warning.clone());
        }
        if tally.total() == 0 {
            let frames = self.crowd.frames;
            let silence = sensor.silence();
            guard.warn(Warning::no_events_of(&self.name, frames, &silence));
        }
        if let Some(reached) = self.still {
            guard.warn(Warning::still(&self.name, reached));
        }
        let spread = self.spread;
        let spread = spread.and_then(|(sigma, least)| Warning::spread(&self.name, sigma, least));
        if let Some(warning) = spread {
            guard.warn(warning);
        }
        if self.crowd.over > 0 {
            guard.warn(Warning::most_cells(&self.name, &self.crowd));
        }
        let lost = packet.dropped.no_slot;
        if lost > 0 {
            let kept = packet.events.len() as u64;
            guard.warn(Warning::slots("the readout", lost, kept));
        }
        let drives = sensor.overflowed();
        if let Some(warning) = self.overflow.warning(&self.name, drives) {
            guard.warn(warning);
        }
        guard.warnings()
    }
}

/// The largest spread of thresholds as a part of them: it, and the threshold.
fn spread(description: &Description) -> Option<(f64, f64)> {
    let all = description
        .channels
        .iter()
        .flat_map(|kind| &kind.thresholds);
    all.map(|own| (own.sigma, own.on.min(own.off)))
        .max_by(|a, b| (a.0 / a.1).total_cmp(&(b.0 / b.1)))
}
