//! Coverage: the share of a pixel's area that a figure covers.
//!
//! A pixel is the unit square around its centre. All of these are exact means over that
//! square.

use std::f64::consts::{PI, SQRT_2, TAU};

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
    let ((x, nx), (y, ny)) = (mirrored(x), mirrored(y));
    let columns = x[..nx].iter();
    let area: f64 = columns
        .flat_map(|x| y[..ny].iter().map(|y| quarter(*x, *y, radius)))
        .sum();
    area.min(1.0)
}

/// The parts of `[a - 1/2, a + 1/2]` below and above 0, both counted from 0 upwards, and how many
/// there are.
fn mirrored(a: f64) -> ([[f64; 2]; 2], usize) {
    let a = a.abs();
    let (low, high) = (a - 0.5, a + 0.5);
    if low < 0.0 {
        ([[0.0, -low], [0.0, high]], 2)
    } else {
        ([[low, high]; 2], 1)
    }
}

/// The area of a rectangle right of and below (0, 0) that lies in the disc around it.
fn quarter([left, right]: [f64; 2], [top, bottom]: [f64; 2], radius: f64) -> f64 {
    // The rim: y over x, and x over y.
    let rim = |a: f64| ((radius - a) * (radius + a)).max(0.0).sqrt();
    // Left of `whole` the disc is higher than the rectangle, right of `none` it does not reach it.
    let whole = rim(bottom).clamp(left, right);
    let none = rim(top).clamp(whole, right);
    let (high, low) = (rim(whole).clamp(top, bottom), rim(none).clamp(top, bottom));
    let under_chord = (none - whole) * (f64::midpoint(high, low) - top);
    let chord = elementary::hypot(none - whole, high - low);
    (whole - left) * (bottom - top) + under_chord + segment(chord, radius)
}

/// The area between a chord of a circle and its arc, which is a quarter of it at most.
fn segment(chord: f64, radius: f64) -> f64 {
    let angle = 2.0 * elementary::asin((chord / (2.0 * radius)).min(1.0));
    let square = angle * angle;
    // angle - sin(angle), which is lost in rounding where it is small.
    let left = if angle < 0.25 {
        let terms = [110.0, 72.0, 42.0, 20.0];
        let sum = terms.iter().fold(1.0, |sum, n| 1.0 - sum * square / n);
        angle * square / 6.0 * sum
    } else {
        angle - elementary::sin(angle)
    };
    radius * radius / 2.0 * left
}

/// The mean over a pixel of a Gaussian around (0, 0), 1 at its middle.
pub(super) fn spot((x, y): (f64, f64), sigma: f64) -> f64 {
    // The integral of exp(-a^2 / (2 sigma^2)) over one side of the pixel.
    let side = |a: f64| {
        let until = |a: f64| elementary::erf(a / (sigma * SQRT_2));
        sigma * (PI / 2.0).sqrt() * (until(a + 0.5) - until(a - 0.5))
    };
    side(x) * side(y)
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

    /// The sum over the pixels around many middles, each a fraction of a pixel from the last.
    fn sums(reach: i32, share: impl Fn((f64, f64)) -> f64) -> impl Iterator<Item = f64> {
        (0..24).map(move |step| {
            let (dx, dy) = (f64::from(step) * 0.173, f64::from(step) * -0.059);
            let row = |y: i32| (-reach..=reach).map(move |x| (f64::from(x), f64::from(y)));
            let places = (-reach..=reach).flat_map(row);
            places.map(|(x, y)| share((x + dx, y + dy))).sum()
        })
    }

    #[test]
    fn a_disc_has_its_area() {
        for radius in [0.01, 0.25, 0.5, 0.7, 1.0, 2.0, 9.5, 31.0] {
            for area in sums(40, |place| disc(place, radius)) {
                let error = area / (PI * radius * radius) - 1.0;
                assert!(error.abs() < 1e-11, "{radius}: {error}");
            }
        }
        // One that is much larger than a pixel has a straight rim, at any angle.
        for angle in [0.0_f64, 0.3, 0.8, 2.0, 4.0] {
            let (sin, cos) = angle.sin_cos();
            for far in [-0.9, -0.4, 0.0, 0.2, 0.6] {
                let place = (cos * (1e6 + far), sin * (1e6 + far));
                let straight = half_plane(-far, cos, sin);
                assert!((disc(place, 1e6) - straight).abs() < 1e-6, "{angle}, {far}");
            }
        }
    }

    #[test]
    fn a_spot_has_its_light() {
        for sigma in [0.05, 0.25, 0.5, 1.0, 3.0, 5.0_f64] {
            for sum in sums(50, |place| spot(place, sigma)) {
                let error = sum / (TAU * sigma * sigma) - 1.0;
                assert!(error.abs() < 1e-12, "{sigma}: {error}");
            }
        }
        assert!((spot((3.0, 4.0), 1e6) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn discs_and_spots_are_means_over_the_pixel() {
        for step in 0..30 {
            let place = (f64::from(step) * 0.13 - 2.0, 1.5 - f64::from(step) * 0.09);
            for size in [0.25, 0.6, 1.3, 2.0] {
                let inside = |x: f64, y: f64| if x.hypot(y) < size { 1.0 } else { 0.0 };
                let (got, want) = (disc(place, size), sampled(place, inside));
                assert!(
                    (got - want).abs() < 1e-3,
                    "disc {size} {place:?}: {got} {want}"
                );
                let bell = |x: f64, y: f64| (-(x * x + y * y) / (2.0 * size * size)).exp();
                let (got, want) = (spot(place, size), sampled(place, bell));
                assert!(
                    (got - want).abs() < 1e-5,
                    "spot {size} {place:?}: {got} {want}"
                );
            }
        }
    }
}
