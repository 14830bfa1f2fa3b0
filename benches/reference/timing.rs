//! How long is measured.

use std::time::{Duration, Instant};

use crate::timed::Timed;

#[derive(Clone, Copy)]
pub struct Timing {
    /// How long to go on repeating.
    enough: Duration,
    repetitions: usize,
}

impl Timing {
    pub fn new(quick: bool) -> Self {
        let (milliseconds, repetitions) = if quick { (60, 3) } else { (400, 5) };
        Self {
            enough: Duration::from_millis(milliseconds),
            repetitions,
        }
    }

    /// The time of one call, over repetitions of a few calls each.
    pub fn time(self, mut call: impl FnMut()) -> Timed {
        let start = Instant::now();
        call();
        // About 4 ms, so that the clock does not count, and a pause of the machine rarely falls
        // into all of them.
        let calls = (4e-3 / start.elapsed().as_secs_f64()).clamp(1.0, 1e6) as u32;
        let time = Timed::new(self.repetitions, self.enough, || {
            (0..calls).for_each(|_| call());
        });
        Timed {
            median: time.median / f64::from(calls),
            ..time
        }
    }
}
