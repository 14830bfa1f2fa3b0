//! One frame on its way to the chip.

use crate::{
    array::{Array, RunError},
    event::Packet,
    program::Step,
    unit::Micros,
};

/// A frame to which the chip is exposed already.
pub struct Moment<'a> {
    /// Which one, from 0.
    pub index: u64,
    /// When.
    pub t: Micros,
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
