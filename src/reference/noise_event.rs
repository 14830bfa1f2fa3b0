//! Noise events, which nothing in the scene causes: shot noise and hot pixels.

use crate::{elementary, event::Polarity};

use super::{
    noise::Noise,
    reason::{Draws, Place, Reason},
};

/// The noise events of an interval.
pub(super) struct NoiseEvents<'a> {
    noise: &'a Noise,
    interval: u64,
    /// Expected numbers for a cell: by shot noise, and if it is hot.
    shot: Mean,
    hot: Mean,
    wait: Draws,
}

/// An expected number of arrivals.
#[derive(Clone, Copy)]
struct Mean {
    mean: f64,
    /// The probability of at least one arrival, rounded up by a tolerance.
    any: f64,
}

impl Mean {
    fn new(mean: f64) -> Self {
        let any = -elementary::exp_m1(-mean);
        Self {
            mean,
            // Far above the rounding error of a time, so that no arrival is missed.
            any: any + any * 1e-9,
        }
    }
}

impl<'a> NoiseEvents<'a> {
    /// The noise events of an interval of `dt` seconds.
    pub(super) fn new(noise: &'a Noise, seed: u64, interval: u64, dt: f64) -> Self {
        Self {
            noise,
            interval,
            shot: Mean::new(noise.shot_hz * dt),
            hot: Mean::new(noise.hot_hz * dt),
            wait: Draws::new(seed, Reason::StrayWait),
        }
    }

    /// A quick test of whether a cell may have noise events: most have none, and then no logarithm
    /// is needed.
    #[inline]
    pub(super) fn may_be(&self, place: Place) -> bool {
        let Mean { any, .. } = if self.is_hot(place) {
            self.hot
        } else {
            self.shot
        };
        self.wait.uniform_at(place, self.interval, 0) <= any
    }

    #[inline]
    fn is_hot(&self, place: Place) -> bool {
        let share = self.noise.hot_fraction;
        share > 0.0 && place.uniform(Reason::HotPixel, 0) < share
    }

    /// The noise events of a cell in order of time: 0 at the earlier frame, 1 at the later.
    ///
    /// A Poisson process is memoryless, so every interval starts anew with an exponential waiting
    /// time. Shot noise is drawn at its rate in the dark and thinned by the light.
    pub(super) fn in_cell(
        &self,
        place: Place,
        light: impl Fn() -> f64,
    ) -> impl Iterator<Item = (f64, Polarity)> {
        let Self {
            noise, interval, ..
        } = *self;
        let hot = self.is_hot(place);
        let Mean { mean, .. } = if hot { self.hot } else { self.shot };
        self.arrivals(place, mean).filter_map(move |(u, turn)| {
            if hot {
                return Some((u, Polarity::On));
            }
            let sign = Polarity::of(place.uniform_at(Reason::StraySign, interval, turn) < 0.5);
            let kept = noise.shot_at_white >= 1.0
                || place.uniform_at(Reason::StrayKept, interval, turn) < noise.shot_share(light());
            kept.then_some((u, sign))
        })
    }

    /// The arrivals of a Poisson process of mean number `mean`: their times, and their numbers from
    /// 1.
    fn arrivals(&self, place: Place, mean: f64) -> impl Iterator<Item = (f64, u64)> {
        let Self { interval, wait, .. } = *self;
        let (mut u, mut turn) = (0.0, 0);
        std::iter::from_fn(move || {
            // 1 - u is never 0. For a mean of 0 the waiting time is infinite, or not a number.
            u -= elementary::ln(1.0 - wait.uniform_at(place, interval, turn)) / mean;
            turn += 1;
            (u < 1.0).then_some((u, turn))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Cells that are passed over have no arrivals, rare or frequent.
        #[test]
        fn nothing_is_passed_over(seed: u64, interval in 0u64..1_000_000, rate in prop_oneof![Just(0.0), 1e-9f64..1e6], dt in 1e-6f64..10.0) {
            let noise = Noise { shot_hz: rate, ..Noise::NONE };
            let noise_events = NoiseEvents::new(&noise, seed, interval, dt);
            for x in 0..500 {
                let place = Place { seed, channel: 1, y: 7, x };
                let slow = noise_events.arrivals(place, rate * dt).take(3).map(|(u, _)| u);
                prop_assert!(noise_events.may_be(place) || slow.count() == 0);
            }
        }
    }

    /// At the edge: the largest number of all that can be drawn that makes an arrival.
    #[test]
    fn the_edge_lies_within_the_hair() {
        let drawn = |k: u64| k as f64 / (1u64 << 53) as f64;
        for mean in [1e-9, 1e-3, 0.02, 0.5, 1.0, 7.0, 30.0] {
            let arrives = |k| -(1.0 - drawn(k)).ln() / mean < 1.0;
            let (mut low, mut high) = (0, (1u64 << 53) - 1);
            while low + 1 < high {
                let middle = u64::midpoint(low, high);
                if arrives(middle) {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            let Mean { any, .. } = Mean::new(mean);
            assert!(drawn(low) <= any, "{mean}: {} arrives", drawn(low));
            assert!(any - drawn(low) < 1e-6 * any, "{mean}: {any} is far off");
        }
    }
}
