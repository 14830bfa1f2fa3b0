//! What runs: instruction words, host operations, repetitions.

use crate::isa::Primitive;

use super::operation::Host;

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
        /// What is done each time.
        body: Vec<Step>,
    },
}
