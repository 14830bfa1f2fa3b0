//! Searches: which points are computed depends on what others have given.
//!
//! - [`search`]: successive halving; [`cut`]: points on parts of their scenes; [`contenders`]: the
//!   points that are still in it; [`survivors`]: who goes on to the next rung.
//! - [`ask`]: points for a search of somebody else's, one by one.

pub mod ask;
mod contenders;
mod cut;
pub mod search;
pub mod survivors;
