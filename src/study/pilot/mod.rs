//! The pilot: what leaving something out changes in this scene, measured on a sample of it.
//!
//! ```text
//!  scene ─► [look] what goes on in each tile ─► [draw] which tiles stand for the others
//!    [family] models, the full one and plainer ones ─► [trial] all of them on these tiles
//!                      [change] events without a partner ─► [estimate] their share, and its limit
//!    [rule] what needs no measurement ────────────────────────────► [answer] the choice
//! ```
//!
//! A cell depends on its surroundings only, so tiles, each with a halo of what its cells see, have
//! the events of the whole sensor there, to the bit: noise is a hash of the place. What depends on
//! all of the sensor (a resistor sheet, a memory of pixels, a readout) has no such tiles, and is
//! not offered. `docs/fidelity.md` says why the limit holds, and what a pilot cannot see.

pub mod answer;
pub mod change;
pub mod chips;
pub mod choice;
pub mod draw;
pub mod error_term;
pub mod estimate;
pub mod family;
mod first_frames;
pub mod float;
pub mod left_out;
mod levels;
pub mod look;
pub mod measure;
pub mod model;
pub mod order;
mod part;
pub mod plan;
mod program_halo;
pub mod rule;
pub mod spread;
mod stage;
pub mod survey;
mod trial;
mod value;

pub use answer::{Answer, Offer};
pub use change::Change;
pub use chips::{Chips, Machine};
pub use choice::Choice;
pub use error_term::ErrorTerm;
pub use estimate::{ChangeEstimate, History, NoLimit, Unseen};
pub use family::Family;
pub use float::Floats;
pub use left_out::{Absent, UnknownPart};
pub use look::{Grid, Look};
pub use measure::Measure;
pub use model::Model;
pub use order::Quicker;
pub use part::Part;
pub use plan::{Plan, PlanError, Question};
pub use spread::Spread;
pub use survey::{Known, Sampled, Survey};
