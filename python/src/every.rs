//! A chip whose program has several kinds of cells, of which every event is read.
//!
//! A scan has slots for 4000 events, and the kinds take turns in the registers that are scanned:
//! each is looked at after its own scan.

use amacrine::{
    array::Array,
    event::{Event, Packet, Polarity},
    isa::Digital,
    photoreceptor::LightError,
    plane::Size,
    program::{Action, Host, Step},
    scene::Frame,
    sensor::{Sensor, SensorError},
    unit::Micros,
};

/// Steps that end with a scan, and what that reads.
struct Part {
    steps: Vec<Step>,
    scanned: Option<(Digital, Polarity, u8)>,
}

/// A chip before its readout.
pub struct Every {
    chip: Box<dyn Array + Send>,
    parts: Vec<Part>,
    /// When the frame before was shown, in seconds.
    before: Option<f64>,
    /// What its own readout delivers.
    delivered: Packet,
}

impl Every {
    /// Of a chip that runs these steps each frame.
    pub fn new(chip: Box<dyn Array + Send>, frame: &[Step]) -> Self {
        let is_scan = |step: &Step| matches!(step.action, Action::Host(Host::ScanEvents { .. }));
        let parts = frame.split_inclusive(is_scan).map(|steps| Part {
            scanned: steps.last().and_then(|step| match step.action {
                Action::Host(Host::ScanEvents {
                    source,
                    polarity,
                    channel,
                    ..
                }) => Some((source, polarity, channel)),
                _ => None,
            }),
            steps: steps.to_vec(),
        });
        Self {
            parts: parts.collect(),
            before: None,
            delivered: Packet::new(chip.size(), chip.channels()),
            chip,
        }
    }

    /// Exposes the chip to a frame that is not its first.
    fn expose(&mut self, frame: &Frame, before: f64) -> Result<(), SensorError> {
        let index = frame.index;
        let mut cells = frame.light.indexed_iter();
        if let Some(((y, x), light)) = cells.find(|(_, light)| !light.is_finite()) {
            let cause = LightError::NotFinite(*light);
            return Err(SensorError::Light { index, y, x, cause });
        }
        let exposed = self.chip.expose(&frame.light);
        exposed.map_err(|error| SensorError::Size {
            index,
            got: error.got,
            want: error.want,
        })?;
        self.chip.wait(frame.seconds - before);
        self.chip.begin_frame();
        Ok(())
    }
}

impl Sensor for Every {
    fn name(&self) -> &str {
        self.chip.name()
    }

    fn size(&self) -> Size {
        self.chip.size()
    }

    fn channels(&self) -> u8 {
        self.chip.channels()
    }

    fn watch(&mut self, frame: &Frame, packet: &mut Packet) -> Result<(), SensorError> {
        self.delivered.events.clear();
        let Some(before) = self.before.replace(frame.seconds) else {
            return self.chip.watch(frame, &mut self.delivered);
        };
        self.expose(frame, before)?;
        let t = Micros::from_seconds(frame.seconds);
        for Part { steps, scanned } in &self.parts {
            let run = self.chip.run_steps(steps, t, &mut self.delivered);
            run.map_err(|error| SensorError::Stopped {
                sensor: self.chip.name().to_owned(),
                why: error.to_string(),
            })?;
            let Some((register, polarity, channel)) = *scanned else {
                continue;
            };
            let bits = self.chip.digital(register);
            let set = bits.indexed_iter().filter(|(_, bit)| **bit);
            packet.events.extend(set.map(|((y, x), _)| Event {
                t,
                x: x as u16,
                y: y as u16,
                polarity,
                channel,
            }));
        }
        Ok(())
    }
}
