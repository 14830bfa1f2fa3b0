//! A whole sensor as data: the text of a file in `sensors/`, read and checked.
//!
//! ```toml
//! name = "what it is called"                 # optional
//! source = "where it came from"              # optional
//! response = { linear = 255 }                # "identity", { log = … }, { lin-log = … }
//! memory = "filtered-step"                   # "raw-snap", "filtered-snap", "filtered-step"
//! shared = false                             # true: one memory for all kinds, with "raw-snap"
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

mod changed;
mod channel;
mod check;
mod effect;
mod growth;
mod influence;
mod kernels;
pub mod keys;
mod lost;
mod open;
mod reader;
mod rules;
mod sensor;
mod soundness;
mod still;
mod text;

pub use self::{
    changed::ChangeError,
    channel::{Channel, Threshold},
    effect::Effect,
    influence::{Alone, InBetween, Influence, Region, Stage},
    open::OpenError,
    reader::ReadFile,
    rules::{Border, MemoryRule, PolarityRule, Refractory, RefractoryRule},
    sensor::Description,
};
