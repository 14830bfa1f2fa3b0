//! What `run` warns of: the float model has no packet where no list is asked for.

use crate::{
    event::Packet,
    number::Format,
    photoreceptor::Response,
    plane::Size,
    reference::{Description, Firing, Tally},
    rig::guard::{Crowd, Guard, Warning},
    scene::Frame,
};

/// Looks at a run of the float model, frame by frame.
pub struct RunGuard {
    /// What is told of each interval.
    pub firing: Firing,
    name: String,
    crowd: Crowd,
    border: Border,
    /// The least threshold, and the most by which what is compared with it moves.
    reach: Option<[f64; 2]>,
}

impl RunGuard {
    /// Nothing seen yet.
    pub fn new(description: &Description, size: Size, format: Format) -> Self {
        let cells = description.channels.len() * size.pixels();
        Self {
            firing: Firing::new(),
            name: description.name.clone(),
            crowd: Crowd::new(cells as u64),
            border: Border::new(format, description.response),
            reach: description.reach(),
        }
    }

    /// A frame that the sensor has seen. The first one sets the memory, and nobody fires.
    pub fn see(&mut self, frame: &Frame) {
        self.crowd.see(self.firing.cells());
        self.border.see(frame);
    }

    /// What there is to warn of; the packet is what has left the readout.
    pub fn warnings(&self, tally: &Tally, packet: &Packet) -> Vec<Warning> {
        let mut guard = Guard::new();
        if tally.total() == 0 {
            let response = self.border.response;
            guard.warn(Warning::no_events_of(
                &self.name,
                self.crowd.frames,
                response,
                self.reach,
            ));
        }
        if self.crowd.over > 0 {
            guard.warn(Warning::most_cells(&self.name, &self.crowd));
        }
        let lost = packet.dropped.no_slot;
        if lost > 0 {
            let kept = packet.events.len() as u64;
            guard.warn(Warning::slots("the readout", lost, kept));
        }
        if let Some(warning) = self.border.warning(&self.name) {
            guard.warn(warning);
        }
        guard.warnings()
    }
}

/// Counts the signals that a fixed-point format cannot hold.
struct Border {
    /// The ends of the format.
    ends: Option<[f64; 2]>,
    format: Format,
    response: Response,
    at: u64,
    all: u64,
}

impl Border {
    fn new(format: Format, response: Response) -> Self {
        let ends = match format {
            Format::Fixed(fixed) => {
                let most = f64::from(1_u32 << (fixed.integer() - 1));
                Some([-most, most])
            }
            _ => None,
        };
        Self {
            ends,
            format,
            response,
            at: 0,
            all: 0,
        }
    }

    fn see(&mut self, frame: &Frame) {
        let Some([low, high]) = self.ends else {
            return;
        };
        let beyond = |light: &f64| {
            let signal = self.response.apply(*light);
            signal.is_ok_and(|signal| signal < low || signal >= high)
        };
        self.all += frame.light.size().pixels() as u64;
        // More light is never less signal: nearly always both ends of the light are within.
        let ends = frame.light.extent();
        if ends.is_none_or(|(low, high)| !beyond(&low) && !beyond(&high)) {
            return;
        }
        self.at += frame.light.iter().filter(|light| beyond(light)).count() as u64;
    }

    fn warning(&self, subject: &str) -> Option<Warning> {
        let place = format!("the signals, held in {}", self.format);
        let ends = self.ends.filter(|_| self.at > 0)?;
        let counted = (self.at, self.all);
        Some(Warning::saturation(subject, &place, counted, ends))
    }
}
