//! What every array answers to, whatever its arithmetic.

use super::{
    super::{Layout, Ledger, Reading},
    Body,
    error::{RunError, ShapeError},
};
use crate::{
    event::Packet,
    isa::{Analog, Device, Digital},
    plane::{At, Plane},
    program::Step,
    scene::Frame,
    sensor::{Sensor, SensorError},
    unit::Micros,
};

/// An array whose domain was chosen at run time.
pub trait Array: Sensor {
    /// The name of its domain.
    fn domain(&self) -> String;

    /// The chip.
    fn device(&self) -> &Device;

    /// Its registers and size.
    fn layout(&self) -> Layout;

    /// Sets an analogue register, in LSB; never clipped.
    ///
    /// # Errors
    /// When the plane has another size.
    ///
    /// # Panics
    /// When the array does not have the register: [`layout`](Self::layout) says how many there are.
    fn set_analog(&mut self, register: Analog, values: &Plane<f64>) -> Result<(), ShapeError>;

    /// Sets a one-bit register, whatever R0 is.
    ///
    /// # Errors
    /// When the plane has another size.
    ///
    /// # Panics
    /// When the array does not have the register.
    fn set_digital(&mut self, register: Digital, bits: &Plane<bool>) -> Result<(), ShapeError>;

    /// Sets FLAG.
    ///
    /// # Errors
    /// When the plane has another size.
    fn set_flag(&mut self, bits: &Plane<bool>) -> Result<(), ShapeError>;

    /// An analogue register, in LSB, without loss.
    ///
    /// # Panics
    /// When the array does not have the register: [`layout`](Self::layout) says how many there are.
    fn analog(&self, register: Analog) -> Plane<f64>;

    /// A one-bit register.
    ///
    /// # Panics
    /// When the array does not have the register.
    fn digital(&self, register: Digital) -> Plane<bool>;

    /// Every pixel whose one-bit register is 1, in the order in which the chip's scan finds them.
    ///
    /// # Panics
    /// When the array does not have the register.
    fn ones(&self, register: Digital) -> Vec<At>;

    /// FLAG.
    fn flag(&self) -> Plane<bool>;

    /// Lets light fall on the photodiodes for one exposure.
    ///
    /// # Errors
    /// When the picture has another size.
    fn expose(&mut self, light: &Plane<f64>) -> Result<(), ShapeError>;

    /// Takes in the next frame of a scene: its time and its light are checked, the time since the one
    /// before passes, and the light falls on the photodiodes. Says whether it is the first, for
    /// which `init` is to run; for any other it is `frame`.
    ///
    /// # Errors
    /// When the frame has another size, is no later than the one before, or has light that the array
    /// does not hold; the array is then as it was.
    fn show(&mut self, frame: &Frame) -> Result<bool, SensorError>;

    /// Runs `init` once; events are stamped with `t`.
    ///
    /// # Errors
    /// When the domain has no answer for an instruction. What came before that word was done, its
    /// events are in the packet, and nothing after it was: the array goes on from there with whatever
    /// it is given next.
    fn run_init(&mut self, t: Micros, packet: &mut Packet) -> Result<(), RunError>;

    /// Runs `frame` once; events are stamped with `t`.
    ///
    /// # Errors
    /// As [`run_init`](Self::run_init).
    fn run_frame(&mut self, t: Micros, packet: &mut Packet) -> Result<(), RunError>;

    /// Lowers these steps, to be run on this chip as often as wanted.
    ///
    /// # Panics
    /// When a step names a register that the array does not have; steps of its own program
    /// never do.
    fn lower(&self, steps: &[Step]) -> Body;

    /// Runs a body now, as a kernel of its own; what was read before is kept.
    ///
    /// # Errors
    /// As [`run_init`](Self::run_init).
    fn run_body(&mut self, body: &Body, t: Micros, packet: &mut Packet) -> Result<(), RunError>;

    /// Lowers these steps and runs them once.
    ///
    /// # Errors
    /// As [`run_body`](Self::run_body).
    ///
    /// # Panics
    /// As [`lower`](Self::lower).
    fn run_steps(
        &mut self,
        steps: &[Step],
        t: Micros,
        packet: &mut Packet,
    ) -> Result<(), RunError> {
        let body = self.lower(steps);
        self.run_body(&body, t, packet)
    }

    /// Lets `run` do with the array what it likes, and takes all of that back: what registers hold, what
    /// was counted and read. The next word errs as it would have.
    fn aside(&mut self, run: &mut dyn FnMut(&mut dyn Array));

    /// Forgets what was read before, as each frame does.
    fn begin_frame(&mut self);

    /// Lets some seconds pass: registers decay, where the domain has it.
    fn wait(&mut self, seconds: f64);

    /// The photodiodes, in LSB.
    fn pix(&self) -> Plane<f64>;

    /// What was done since power-on.
    fn ledger(&self) -> Ledger;

    /// What the host read during the last body that ran.
    fn readings(&self) -> &[Reading];
}
