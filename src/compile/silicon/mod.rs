//! Prediction on silicon, from the words alone, and plans that lose least there.
//!
//! - [`forecast`]: correlation and noise of a result; [`noise`]: what mismatch and temporal noise
//!   leave in it; [`dark_offset`]: what constant errors leave in the dark.
//! - [`survival`]: chooses, among the plans that searches find, the one of which most comes out.
//! - [`offset_cancellation`]: constant errors out of a plan; [`border_offset`]: at the border, too.

pub(super) mod border_offset;
pub(super) mod dark_offset;
pub(super) mod forecast;
pub(super) mod noise;
pub(super) mod offset_cancellation;
pub(super) mod survival;
