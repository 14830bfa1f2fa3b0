//! A program on an array: a sensor.
//!
//! Light comes in frame by frame. Before a body runs, the photodiodes hold
//! `PIX = reset level + gain · light`, one whole exposure; `rpix` takes them back to the reset
//! level. With the default gain of 1/2, the vendor's `get_image(y)`, which subtracts the reset
//! level, gives `y = light / 2`, the half range 0 to 127.5.
//!
//! The first frame runs the program's `init`, every later one its `frame`.

mod array;
mod error;
mod face;
mod run;
mod time;
mod unscanned;

pub use self::{
    array::Array,
    error::{RunError, ShapeError},
};

use self::unscanned::Unscanned;
use super::{
    CodeError, Layout, Ledger, Reading, RowOps, Schedule, Settings, State, check,
    engine::{Engine, Lowered},
};
use crate::{
    event::Packet,
    isa::Device,
    photoreceptor::LightError,
    plane::{Plane, Size},
    program::{Code, Step},
    scene::Frame,
    sensor::{Sensor, SensorError, light_error},
    unit::Micros,
};

/// Steps as a chip runs them, lowered once.
#[derive(Clone, Debug)]
pub struct Body(Lowered);

/// A program on an array in one domain.
#[derive(Clone, Debug)]
pub struct Chip<D: RowOps> {
    name: String,
    domain: D,
    device: Device,
    settings: Settings,
    state: State<D::Cell>,
    channels: u8,
    /// Time of the last frame watched, in seconds.
    watched: Option<f64>,
    /// Seconds since each one-bit register was written.
    idle: Vec<f64>,
    /// Words since power-on.
    step: u64,
    ledger: Ledger,
    readings: Vec<Reading>,
    unscanned: Unscanned,
    engine: Engine<D::Cell>,
    init: Lowered,
    frame: Lowered,
}

impl<D: RowOps> Chip<D> {
    /// A chip as switched on: every register 0, FLAG 1.
    ///
    /// # Errors
    /// When the program cannot run on an array of this layout and size, or no array has these
    /// settings; on line 0 what is not of the program.
    pub fn new(
        name: &str,
        domain: D,
        code: &Code,
        device: &Device,
        size: Size,
        settings: Settings,
    ) -> Result<Self, CodeError> {
        let layout = Layout::new(device, size);
        let checked = settings.check();
        checked.map_err(|problem| CodeError { line: 0, problem })?;
        check(code, &layout)?;
        let mut state = State::new(&domain, layout, settings.edge);
        // Switched on in the dark.
        state.pix.fill(domain.hold(settings.reset_level));
        let engine = Engine::new(
            &state,
            settings
                .schedule
                .unwrap_or_else(|| Schedule::for_size(size)),
            settings.threads.unwrap_or_else(rayon::current_num_threads),
        );
        let lowering = engine.lowering(domain.fuses());
        let lowered = |steps: &[Step]| Lowered::new(steps, device, &layout, lowering);
        Ok(Self {
            name: name.into(),
            init: lowered(&code.init),
            frame: lowered(&code.frame),
            engine,
            state,
            channels: code.kinds().max(1),
            domain,
            device: device.clone(),
            settings,
            watched: None,
            idle: vec![0.0; layout.digital.into()],
            step: 0,
            ledger: Ledger::default(),
            readings: Vec::new(),
            unscanned: Unscanned::default(),
        })
    }

    /// All registers.
    #[must_use]
    pub fn state(&self) -> &State<D::Cell> {
        &self.state
    }

    /// The arithmetic.
    #[must_use]
    pub fn domain(&self) -> &D {
        &self.domain
    }

    /// What the sources leave open.
    #[must_use]
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Whether the photodiodes can hold light of this size: in floats, what they cannot becomes
    /// infinite, and its difference from anything is no number.
    fn holds(&self, frame: &Frame, most: f64) -> Result<(), SensorError> {
        let Settings {
            gain, reset_level, ..
        } = self.settings;
        let held = |light: f64| {
            let most = reset_level.abs() + (gain * light).abs();
            self.domain.value(&self.domain.hold(most)).is_finite()
        };
        if held(most) {
            return Ok(());
        }
        let beyond = |light| (!held(light)).then_some(LightError::Beyond(light));
        Err(light_error(frame, beyond))
    }

    fn fits<T>(&self, plane: &Plane<T>) -> Result<(), ShapeError> {
        let (got, want) = (Size::of(plane), self.state.layout.size);
        if got == want {
            Ok(())
        } else {
            Err(ShapeError { got, want })
        }
    }
}

impl<D: RowOps> Sensor for Chip<D> {
    fn name(&self) -> &str {
        &self.name
    }

    fn size(&self) -> Size {
        self.state.layout.size
    }

    fn channels(&self) -> u8 {
        self.channels
    }

    fn watch(&mut self, frame: &Frame, packet: &mut Packet) -> Result<(), SensorError> {
        let is_first = self.show(frame)?;
        let t = Micros::from_seconds(frame.seconds);
        let result = if is_first {
            packet.span.0 = t;
            self.run_init(t, packet)
        } else {
            self.run_frame(t, packet)
        };
        packet.span.1 = t;
        result.map_err(|error| SensorError::Stopped {
            sensor: self.name.clone(),
            why: error.to_string(),
        })
    }
}
