//! Minimum times.

use std::time::{Duration, Instant};

#[derive(Clone, Copy)]
pub struct Timing {
    /// How long to go on repeating.
    enough: Duration,
    repetitions: u32,
}

impl Timing {
    pub fn new(quick: bool) -> Self {
        let (milliseconds, repetitions) = if quick { (60, 3) } else { (400, 5) };
        Self {
            enough: Duration::from_millis(milliseconds),
            repetitions,
        }
    }

    /// Seconds of one call: the minimum over repetitions of a few calls each.
    pub fn seconds(self, mut call: impl FnMut()) -> f64 {
        let start = Instant::now();
        call();
        // About 4 ms, so that the clock does not count, and a pause of the machine rarely falls
        // into all of them.
        let calls = (4e-3 / start.elapsed().as_secs_f64()).clamp(1.0, 1e6) as u32;
        let (start, mut best, mut done) = (Instant::now(), f64::INFINITY, 0);
        while done < self.repetitions || start.elapsed() < self.enough {
            let one = Instant::now();
            for _ in 0..calls {
                call();
            }
            best = best.min(one.elapsed().as_secs_f64() / f64::from(calls));
            done += 1;
        }
        best
    }
}
