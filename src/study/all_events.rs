//! A chip of which every event is read, however many there are, in the order of its own readout.

use crate::{
    array::{Array, Body, RunError},
    event::{Dropped, Event, Packet, Polarity},
    isa::Digital,
    plane::Size,
    program::{Action, Host, Step},
    scene::Frame,
    sensor::{Overflowed, Sensor, SensorError, Silence},
    unit::Micros,
};

/// A chip before its readout: the host's list holds at most 4000 events, the one-bit registers that
/// it scans hold them all. Several kinds may take turns in the registers that are scanned, so each
/// is looked at right after its own scan.
pub struct AllEvents {
    chip: Box<dyn Array + Send>,
    parts: Vec<Part>,
    /// What its own readout delivers.
    delivered: Packet,
}

/// The body of a frame up to a scan, and what that reads.
struct Part {
    body: Body,
    scanned: Option<(Digital, Polarity, u8)>,
}

impl AllEvents {
    /// Of a chip that runs these steps each frame.
    pub(super) fn new(chip: Box<dyn Array + Send>, frame: &[Step]) -> Self {
        let scanned = |step: &Step| match step.action {
            Action::Host(Host::ScanEvents {
                source,
                polarity,
                channel,
                ..
            }) => Some((source, polarity, channel)),
            _ => None,
        };
        let parts = frame.split_inclusive(|step| scanned(step).is_some());
        Self {
            parts: parts
                .map(|steps| Part {
                    scanned: steps.last().and_then(scanned),
                    body: chip.lower(steps),
                })
                .collect(),
            delivered: Packet::new(chip.size(), chip.channels()),
            chip,
        }
    }

    /// The chip.
    #[must_use]
    pub fn chip(&self) -> &dyn Array {
        &*self.chip
    }

    /// How many of its events its own readout has lost so far.
    #[must_use]
    pub fn lost(&self) -> Dropped {
        self.delivered.dropped
    }

    /// Runs the steps of a frame, and looks at each register that is scanned.
    fn run(&mut self, t: Micros, packet: &mut Packet) -> Result<(), RunError> {
        self.chip.begin_frame();
        for Part { body, scanned } in &self.parts {
            let Some((register, polarity, channel)) = *scanned else {
                // Whole rows of bits are all events already.
                self.chip.run_body(body, t, packet)?;
                continue;
            };
            self.chip.run_body(body, t, &mut self.delivered)?;
            packet
                .events
                .extend(self.chip.ones(register).iter().map(|at| Event {
                    t,
                    x: at.x as u16,
                    y: at.y as u16,
                    polarity,
                    channel,
                }));
        }
        Ok(())
    }
}

impl Sensor for AllEvents {
    fn name(&self) -> &str {
        self.chip.name()
    }

    fn size(&self) -> Size {
        self.chip.size()
    }

    fn channels(&self) -> u8 {
        self.chip.channels()
    }

    fn names(&self) -> Vec<String> {
        self.chip.names()
    }

    fn silence(&self) -> Silence {
        self.chip.silence()
    }

    fn overflowed(&self) -> Overflowed {
        self.chip.overflowed()
    }

    fn watch(&mut self, frame: &Frame, packet: &mut Packet) -> Result<(), SensorError> {
        self.delivered.events.clear();
        let is_first = self.chip.show(frame)?;
        let t = Micros::from_seconds(frame.seconds);
        let result = if is_first {
            packet.span.0 = t;
            self.chip.run_init(t, &mut self.delivered)
        } else {
            self.run(t, packet)
        };
        packet.span.1 = t;
        result.map_err(|error| SensorError::Stopped {
            sensor: self.chip.name().to_owned(),
            why: error.to_string(),
        })
    }
}
