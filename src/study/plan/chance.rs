//! Bounds on what chance can do, each of which fails once in 10^9 seeds.

use crate::elementary;

/// The chance with which a bound on noise may fail.
pub const FAILS: f64 = 1e-9;

/// A number that a Poisson variable of this mean is not above, but for a chance of [`FAILS`]:
/// Chernoff's `P(X ≥ x) ≤ exp(x - m - x ln(x / m))` for `x > m`.
#[must_use]
pub fn poisson(mean: f64) -> f64 {
    if mean <= 0.0 {
        return 0.0;
    }
    let least = -elementary::ln(FAILS);
    let exponent = |x: f64| exponent_of(x, mean);
    let mut high = 2.0 * mean + 4.0 * least;
    while exponent(high) < least {
        high *= 2.0;
    }
    let mut low = mean;
    for _ in 0..200 {
        let middle = f64::midpoint(low, high);
        if exponent(middle) < least {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

/// `x ln(x / m) - x + m`
fn exponent_of(x: f64, mean: f64) -> f64 {
    x * elementary::ln(x / mean) - x + mean
}

/// A number that a sum of independent terms is not above, but for a chance of [`FAILS`], where
/// the terms are 0 or above, their mean is `mean`, their squares have a mean of at most
/// `squares`, and none is above `largest`: Bernstein's inequality.
#[must_use]
pub fn bernstein(mean: f64, squares: f64, largest: f64) -> f64 {
    let least = -elementary::ln(FAILS);
    // x² = 2 least (squares + largest x / 3)
    let half = least * largest / 3.0;
    mean + half + (half * half + 2.0 * least * squares).sqrt()
}

/// How many standard deviations none of `draws` normal numbers exceeds in size, but for a
/// chance of [`FAILS`]: `P(|g| > s) ≤ exp(-s² / 2)`, once for each draw.
#[must_use]
pub fn sigmas(draws: f64) -> f64 {
    (2.0 * elementary::ln(draws.max(1.0) / FAILS)).sqrt()
}

/// The most that a normal number of this project can be, in standard deviations: it is drawn as
/// `sqrt(-2 ln r) cos(..)` with `r` at least 2^-53.
pub const MOST_SIGMAS: f64 = 8.6;

/// The chance that a normal number is more than `s` standard deviations in size; a bound.
#[must_use]
pub fn beyond(s: f64) -> f64 {
    if s > MOST_SIGMAS {
        0.0
    } else {
        elementary::exp(-s * s / 2.0).min(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `P(X > k)` of a Poisson variable, summed.
    fn tail(mean: f64, k: f64) -> f64 {
        let (mut term, mut sum) = ((-mean).exp(), 0.0);
        for i in 0..4000 {
            if f64::from(i) > k {
                sum += term;
            }
            term *= mean / f64::from(i + 1);
        }
        sum
    }

    #[test]
    fn poisson_is_seldom_more_and_the_bound_is_near() {
        for mean in [1e-6, 0.01, 1.0, 30.0, 400.0] {
            let bound = poisson(mean);
            assert!(tail(mean, bound) <= FAILS, "{mean}: {bound}");
            assert!(
                tail(mean, bound * 0.8 - 1.5) > FAILS,
                "{mean}: {bound} is loose"
            );
        }
        assert_eq!(poisson(0.0), 0.0);
    }

    #[test]
    fn bernstein_covers_poisson() {
        // A Poisson variable is a sum of many small independent terms of size 1.
        for mean in [0.01, 1.0, 30.0, 400.0] {
            let bound = bernstein(mean, mean, 1.0);
            assert!(bound >= poisson(mean) * 0.999, "{mean}: {bound}");
            assert!(tail(mean, bound) <= FAILS);
        }
    }

    #[test]
    fn normal_tails_are_covered() {
        // P(|g| > 2) is 0.0455, P(|g| > 4) is 6.334e-5.
        assert!(beyond(2.0) > 0.0455 && beyond(4.0) > 6.334e-5);
        assert_eq!(beyond(9.0), 0.0);
        assert!((sigmas(1.0) - 6.44).abs() < 0.01);
    }
}
