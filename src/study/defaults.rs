//! What studies take where nobody says: the command line and Python have these constants.

use crate::unit::Micros;

/// The chip, a shipped one.
pub const CHIP: &str = "scamp5";

/// What a kernel of `waterfall` becomes.
pub const TO: &str = "ternary";

/// The arithmetic of the chip's cells in `waterfall`, and of the full model in `trade`.
pub const DOMAIN: &str = "silicon";

/// Chips of a waterfall.
pub const WATERFALL_CHIPS: u64 = 4;

/// An event of a model that is moved by more is changed, in `trade`.
pub const TRADE_WITHIN: Micros = Micros(100);

/// The part of the sensor that `trade` runs, 0 to 1.
pub const SAMPLE: f64 = 0.05;

/// Runs that share the planning of `trade`.
pub const RUNS: u32 = 1;

/// Quantisers that `feasibility` and `design` try.
pub const CANDIDATES: &str = "ternary,po2-2,po2-4,int-3,int-5";

/// Chips that `feasibility` draws.
pub const FEASIBILITY_CHIPS: u64 = 32;

/// The least and the most energy of a bit on the link of `feasibility`, in pJ: an assumption.
pub const LINK_PJ: [f64; 2] = [1.0, 20.0];
