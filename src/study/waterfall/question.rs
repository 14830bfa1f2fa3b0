//! What is asked, what it is asked of, and why there may be no answer.

use std::{borrow::Cow, sync::Arc};

use super::program::Kinds;
use crate::{
    array::Arithmetic,
    compile::DriveMemory,
    event::{Packet, readout::Readout},
    kernel::quantise::{Quantised, Quantiser, Sum},
    reference::MemoryRule,
    study::{
        StudyError,
        design::{Compiled, Design},
    },
    unit::{Micros, counted},
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
    /// Events of one cell and sign that are at most this far apart match.
    pub within: Micros,
}

impl Question<'_> {
    pub(super) const fn silent(&self) -> WaterfallError {
        WaterfallError::Silent {
            threshold: self.design.threshold,
        }
    }

    /// The same of another chip.
    pub(super) const fn of_chip(&self, seed: u64) -> Self {
        Self {
            arithmetic: self.arithmetic.with_seed(seed),
            ..*self
        }
    }
}

/// A question, and the program that the compiler makes of its kernel: alone, or with others.
#[derive(Clone, Debug)]
pub struct Fall<'a> {
    pub(super) question: Question<'a>,
    /// What is in the program.
    pub(super) kinds: Arc<Kinds<'a>>,
    /// Which of them this is.
    pub(super) kind: usize,
}

impl<'a> Fall<'a> {
    /// Quantises the kernel and compiles it.
    ///
    /// # Errors
    /// When the kernel cannot be quantised as asked, or does not fit the chip.
    pub fn new(question: Question<'a>) -> Result<Self, WaterfallError> {
        let design = question.design;
        // The threshold as it was given is what a message names, not the one in levels.
        design.description(MemoryRule::FilteredSnap)?;
        let quantised = design.quantise(question.to, question.sum)?;
        Ok(Self {
            question,
            kinds: Arc::new(Kinds::alone(design, quantised)?),
            kind: 0,
        })
    }

    /// Of a kernel in few values and its program, which the design in these levels compiles to.
    pub(in crate::study) fn of_program(
        question: Question<'a>,
        quantised: Quantised,
        compiled: Compiled,
    ) -> Self {
        let kinds = Kinds::of_program(question.design, quantised, compiled);
        Self {
            question,
            kinds: Arc::new(kinds),
            kind: 0,
        }
    }

    /// One design, or kinds of one program, each a fall of its own: quantises their kernels and
    /// compiles them together, with this memory or the first that the chip holds them in. The design
    /// of the question is not looked at.
    ///
    /// # Errors
    /// When a kernel cannot be quantised as asked, or no memory holds all kinds on the chip.
    pub fn all(
        designs: &[Design<'a>],
        question: Question<'a>,
        memory: Option<DriveMemory>,
    ) -> Result<Vec<Self>, WaterfallError> {
        if let [design] = designs {
            return Ok(vec![Self::new(Question {
                design: *design,
                ..question
            })?]);
        }
        let mut quantised = Vec::new();
        for design in designs {
            design.description(MemoryRule::FilteredSnap)?;
            quantised.push(design.quantise(question.to, question.sum)?);
        }
        let kinds = Arc::new(Kinds::together(designs, quantised, memory)?);
        let of = |(kind, design): (usize, &Design<'a>)| Self {
            question: Question {
                design: *design,
                ..question
            },
            kinds: Arc::clone(&kinds),
            kind,
        };
        Ok(designs.iter().enumerate().map(of).collect())
    }

    /// The program.
    pub(super) fn program(&self) -> &Compiled {
        &self.kinds.compiled
    }

    /// What the program remembers, where it holds several kinds.
    #[must_use]
    pub fn remembered(&self) -> Option<DriveMemory> {
        self.kinds.remembered()
    }

    /// The events of this kind, of a packet of all.
    pub(super) fn own<'p>(&self, packet: &'p Packet) -> Cow<'p, Packet> {
        self.kinds.own(packet, self.kind)
    }

    /// The threshold, in LSB.
    pub(super) fn threshold_lsb(&self) -> f64 {
        self.kinds.threshold(self.kind) * self.kinds.scale(self.kind)
    }

    /// Frames a second at most: instruction words, then the slots of the readout.
    #[must_use]
    pub fn ceiling_fps(&self) -> f64 {
        self.program().cost.frames_per_second()
    }
}

/// Why there is no answer.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum WaterfallError {
    /// What any study can end with.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Study(StudyError),
    /// No memory holds all kinds in one program.
    #[error("no program holds all kinds: {}", .0.join("; "))]
    #[diagnostic(help(
        "ask for fewer kinds, for another chip, or for coarser kernels (--to ternary)"
    ))]
    Refused(Vec<String>),
    /// Too few frames at a rate, or too many.
    #[error("at {fps} frames/s the {seconds:.3} s of the scene have {}", counted(*frames, "frame"))]
    #[diagnostic(help("give rates that show 2 to {most} frames in that time"))]
    Rate {
        /// The rate.
        fps: f64,
        /// Length of the stretch of the scene, in seconds.
        seconds: f64,
        /// What that is in frames.
        frames: u64,
        /// How many there may be.
        most: u64,
    },
    /// No event to follow.
    #[error("the float sensor has no event on this scene")]
    #[diagnostic(help(
        "lower the threshold (now {threshold}), or show a scene that moves, with light from 0 to 255"
    ))]
    Silent {
        /// The threshold.
        threshold: f64,
    },
    /// More events than can be followed.
    #[error(
        "the threshold {threshold} is too low: {part} of it, the lowest threshold that is run for comparison, is crossed {each:.1} times per pixel and pair of frames, more than {most} events in all"
    )]
    #[diagnostic(help(
        "raise the threshold, or ask for fewer events (--rate): each step of 8-bit light is 1, many times such a threshold"
    ))]
    Crossings {
        /// The threshold.
        threshold: f64,
        /// The lowest of its ladder, as a part of it.
        part: f64,
        /// Events per pixel and pair of frames so far.
        each: f64,
        /// How many events there may be.
        most: u64,
    },
    /// Fewer packets than sensors.
    #[error("a packet is missing")]
    #[diagnostic(help("this is a fault of amacrine: please report the command"))]
    Packet,
}

impl<E: Into<StudyError>> From<E> for WaterfallError {
    fn from(cause: E) -> Self {
        Self::Study(cause.into())
    }
}
