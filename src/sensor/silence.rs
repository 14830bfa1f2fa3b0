//! Why a sensor is silent.

use crate::{kernel::Loss, photoreceptor::Response};

/// What a sensor knows of why none of its cells fired.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Silence {
    /// From light to signal.
    pub response: Response,
    /// Its least threshold, and the most by which what is compared with it moves, where both are known.
    pub reach: Option<[f64; 2]>,
    /// Whether each event, a cell's first too, comes more than a refractory period after the frame
    /// before it (`rule = "authors"`).
    pub waits: bool,
    /// Pairs of frames that are not further apart than that period, in which no cell can fire.
    pub muted_pairs: u64,
    /// Crossings that had no sign (`polarity = "pixel"`), and made no event.
    pub without_sign: u64,
    /// What little its number format leaves of its weights, where it leaves no kernel what it is.
    pub lost: Option<Loss>,
}

impl Default for Silence {
    /// Nothing known.
    fn default() -> Self {
        Self {
            response: Response::IDENTITY,
            reach: None,
            waits: false,
            muted_pairs: 0,
            without_sign: 0,
            lost: None,
        }
    }
}
