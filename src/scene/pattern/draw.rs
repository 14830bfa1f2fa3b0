//! Coverage: the share of a pixel's area that a figure covers.
//!
//! A pixel is the unit square around its centre. All of these are exact means over that
//! square, except [`disc`], whose rim is taken as straight within a pixel.

use std::f64::consts::{PI, TAU};

use crate::elementary;

/// The share of a pixel that lies on the near side of a straight edge at distance `d` along
/// the unit normal `(x, y)`.
pub(super) fn half_plane(d: f64, x: f64, y: f64) -> f64 {
    // The pixel seen along the normal is the sum of two boxes of these widths; the share is
    // the integral of that trapezium up to `d`.
    let (wide, thin) = (x.abs().max(y.abs()), x.abs().min(y.abs()));
    let share = if thin < 1e-6 {
        d / wide + 0.5
    } else {
        let outer = f64::midpoint(wide, thin);
        let inner = (wide - thin) / 2.0;
        if d.abs() >= outer {
            0.5 + 0.5 * d.signum()
        } else if d.abs() <= inner {
            d / wide + 0.5
        } else {
            let corner = outer - d.abs();
            let left = corner * corner / (2.0 * wide * thin);
            if d > 0.0 { 1.0 - left } else { left }
        }
    };
    share.clamp(0.0, 1.0)
}

/// The mean over a pixel of a sinusoid along the unit vector `(x, y)`, from 0 to 1; `s` is the
/// pixel's distance along it.
pub(super) fn grating(s: f64, period: f64, x: f64, y: f64) -> f64 {
    let seen = sinc(x / period) * sinc(y / period);
    0.5 + 0.5 * seen * elementary::sin(TAU * s / period)
}

/// `sin(pi a) / (pi a)`: the mean of a wave of `a` periods per pixel over a pixel.
fn sinc(a: f64) -> f64 {
    if a.abs() < 1e-9 {
        1.0
    } else {
        elementary::sin(PI * a) / (PI * a)
    }
}

/// A checkerboard of squares of 1 and 0.
pub(super) fn checker((x, y): (f64, f64), square: f64) -> f64 {
    0.5 + 0.5 * stripes(x, square) * stripes(y, square)
}

/// The mean over `[a - 1/2, a + 1/2]` of a square wave that is +1 and -1 for `width` each.
fn stripes(a: f64, width: f64) -> f64 {
    // The integral of the wave is a triangle between 0 and `width`.
    let sum = |a: f64| {
        let a = a.rem_euclid(2.0 * width);
        a.min(2.0 * width - a)
    };
    sum(a + 0.5) - sum(a - 0.5)
}

/// A disc around (0, 0).
pub(super) fn disc((x, y): (f64, f64), radius: f64) -> f64 {
    let far = elementary::hypot(x, y);
    let (nx, ny) = if far > 0.0 {
        (x / far, y / far)
    } else {
        (1.0, 0.0)
    };
    half_plane(radius - far, nx, ny)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mean of `f` over the pixel around a place, by many samples.
    fn sampled((x, y): (f64, f64), f: impl Fn(f64, f64) -> f64) -> f64 {
        let n = 400;
        let offset = |i| (f64::from(i) + 0.5) / f64::from(n) - 0.5;
        let places = (0..n).flat_map(|j| (0..n).map(move |i| (i, j)));
        let sum: f64 = places.map(|(i, j)| f(x + offset(i), y + offset(j))).sum();
        sum / f64::from(n * n)
    }

    #[test]
    fn shares_are_means_over_the_pixel() {
        for step in 0..40 {
            let angle = f64::from(step) * 0.37;
            let place = (f64::from(step) * 0.11 - 2.0, 1.0 - f64::from(step) * 0.07);
            let (ny, nx) = angle.sin_cos();
            let along = |x: f64, y: f64| x * nx + y * ny;
            let s = along(place.0, place.1);
            let one = |yes| if yes { 1.0 } else { 0.0 };
            let near =
                |a: f64, b: f64, what| assert!((a - b).abs() < 4e-3, "{what} {step}: {a} {b}");
            near(
                half_plane(0.3 - s, nx, ny),
                sampled(place, |x, y| one(along(x, y) < 0.3)),
                "edge",
            );
            near(
                grating(s, 2.5, nx, ny),
                sampled(place, |x, y| 0.5 + 0.5 * (TAU * along(x, y) / 2.5).sin()),
                "grating",
            );
            near(
                checker(place, 1.3),
                sampled(place, |x, y| {
                    one((x / 1.3).floor() as i32 % 2 == (y / 1.3).floor() as i32 % 2
                        || ((x / 1.3).floor() as i32 + (y / 1.3).floor() as i32) % 2 == 0)
                }),
                "checker",
            );
        }
    }

    #[test]
    fn a_disc_has_its_area() {
        let places = (-12..=12).flat_map(|y| (-12..=12).map(move |x| (f64::from(x), f64::from(y))));
        let area: f64 = places.map(|(x, y)| disc((x + 0.3, y - 0.1), 9.5)).sum();
        assert!((area / (PI * 9.5 * 9.5) - 1.0).abs() < 2e-3, "{area}");
    }
}
