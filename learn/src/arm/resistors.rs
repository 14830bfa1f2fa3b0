//! The pixel and the surround that a resistor mesh makes of a point of light: `δ + a H_λ`.

use amacrine::{
    mesh::{Sheet, Steady},
    plane::{Plane, Size},
    reference::{SheetRule, Surround, Surrounds},
};
use ndarray::s;

/// The least and the largest space constant that is learned, in pixels: at the largest, 0.96 of the
/// surround lies within [`REACH`].
pub(super) const LAMBDAS: [f64; 2] = [0.3, 1.5];

/// How far the kernel that stands for a mesh reaches.
const REACH: usize = 5;

/// The side of the sheet that a surround is taken from: none of it comes back from the border.
const SIDE: usize = 31;

/// The surround of a point, cut to what a kernel reaches.
pub(super) fn surround(lambda: f64) -> Plane<f64> {
    let mut point = Plane::zeros((SIDE, SIDE));
    let middle = SIDE / 2;
    point[(middle, middle)] = 1.0;
    let solved = Sheet::new(lambda)
        .and_then(|sheet| Steady::new(sheet, Size::new(SIDE, SIDE)))
        .and_then(|mut sheet| sheet.solve(&point));
    let whole = solved.unwrap_or(point);
    let window = middle - REACH..=middle + REACH;
    whole.slice(s![window.clone(), window]).to_owned()
}

/// How the surround changes with the logarithm of the space constant: by a central difference.
pub(super) fn by_logarithm(lambda: f64) -> Plane<f64> {
    const STEP: f64 = 1e-4;
    let at = |by: f64| surround(lambda * amacrine::elementary::exp(by));
    (at(STEP) - at(-STEP)) / (2.0 * STEP)
}

/// The kernel that stands for it.
pub(super) fn kernel(lambda: f64, gain: f64) -> Plane<f64> {
    let mut kernel = surround(lambda) * gain;
    kernel[(REACH, REACH)] += 1.0;
    kernel
}

/// The mesh itself, all of it times `scale`.
pub(super) fn surrounds(lambda: f64, gain: f64, scale: f64) -> Option<Surrounds> {
    let sheet = Surround {
        gain: gain * scale,
        sheet: Sheet::new(lambda).ok()?,
        tau: 0.0,
        noise: 0.0,
    };
    Some(Surrounds {
        centre: scale,
        sheets: vec![sheet],
        rule: SheetRule::default(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_cut_off_is_little() {
        for (lambda, least) in [(0.3, 0.999), (1.0, 0.99), (LAMBDAS[1], 0.95)] {
            let sum = surround(lambda).sum();
            assert!(sum > least && sum <= 1.0 + 1e-12, "{lambda}: {sum}");
        }
        // The value at the point, of docs/mesh.md.
        assert!((surround(1.0)[(REACH, REACH)] - 0.254_050).abs() < 1e-6);
    }

    #[test]
    fn the_slope_is_a_difference() {
        let (lambda, by) = (0.8, 1e-3);
        let apart = surround(lambda * amacrine::elementary::exp(by)) - surround(lambda);
        let slope = by_logarithm(lambda);
        let off = (apart / by - &slope).mapv(f64::abs);
        assert!(off.iter().all(|v| *v < 1e-3) && slope.iter().any(|v| v.abs() > 0.05));
    }
}
