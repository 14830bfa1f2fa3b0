//! One frame on its way to the chip.

use crate::{
    array::{Array, RunError},
    event::Packet,
    plane::Plane,
    program::Step,
    unit::Micros,
};

/// A frame to which the chip is exposed already.
pub struct Moment<'a> {
    /// Which one, from 0.
    pub index: u64,
    /// When.
    pub t: Micros,
    /// Seconds since the frame before, if there was one.
    pub since: Option<f64>,
    /// What falls on the photodiodes.
    pub light: &'a Plane<f64>,
    /// What is to run: the whole program if it is bare, else `init` or `frame`.
    pub steps: &'a [Step],
    /// Whether that is `init`.
    pub is_init: bool,
}

impl Moment<'_> {
    /// Runs all of it.
    pub fn run(&self, chip: &mut dyn Array, packet: &mut Packet) -> Result<(), RunError> {
        if self.is_init {
            chip.run_init(self.t, packet)
        } else {
            chip.run_frame(self.t, packet)
        }
    }
}
