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
    /// Which part of the program that is.
    pub part: Part,
}

/// What a frame runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// `init`.
    Init,
    /// `frame`.
    Frame,
    /// What the host asked for in this frame of an earlier run.
    Recorded,
    /// Nothing more: it ran with the host beside the array.
    Ran,
}

impl Moment<'_> {
    /// Runs all of it, if that is still to be done.
    pub fn run(&self, chip: &mut dyn Array, packet: &mut Packet) -> Result<(), RunError> {
        match self.part {
            Part::Init => chip.run_init(self.t, packet),
            Part::Frame => chip.run_frame(self.t, packet),
            Part::Recorded => chip.run_steps(self.steps, self.t, packet),
            Part::Ran => Ok(()),
        }
    }
}
