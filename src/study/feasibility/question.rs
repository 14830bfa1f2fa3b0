//! The question.

use super::readout::ReadoutOrder;
use crate::{
    compile::{DriveMemory, Effort},
    event::readout::Readout,
    isa::Device,
    kernel::{
        Kernel,
        quantise::{Quantiser, Sum},
    },
    unit::Micros,
};

/// What is asked.
#[derive(Clone, Debug)]
pub struct Question<'a> {
    /// What the kernel is called.
    pub name: &'a str,
    /// The kernel.
    pub kernel: &'a Kernel,
    /// Events where kernel times light (0 to 255) moved by more than this.
    pub threshold: f64,
    /// The few values that the chip computes with; else the best of the candidates.
    pub to: Option<Quantiser>,
    /// Rows of the table.
    pub candidates: &'a [Quantiser],
    /// What quantised kernels must sum to.
    pub sum: Sum,
    /// The chip on which the program is to run.
    pub device: &'a Device,
    /// What a program of all kernels remembers, and where; else the first that the chip holds them
    /// in.
    pub memory: Option<DriveMemory>,
    /// How long each frame is exposed, where that is known.
    pub exposure: Option<Micros>,
    /// Whether the next frame is exposed while events are read.
    pub order: ReadoutOrder,
    /// Energy of a bit on the link, pJ: the least and the most.
    pub link: [f64; 2],
    /// How long to search for each program.
    pub effort: Effort,
    /// Seed of the searches, of stochastic rounding, of the silicon and of the null streams.
    pub seed: u64,
    /// How events leave the chip, in the waterfall.
    pub readout: Readout,
    /// Events of one pixel and sign that are closer than this match.
    pub within: Micros,
    /// Chips that are drawn from what the public data allow; at least one.
    pub chips: u64,
    /// What the scene is called.
    pub scene: &'a str,
    /// The command that asks all this.
    pub command: &'a str,
}

/// The question that a program of its own answers, where only one is asked: a program that
/// remembers otherwise than in analogue registers is that of several kernels, if there is but one.
pub(super) fn alone<'a, 'b>(questions: &'b [Question<'a>]) -> Option<&'b Question<'a>> {
    match questions {
        [one] => one
            .memory
            .is_none_or(|memory| memory == DriveMemory::Analogue)
            .then_some(one),
        _ => None,
    }
}
