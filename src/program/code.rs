//! What runs: instruction words, host operations, repetitions.

use std::sync::Arc;

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

impl Code {
    /// Kinds of cells whose events it reads out: one more than the highest number.
    #[must_use]
    pub fn kinds(&self) -> u8 {
        kinds(&self.init).max(kinds(&self.frame))
    }

    /// Whether it reads events out, as addresses or in whole bit planes.
    #[must_use]
    pub fn reads_events(&self) -> bool {
        self.kinds() > 0
    }
}

fn kinds(body: &[Step]) -> u8 {
    let of = |step: &Step| match &step.action {
        Action::Host(
            Host::ScanEvents { channel, .. }
            | Host::ScanDigital {
                events: Some((_, channel)),
                ..
            },
        ) => channel.saturating_add(1),
        Action::Host(_) | Action::Word(_) => 0,
        Action::Repeat { body, .. } => kinds(body),
    };
    body.iter().map(of).max().unwrap_or(0)
}

/// One step of a program, with the line of the source text that it came from.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// What to do.
    pub action: Action,
    /// Line of the program text, from 1.
    pub line: u32,
    /// Where it is written, if that is an included file: `file:line`.
    pub origin: Option<Arc<str>>,
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

#[cfg(test)]
mod tests {
    use crate::{
        isa::Device,
        program::{Overrides, Program},
    };

    #[test]
    fn events_are_read_as_addresses_or_in_planes() {
        for (text, reads) in [
            ("mov(A, B);", false),
            ("scamp5_scan_events(R5, on, 10);", true),
            (
                "init { scamp5_scan_events(R5, off, 10); }\nframe { mov(A, B); }",
                true,
            ),
            ("repeat 2 { scamp5_scan_events(R5, on, 10); }", true),
            ("scamp5_scan_dreg(R5, on, 0, 255);", true),
            ("scamp5_scan_dreg(R5, mem);", false),
        ] {
            let program = Program::parse("p.scamp", text).unwrap();
            let expanded = program.expand(&Device::scamp5(), &Overrides::default());
            assert_eq!(expanded.unwrap().code.reads_events(), reads, "{text}");
        }
    }
}
