//! A program on its chip: what runs, whoever wrote it.

use super::design::DesignError;
use crate::{
    array::{Arithmetic, Array, Body, Chip, Errors, Layout, RunError, Settings, Silicon},
    event::{Event, Packet, Polarity},
    isa::{Device, Digital},
    limit::ARRAY_SIDE,
    plane::Size,
    program::{Action, Code, Cost, Host, Overrides, Program, Step},
    scene::Frame,
    sensor::{Sensor, SensorError},
    unit::Micros,
};

/// A program's text expanded on its chip.
#[derive(Clone, Debug)]
pub struct Expanded {
    /// What it is called in messages.
    pub title: String,
    /// The instruction words.
    pub code: Code,
    /// What a frame costs.
    pub cost: Cost,
    /// The chip.
    pub device: Device,
}

impl Expanded {
    /// Of a program's text.
    ///
    /// # Errors
    /// When the text is no program, or more than the chip takes.
    pub fn from_text(title: &str, text: &str, device: &Device) -> Result<Self, DesignError> {
        let parsed = Program::parse(title, text)?;
        let code = parsed.expand(device, &Overrides::default())?.code;
        Ok(Self {
            title: title.to_owned(),
            cost: Cost::of(&code.frame, device),
            code,
            device: device.clone(),
        })
    }

    /// What the chip's data say, and registers of numbers limited to -128 to 127 LSB.
    #[must_use]
    pub fn settings(&self) -> Settings {
        Settings {
            clip: true,
            ..Settings::from_device(&self.device)
        }
    }

    /// A chip that runs it.
    ///
    /// # Errors
    /// When the size has no addresses.
    pub fn chip(
        &self,
        arithmetic: Arithmetic,
        size: Size,
        settings: Settings,
    ) -> Result<Box<dyn Array + Send>, DesignError> {
        if let Arithmetic::Silicon { seed } = arithmetic {
            return self.silicon(Errors::from_device(&self.device), seed, size, settings);
        }
        addressed(size)?;
        Ok(arithmetic.chip(&self.title, &self.code, &self.device, size, settings)?)
    }

    /// A chip that errs as `errors` says: [`Errors::from_device`], with any of them changed
    /// or 0. Analogue cells saturate at the range in it, which has the chip's headroom;
    /// `settings.clip` would take that away, and is left out.
    ///
    /// # Errors
    /// When the size has no addresses.
    pub fn silicon(
        &self,
        errors: Errors,
        seed: u64,
        size: Size,
        settings: Settings,
    ) -> Result<Box<dyn Array + Send>, DesignError> {
        addressed(size)?;
        let domain = Silicon::new(errors, seed, &Layout::new(&self.device, size));
        let settings = Settings {
            clip: false,
            ..settings
        };
        let chip = Chip::new(
            &self.title,
            domain,
            &self.code,
            &self.device,
            size,
            settings,
        )?;
        Ok(Box::new(chip))
    }

    /// A chip of this program of which every event is read, however many there are.
    #[must_use]
    pub fn all_events(&self, chip: Box<dyn Array + Send>) -> AllEvents {
        AllEvents::new(chip, &self.code.frame)
    }
}

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
    fn new(chip: Box<dyn Array + Send>, frame: &[Step]) -> Self {
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

    /// Runs the steps of a frame, and looks at each register that is scanned.
    fn run(&mut self, t: Micros, packet: &mut Packet) -> Result<(), RunError> {
        self.chip.begin_frame();
        for Part { body, scanned } in &self.parts {
            self.chip.run_body(body, t, &mut self.delivered)?;
            let Some((register, polarity, channel)) = *scanned else {
                continue;
            };
            self.chip.each_one(register, &mut |at| {
                packet.events.push(Event {
                    t,
                    x: at.x as u16,
                    y: at.y as u16,
                    polarity,
                    channel,
                });
            });
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

fn addressed(size: Size) -> Result<(), SensorError> {
    let addresses = 1..=ARRAY_SIDE;
    if addresses.contains(&size.width) && addresses.contains(&size.height) {
        Ok(())
    } else {
        Err(SensorError::Addresses { size })
    }
}
