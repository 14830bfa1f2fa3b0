//! Arms: the sensors that are compared.
//!
//! Every arm has the same network from the same start, as many steps, and the same number of
//! events; what differs is the kernel before the events, and whether it is learned. No arm begins
//! with weights of another.

mod list;
mod resistors;
mod shape;

use crate::levels::Levels;

pub use list::{NAMES, named};
pub use shape::{Applied, Shape};

/// A sensor that takes part.
#[derive(Clone, Debug, PartialEq)]
pub struct Arm {
    /// Its name.
    pub name: String,
    /// What the network sees beside the two frames.
    pub sight: Sight,
}

/// What an arm sees.
#[derive(Clone, Debug, PartialEq)]
pub enum Sight {
    /// Nothing, and there is no network: the mean of the two frames.
    Blend,
    /// The two frames alone.
    Frames,
    /// Events.
    Events(Cells),
}

/// The cells of an arm.
#[derive(Clone, Debug, PartialEq)]
pub struct Cells {
    /// The kernels it begins with.
    pub start: Start,
    /// Whether they are learned.
    pub learned: bool,
    /// Kinds of cells.
    pub kinds: usize,
    /// Whether four kernels alternate in a 2x2 pattern.
    pub pattern: bool,
    /// The few values that weights have after half of the steps.
    pub few: Option<Few>,
    /// A logarithmic response in place of the task's.
    pub log: bool,
}

/// Few values.
#[derive(Clone, Debug, PartialEq)]
pub struct Few {
    /// Which.
    pub levels: Levels,
    /// Whether weights are drawn towards them from the first step on; else they are free until they
    /// have them.
    pub drawn: bool,
}

/// What kernels begin as.
#[derive(Clone, Debug, PartialEq)]
pub enum Start {
    /// A built-in kernel, by its name.
    Builtin(String),
    /// 1 in the middle of a square of this side.
    Delta(usize),
    /// The difference of two Gaussians: their standard deviations in pixels, and the gain of the
    /// second. What is learned is these three.
    Gaussians([f64; 3]),
    /// The pixel and the surround that a resistor mesh makes: its space constant in pixels, and its
    /// gain. What is learned is these two.
    Mesh([f64; 2]),
}

impl Arm {
    /// The cells, where the arm has some.
    #[must_use]
    pub const fn cells(&self) -> Option<&Cells> {
        match &self.sight {
            Sight::Events(cells) => Some(cells),
            Sight::Blend | Sight::Frames => None,
        }
    }

    /// Kinds of cells; 0 without events.
    #[must_use]
    pub fn kinds(&self) -> usize {
        self.cells().map_or(0, |cells| cells.kinds)
    }
}
