//! The waterfall: where the events of the float sensor go on the way to the chip.
//!
//! Every [`Cause`] is a switch on a sensor that runs: the first three on the float model, the
//! others on the compiled program. Each step is told in both orders:
//!
//! - **forward**: what adding it changes, given the steps before it. The sensors `f_0 … f_n`
//!   have the first 0 … n steps on; step i is `f_(i-1)` against `f_i`.
//! - **backward**: what it alone changes, given all the others. The sensor with every step on
//!   but this one, against the one with all on; for the float model's steps, among themselves.
//!
//! Where the two differ, steps interact. Not every set of steps is a sensor: `docs/waterfall.md`
//! says which are run, and what adds up and what does not.

mod cause;
mod chart;
mod game;
mod noise;
mod question;
mod rates;
mod sample;
mod sensor;
mod shapley;
mod steps;

pub use cause::Cause;
pub use noise::{Noise, NoiseAtRate};
pub use question::{Fall, Question, WaterfallError, ask};
pub use rates::{Choice, How, Rate, Rates, Share};
pub use sample::{Sample, Tile};
pub use shapley::shapley;
pub use steps::{Shares, Step, Waterfall, Words};
