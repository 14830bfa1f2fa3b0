//! What is asked of a waterfall.

use crate::{
    array::Arithmetic,
    event::readout::Readout,
    kernel::quantise::{Quantiser, Sum},
    study::design::Design,
    unit::Micros,
};

/// What is asked.
#[derive(Clone, Copy, Debug)]
pub struct Question<'a> {
    /// The float cell, and the chip.
    pub design: Design<'a>,
    /// How its kernel comes into few values.
    pub to: Quantiser,
    /// What they must sum to.
    pub sum: Sum,
    /// What the chip's cells hold: `silicon`, or numbers, which err by their format alone.
    pub arithmetic: Arithmetic,
    /// How events leave the chip.
    pub readout: Readout,
    /// Events of one cell that are closer than this are the same.
    pub within: Micros,
}
