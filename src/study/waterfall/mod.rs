//! The waterfall: where what the float sensor says goes on the way to the chip.
//!
//! Every [`Cause`] is a switch on a sensor that runs: the first three on the float model, the
//! others on the compiled program. It is told in two ways:
//!
//! - [`Fall::rates`]: what is *kept* at several frame rates, from the clip's own to the chip's
//!   ceiling, and what of the rest each cause takes: its [Shapley value](fn@shapley) over all sets of
//!   the chip's switches, on tiles of the scene and for many chips.
//! - [`Fall::steps`], or [`ask`]: event by event at the clip's own rate, in both orders. *Forward* is what
//!   adding a step changes, given the steps before it: the sensors `f_0 … f_n` have the first
//!   0 … n steps on, and step i is `f_(i-1)` against `f_i`. *Backward* is what it alone changes,
//!   given all the others: the sensor with every step on but this one, against the one with all
//!   on; for the float model's steps, among themselves. Where the two differ, steps interact.
//!
//! Kinds of one program fall together ([`Fall::all`]): every sensor has all of them, so that a
//! memory that they share is shared in all, and each kind's own events are told.
//!
//! Not every set of steps is a sensor: `docs/waterfall.md` says which are run, and what adds up
//! and what does not.

mod answer;
mod cause;
mod chart;
mod crossings;
mod estimate;
mod game;
mod noise;
mod program;
mod question;
mod rates;
mod sample;
mod sensor;
mod shapley;
mod steps;
mod stretch;

pub use answer::{Answer, Asked, Watch, answer};
pub use cause::Cause;
pub use crossings::check_crossings;
pub use noise::{Noise, NoiseAtRate};
pub use question::{Fall, Question, WaterfallError};
pub use rates::{Choice, How, Rate, Rates, Share};
pub use sample::{Sample, Tile};
pub use shapley::shapley;
pub use steps::{ProgramCost, Shares, Step, Waterfall, ask, steps_together};
