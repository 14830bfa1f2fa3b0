//! A chip as an array: what it answers.

use super::{
    super::{
        BitPlane, Layout, Ledger, Reading, RowOps, Scanned, Settings,
        engine::{self, Lowered},
    },
    Array, Body, Chip, RunError, ShapeError,
};
use crate::{
    event::{Packet, readout::scan::Order},
    isa::{Analog, Device, Digital},
    plane::{At, Plane},
    program::Step,
    scene::Frame,
    sensor::{SensorError, brightest, check_time},
    unit::Micros,
};

impl<D: RowOps> Array for Chip<D> {
    fn domain(&self) -> String {
        self.domain.name()
    }

    fn device(&self) -> &Device {
        &self.device
    }

    fn layout(&self) -> Layout {
        self.state.layout
    }

    fn set_analog(&mut self, register: Analog, values: &Plane<f64>) -> Result<(), ShapeError> {
        self.fits(values)?;
        self.state.set_analog(&self.domain, register, values);
        Ok(())
    }

    fn set_digital(&mut self, register: Digital, bits: &Plane<bool>) -> Result<(), ShapeError> {
        self.fits(bits)?;
        self.state.set_digital(register, bits);
        Ok(())
    }

    fn set_flag(&mut self, bits: &Plane<bool>) -> Result<(), ShapeError> {
        self.fits(bits)?;
        self.state.flag = BitPlane::from_plane(bits);
        Ok(())
    }

    fn analog(&self, register: Analog) -> Plane<f64> {
        self.state.values(&self.domain, register)
    }

    fn digital(&self, register: Digital) -> Plane<bool> {
        self.state.digital(register).to_plane()
    }

    fn ones(&self, register: Digital) -> Vec<At> {
        let bits = self.state.digital(register);
        Scanned::new(bits, self.state.layout.size, u32::MAX, Order::default()).found
    }

    fn flag(&self) -> Plane<bool> {
        self.state.flag.to_plane()
    }

    fn expose(&mut self, light: &Plane<f64>) -> Result<(), ShapeError> {
        self.fits(light)?;
        let light = light.as_standard_layout();
        let light = light.as_slice().unwrap_or_default();
        let Settings {
            gain, reset_level, ..
        } = self.settings;
        engine::expose(&self.domain, reset_level, gain, light, &mut self.state.pix);
        Ok(())
    }

    fn show(&mut self, frame: &Frame) -> Result<bool, SensorError> {
        check_time(frame, self.watched)?;
        self.holds(frame, brightest(frame)?)?;
        self.expose(&frame.light)
            .map_err(|error| SensorError::Size {
                index: frame.index,
                got: error.got,
                want: error.want,
            })?;
        let before = self.watched.replace(frame.seconds);
        if let Some(before) = before {
            self.wait(frame.seconds - before);
        }
        Ok(before.is_none())
    }

    fn run_init(&mut self, t: Micros, packet: &mut Packet) -> Result<(), RunError> {
        self.begin_frame();
        let body = std::mem::take(&mut self.init);
        let result = self.run(&body, t, packet);
        self.init = body;
        result
    }

    fn run_frame(&mut self, t: Micros, packet: &mut Packet) -> Result<(), RunError> {
        self.begin_frame();
        let body = std::mem::take(&mut self.frame);
        let result = self.run(&body, t, packet);
        self.frame = body;
        result
    }

    fn lower(&self, steps: &[Step]) -> Body {
        let lowering = self.engine.lowering(self.domain.fuses());
        Body(Lowered::new(
            steps,
            &self.device,
            &self.state.layout,
            lowering,
        ))
    }

    fn run_body(&mut self, body: &Body, t: Micros, packet: &mut Packet) -> Result<(), RunError> {
        self.run(&body.0, t, packet)
    }

    fn aside(&mut self, run: &mut dyn FnMut(&mut dyn Array)) {
        let state = self.state.clone();
        let (idle, readings) = (self.idle.clone(), self.readings.clone());
        let unscanned = self.unscanned.clone();
        let (step, ledger, watched) = (self.step, self.ledger, self.watched);
        run(self);
        (self.state, self.idle, self.readings) = (state, idle, readings);
        self.unscanned = unscanned;
        (self.step, self.ledger, self.watched) = (step, ledger, watched);
    }

    fn begin_frame(&mut self) {
        self.readings.clear();
        self.unscanned.clear();
    }

    fn wait(&mut self, seconds: f64) {
        self.age(seconds);
        self.fade(seconds);
    }

    fn pix(&self) -> Plane<f64> {
        self.state.light(&self.domain)
    }

    fn ledger(&self) -> Ledger {
        self.ledger
    }

    fn readings(&self) -> &[Reading] {
        &self.readings
    }
}
