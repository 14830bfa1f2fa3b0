//! A whole sensor as data: the text of a file in `sensors/`, read and checked.
//!
//! ```toml
//! name = "what it is called"                 # optional
//! source = "where it came from"              # optional
//! response = { linear = 255 }                # "identity", { log = … }, { lin-log = … }
//! memory = "filtered-step"                   # "raw-snap", "filtered-snap", "filtered-step"
//! polarity = "filtered"                      # or "pixel"
//! border = "replicate"                       # or "zero"
//! refractory = { us = 1000, rule = "dead-time" }   # or "authors"; without it: none
//! [noise]                                    # without it: none
//! [[channel]]                                # one for each kind of cell
//! kernel = [[0, -1, 0], [-1, 4, -1], [0, -1, 0]]   # or the name of a built-in or of a file
//! # or, in place of the kernel, a resistor mesh:
//! # mesh = { lambda = 10, tau-us = 500 }
//! gain = -1                                  # optional: scales the weights, here centre-OFF
//! threshold = { on = 0.2, off = 0.2, sigma = 0.03 }
//! ```
//!
//! A channel with `pattern = "2x2"` gives four kernels and four thresholds; the pixel at
//! (x, y) uses number `2 (y mod 2) + (x mod 2)`.

mod check;
mod kernels;
pub mod keys;

use crate::{config::Faults, kernel::Kernel, photoreceptor::Response};

use super::{noise::Noise, surround::Surrounds};

use self::check::Reader;

/// Everything that makes one sensor different from another.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// What it is called.
    pub name: String,
    /// From light to signal.
    pub response: Response,
    /// What an event does to the memory.
    pub memory: MemoryRule,
    /// Where an event's sign comes from.
    pub polarity: PolarityRule,
    /// What lies off the array.
    pub border: Border,
    /// How long a cell is silent after an event.
    pub refractory: Refractory,
    /// What disturbs it.
    pub noise: Noise,
    /// The kinds of cells, at least one.
    pub channels: Vec<Channel>,
}

/// What an event does to the memory; `docs/reference.md` has the equations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MemoryRule {
    /// The memory holds pixels; a pixel that fires stores its own signal (Eq. 2-4 of the paper).
    RawSnap,
    /// The memory holds the filtered signal; a cell that fires stores it.
    FilteredSnap,
    /// The memory holds the filtered signal; each event moves it by one threshold.
    FilteredStep,
    /// The released simulator's old rule: the memory holds pixels, and is moved by thresholds
    /// of the filtered difference. Only to agree with the released code.
    AuthorsPixelStep,
}

impl MemoryRule {
    /// All, in the order of their words in [`keys::MEMORY`].
    pub const ALL: [Self; 4] = [
        Self::RawSnap,
        Self::FilteredSnap,
        Self::FilteredStep,
        Self::AuthorsPixelStep,
    ];
}

/// Where an event's sign comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PolarityRule {
    /// The sign of the filtered difference (the released code).
    #[default]
    Filtered,
    /// The sign of the pixel's own change since it last fired (Eq. 3 of the paper). A cell
    /// whose own pixel has not changed has no sign and emits nothing.
    Pixel,
}

/// What the kernel reads off the array.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Border {
    /// The nearest pixel of the array.
    #[default]
    Replicate,
    /// Zero, after the response.
    Zero,
}

/// How long a cell is silent after an event; `docs/reference.md` has the equations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Refractory {
    /// Microseconds.
    pub us: f64,
    /// How the silence works.
    pub rule: RefractoryRule,
}

/// How the silence after an event works.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RefractoryRule {
    /// A real dead time: crossings in it are lost, and the memory moves through them.
    #[default]
    DeadTime,
    /// The supplement's `α_r` and `β_r`, as in the released simulator.
    Authors,
}

/// One kind of cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// What it is called.
    pub name: Option<String>,
    /// One kernel, or four for a 2x2 pattern; with sheets, the pixel alone.
    pub kernels: Vec<Kernel>,
    /// The resistor sheets that it sees through in place of a kernel.
    pub surrounds: Option<Surrounds>,
    /// As many thresholds as kernels.
    pub thresholds: Vec<Threshold>,
    /// The kernel that the memory is seen through; only for [`MemoryRule::AuthorsPixelStep`].
    pub memory_kernel: Option<Kernel>,
    /// `a ln(max(W u, 1e-8) + 1)` in place of `W u`: the released simulator's `log_temporal`.
    pub log_temporal: bool,
}

/// When a cell fires.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Threshold {
    /// For ON events, above zero.
    pub on: f64,
    /// For OFF events, a positive magnitude.
    pub off: f64,
    /// Standard deviation of the fixed-pattern mismatch, same unit as the thresholds.
    pub sigma: f64,
}

/// Reads a file that a sensor file names; the path is as written there.
pub type ReadFile<'a> = dyn Fn(&str) -> std::io::Result<Vec<u8>> + 'a;

impl Description {
    /// Reads the text of a sensor file called `file`; `read` opens the kernel files it names.
    ///
    /// # Errors
    /// What is wrong, each with its line and column.
    pub fn parse(file: &str, text: &str, read: &ReadFile<'_>) -> Result<Self, Faults> {
        keys::FILE.read(file, text, |root| Reader { file, read }.sensor(root))
    }
}
