//! Programs of the array: text in, instruction words out.

use crate::{
    event::Polarity,
    isa::{Analog, Digital, Primitive},
};

/// A program ready to run: every macro expanded into primitives.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Code {
    /// Run once, before the first frame.
    pub init: Vec<Step>,
    /// Run for every frame.
    pub frame: Vec<Step>,
}

/// One step of a program, with the line of the source text that it came from.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// What to do.
    pub action: Action,
    /// Line of the program text, from 1.
    pub line: u32,
}

/// What a step does.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// One instruction word on all pixels.
    Word(Primitive),
    /// Something that the host (the micro-controller beside the array) does.
    Host(Host),
    /// A body, several times.
    Repeat {
        /// How often.
        times: u32,
        /// What.
        body: Vec<Step>,
    },
}

/// Operations of the host.
#[derive(Clone, Debug, PartialEq)]
pub enum Host {
    /// Drive the global input with a value on the ADC scale (LSB).
    LoadIn {
        /// -128 to 127.
        value: f64,
    },
    /// Read the set pixels of a one-bit register as events, column by column from the
    /// chip's origin (top right), rows downward; the register is left as it is.
    ScanEvents {
        /// Which register.
        source: Digital,
        /// The sign that these events carry.
        polarity: Polarity,
        /// The kind of cell that they carry.
        channel: u8,
        /// Slots asked; later events are dropped and counted. Cost is proportional to this.
        slots: u32,
    },
    /// Read an analogue register through the ADC, for the caller to look at.
    ReadAnalog {
        /// Which register.
        source: Analog,
    },
}
