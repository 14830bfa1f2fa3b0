//! A time from one window to the next: an exact fraction of microseconds.

/// So many microseconds, as a fraction: 1/30 s is 100000/3.
///
/// Multiples of a floating-point number lose microseconds: by 2^60 us they are off by hundreds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Period {
    over: i128,
    under: i128,
}

impl Period {
    /// The simplest fraction that is as near to `seconds`, 1e-6 to 1e9, as the next number of
    /// floating point.
    pub fn from_seconds(seconds: f64) -> Self {
        /// Bits behind the point, of which floating point above 1 has none that are smaller.
        const BITS: i32 = 52;
        let micros = seconds * 1e6;
        let scaled = |micros: f64| (micros * 2_f64.powi(BITS)) as i128;
        let bounds = (scaled(micros.next_down()), scaled(micros.next_up()));
        let (over, under) = simplest((bounds.0, 1 << BITS), (bounds.1, 1 << BITS));
        Self { over, under }
    }

    /// So many of these and so many halves of another, to the nearest microsecond; halves away
    /// from 0.
    pub fn times(self, count: u64, halves: i128, of: Self) -> i64 {
        // Over 2 `self.under` `of.under`. What does not fit is beyond all times.
        let whole = (2 * i128::from(count) * of.under).saturating_mul(self.over);
        let over = whole.saturating_add(halves * of.over * self.under);
        let under = 2 * self.under * of.under;
        let nearest = (over.saturating_abs().saturating_add(under / 2)) / under * over.signum();
        nearest.clamp(i64::MIN.into(), i64::MAX.into()) as i64
    }

    /// How many of these are over at a time.
    pub fn within(self, micros: i64) -> u64 {
        let whole = i128::from(micros.max(0)) * self.under / self.over;
        whole.try_into().unwrap_or(u64::MAX)
    }
}

/// The fraction of the smallest numbers from `low` to `high`, both above 0.
fn simplest(low: (i128, i128), high: (i128, i128)) -> (i128, i128) {
    let whole = low.0 / low.1;
    if low.0 % low.1 == 0 {
        return (whole, 1);
    }
    if (whole + 1) * high.1 <= high.0 {
        return (whole + 1, 1);
    }
    // Both have the same whole part: the rest is the simplest upside down.
    let (under, over) = simplest(
        (high.1, high.0 - whole * high.1),
        (low.1, low.0 - whole * low.1),
    );
    (whole * under + over, under)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_and_times_are_the_fractions_that_they_are_meant_to_be() {
        for (seconds, fraction) in [
            (0.05, (50_000, 1)),
            (1e-6, (1, 1)),
            (1e9, (1_000_000_000_000_000, 1)),
            (1.0 / 30.0, (100_000, 3)),
            (5.0 / 30.0, (500_000, 3)),
            (1.0 / 29.97, (100_000_000, 2_997)),
            (1.0 / 128.0, (15_625, 2)),
            (1001.0 / 30_000.0, (100_100, 3)),
        ] {
            let Period { over, under } = Period::from_seconds(seconds);
            assert_eq!((over, under), fraction, "{seconds}");
        }
        // Any other is as near as floating point has it.
        for seconds in [std::f64::consts::PI, 0.001_234_567_891_234, 7e8 + 0.123] {
            let Period { over, under } = Period::from_seconds(seconds);
            let error = over as f64 / under as f64 / (seconds * 1e6) - 1.0;
            assert!(error.abs() < 3e-16, "{seconds}");
        }
    }
}
