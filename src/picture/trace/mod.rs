//! A program word by word, as a page for a browser: what every register holds, on a chip and in
//! exact arithmetic beside it, forwards and backwards.
//!
//! The page needs nothing but itself: no network, no font, one script whose hash is in its policy.
//! What registers hold is in it as whole numbers of a fraction of an LSB, compressed: only what a
//! word writes, the chip as its difference from the twin. The fraction is as fine as
//! [`LARGEST`] allows, and said.

mod pack;
mod page;

pub use page::page;

use super::error::PictureError;
use crate::plane::{At, Size};

/// The largest page, in bytes.
pub const LARGEST: usize = 2_000_000;

/// A register of the page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TraceRegister {
    /// Its name.
    pub name: String,
    /// Whether it holds bits, 0 and 1.
    pub is_bit: bool,
}

/// What a register holds after a word, row by row, in the pixels that are shown.
#[derive(Clone, Debug, PartialEq)]
pub struct TraceVersion {
    /// Its number in [`Trace::registers`].
    pub register: usize,
    /// On the chip.
    pub chip: Vec<f64>,
    /// In exact arithmetic.
    pub twin: Vec<f64>,
    /// On the chip without the noise of its stores, where it has any.
    pub quiet: Option<Vec<f64>>,
}

/// One word or operation of the host, or the beginning of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct TraceStep {
    /// The frame, from 0.
    pub frame: u64,
    /// Line of the program text, from 1; 0 at the beginning of a frame.
    pub line: u32,
    /// The instruction.
    pub text: String,
    /// The registers that it reads.
    pub reads: Vec<usize>,
    /// What it leaves in the registers that it writes.
    pub written: Vec<TraceVersion>,
}

/// Where chip and twin first part: of a register in LSB by more than a limit, the median
/// difference of all pixels not counted; of bits at all.
#[derive(Clone, Debug, PartialEq)]
pub struct TraceParting {
    /// The frame, from 0.
    pub frame: u64,
    /// Which word of it, from 1; 0 before the first.
    pub word: usize,
    /// Its line.
    pub line: u32,
    /// Its text.
    pub text: String,
    /// The register.
    pub register: String,
    /// The pixel of the array.
    pub at: At,
    /// What the chip holds there.
    pub chip: f64,
    /// What the twin holds there.
    pub twin: f64,
    /// The median difference of all pixels, which is not counted.
    pub median: f64,
}

impl std::fmt::Display for TraceParting {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let At { y, x } = self.at;
        let Self {
            frame,
            word,
            line,
            text,
            register,
            chip,
            twin,
            median,
            ..
        } = self;
        write!(
            f,
            "frame {frame}, word {word}, line {line}, {text}: {register} at ({x}, {y}) is {chip:.3} on the chip and {twin:.3} exactly"
        )?;
        if *median != 0.0 {
            write!(f, " (in the middle pixels differ by {median:.3})")?;
        }
        Ok(())
    }
}

/// All that a page shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    /// Name of the program's file.
    pub program: String,
    /// What it is, in a line.
    pub title: Option<String>,
    /// Its text.
    pub text: String,
    /// The chip and the arithmetic, in words.
    pub machine: String,
    /// Size of the array.
    pub size: Size,
    /// Of so many rows and columns one is shown.
    pub every: usize,
    /// The registers that the program touches.
    pub registers: Vec<TraceRegister>,
    /// What happens; the first step has a version of each register.
    pub steps: Vec<TraceStep>,
    /// By how many LSB a pixel must part to be told of.
    pub limit: f64,
    /// Where they part.
    pub parting: Option<TraceParting>,
    /// What else is to be known; the page makes sentences of them.
    pub notes: Vec<String>,
}

impl Trace {
    /// The pixels that are shown.
    #[must_use]
    pub fn shown(&self) -> Size {
        let Size { height, width } = self.size;
        Size::new(height.div_ceil(self.every), width.div_ceil(self.every))
    }

    /// With a quarter of the pixels.
    fn thinned(&self) -> Self {
        let shown = self.shown();
        let thin = |values: &[f64]| -> Vec<f64> {
            let rows = values.chunks(shown.width.max(1)).step_by(2);
            rows.flat_map(|row| row.iter().step_by(2))
                .copied()
                .collect()
        };
        let mut thinner = self.clone();
        thinner.every *= 2;
        for version in thinner.steps.iter_mut().flat_map(|it| &mut it.written) {
            version.chip = thin(&version.chip);
            version.twin = thin(&version.twin);
            version.quiet = version.quiet.as_deref().map(thin);
        }
        thinner
    }
}
