//! Which receptive fields a resistive grid can carry.
//!
//! A sensor of resistors computes `c δ + sum a_i H(λ_i)`: the pixel itself, and the surrounds of
//! some sheets with gains of either sign. Every surround is point-symmetric (a network of resistors
//! is reciprocal, so a shift by `d` weighs what a shift by `-d` does). With equal resistors it also
//! has the eight symmetries of the square. Parts of a kernel without these symmetries cannot be
//! reached at any gain:
//!
//! | part of the kernel | reached by |
//! |---|---|
//! | odd: `(K(d) - K(-d)) / 2` | no resistors at all |
//! | not the same under both mirrors | no sheet whose resistors run down and across |
//! | not the same under the eight turns and mirrors | no sheet of equal resistors |
//!
//! What is left where that leaves the centre alone is the pixel itself, without a sheet.
//!
//! The rest is fitted over the whole plane, in the frequency domain, where a surround is
//! `1 / (1 + λ² μ)`. For given space constants the gains are linear least squares with a ridge
//! (Tikhonov) penalty, without which those of a Laplacian would grow without bound. Space constants
//! come from a grid search and are then refined by coordinate descent. Nothing is random.

use std::f64::consts::PI;

use super::MeshError;
use crate::{elementary, kernel::Kernel, plane::Plane};

/// How a kernel is fitted.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Fitting {
    /// Number of sheets, 1 to 3.
    pub sheets: usize,
    /// Whether vertical and horizontal resistors may differ.
    pub anisotropic: bool,
    /// Weight of the ridge: what a squared gain adds to the squared relative error, for a kernel
    /// whose squares sum to 1.
    pub ridge: f64,
}

/// A kernel as the nearest sum of surrounds. Errors are norms (root of the sum of squares) relative
/// to the kernel's.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Fit {
    /// Norm of the odd part, relative to the kernel; no resistors can carry it.
    pub odd: f64,
    /// Norm of the part without mirror symmetry; no sheet can carry it.
    pub mirrored: f64,
    /// Norm of the part without the square's eight symmetries; no sheet of equal resistors can
    /// carry it.
    pub turned: f64,
    /// Gain of the pixel itself, `c`.
    pub centre: f64,
    /// The sheets; none where what can be reached of the kernel is its centre alone, which is the
    /// pixel itself, and fewer than asked for where two of them would be the same.
    pub sheets: Vec<FittedSheet>,
    /// The response to uniform light, which is the sum of all gains; that of the kernel is its sum.
    pub uniform: f64,
    /// Norm of kernel less fit, relative to the kernel, over the whole plane.
    pub error: f64,
    /// Sum of the gains' magnitudes, relative to the kernel's norm: the factor by which noise and
    /// offsets of the parts are multiplied.
    pub gain: f64,
    /// Norm of the fitted field outside the kernel's window, relative to the field.
    pub tail: f64,
    /// The ridge: that which was asked for, or where that lets two sheets run
    /// together the least power of ten that keeps them apart.
    pub ridge: f64,
}

/// One sheet of a fit.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct FittedSheet {
    /// Gain by which its surround is multiplied, `a_i`.
    pub gain: f64,
    /// Vertical space constant, pixels.
    pub lambda_y: f64,
    /// Horizontal space constant, pixels.
    pub lambda_x: f64,
}

/// Frequencies in each direction, from 0 to half a cycle a pixel. The plane is as good as infinite
/// for space constants well below this.
const GRID: usize = 96;
/// Grid of space constants in pixels: the smallest, the largest, how many.
const LAMBDAS: (f64, f64, usize) = (0.05, 24.0, 40);
/// Space constants within this factor are one sheet: resistors on silicon differ as much.
const SAME: f64 = 1.05;
/// Ridges that are tried where a smaller one lets two sheets run together with gains that grow
/// without bound, and fewer sheets would reach less.
const RIDGES: [f64; 8] = [1e-12, 1e-11, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5];
/// Sheets at most.
const MOST_SHEETS: usize = 3;

/// Fits a kernel by a pixel and the surrounds of sheets.
///
/// # Errors
/// When the kernel is 0 everywhere, or is to be fitted by no sheet or by more than three.
pub fn fit(kernel: &Kernel, how: Fitting) -> Result<Fit, MeshError> {
    let norm = kernel.weights().iter().map(|w| w * w).sum::<f64>().sqrt();
    let known = (1..=MOST_SHEETS).contains(&how.sheets);
    if !(known && norm > 0.0 && norm.is_finite()) {
        return Err(MeshError::Fit { sheets: how.sheets });
    }
    let square = squared(kernel);
    let parts = Parts::new(&square);
    let target = if how.anisotropic {
        &parts.mirrored
    } else {
        &parts.turned
    };
    let best = match alone(target) {
        Some(weight) => Candidate::pixel(weight / norm, how.ridge),
        None => distinct(&(spectrum(target) / norm), how),
    };
    let rest = |part: &Plane<f64>| {
        let left = square.iter().zip(part).map(|(a, b)| (a - b) * (a - b));
        left.sum::<f64>().sqrt() / norm
    };
    let floor = rest(target);
    let tail = tail(&best, kernel.reach());
    let sizes = best.gains.iter().map(|gain| gain.abs());
    Ok(Fit {
        odd: rest(&parts.even),
        mirrored: rest(&parts.mirrored),
        turned: rest(&parts.turned),
        centre: best.gains[0] * norm,
        uniform: best.gains.iter().sum::<f64>() * norm,
        gain: sizes.sum(),
        error: (floor * floor + best.left).max(0.0).sqrt(),
        tail,
        ridge: best.ridge,
        sheets: best
            .lambdas
            .iter()
            .zip(&best.gains[1..])
            .map(|(&(lambda_y, lambda_x), gain)| FittedSheet {
                gain: gain * norm,
                lambda_y,
                lambda_x,
            })
            .collect(),
    })
}

/// The weight of a kernel that has one, in its centre.
fn alone(square: &Plane<f64>) -> Option<f64> {
    let reach = square.nrows() / 2;
    let weight = square[[reach, reach]];
    let others = square.iter().filter(|w| **w != 0.0).count();
    (weight != 0.0 && others == 1).then_some(weight)
}

/// The kernel centred in a square window.
fn squared(kernel: &Kernel) -> Plane<f64> {
    let (ry, rx) = kernel.reach();
    let reach = ry.max(rx);
    let mut square = Plane::zeros((2 * reach + 1, 2 * reach + 1));
    for ((y, x), weight) in kernel.weights().indexed_iter() {
        square[[y + reach - ry, x + reach - rx]] = *weight;
    }
    square
}

/// A symmetry: the index to which `(y, x)` goes in a window whose last index is the third argument.
type Turn = fn(usize, usize, usize) -> (usize, usize);

/// Parts of a kernel by symmetry, each a mean over the group of symmetries.
struct Parts {
    even: Plane<f64>,
    mirrored: Plane<f64>,
    turned: Plane<f64>,
}

impl Parts {
    fn new(square: &Plane<f64>) -> Self {
        let last = square.nrows() - 1;
        let mean = |of: &[Turn]| {
            Plane::from_shape_fn(square.dim(), |(y, x)| {
                let sum: f64 = of.iter().map(|at| square[at(y, x, last)]).sum();
                sum / of.len() as f64
            })
        };
        let same = |y, x, _| (y, x);
        let half_turn = |y, x, n| (n - y, n - x);
        Self {
            even: mean(&[same, half_turn]),
            mirrored: mean(&[same, half_turn, |y, x, n| (n - y, x), |y, x, n| (y, n - x)]),
            turned: mean(&[
                same,
                half_turn,
                |y, x, n| (n - y, x),
                |y, x, n| (y, n - x),
                |y, x, _| (x, y),
                |y, x, n| (n - x, n - y),
                |y, x, n| (n - x, y),
                |y, x, n| (x, n - y),
            ]),
        }
    }
}

/// Frequency number `i`, in radians a pixel: at half steps (midpoint rule), so that none is on an
/// edge.
fn frequency(i: usize) -> f64 {
    PI * (i as f64 + 0.5) / GRID as f64
}

/// The spectrum of a kernel with both mirror symmetries, hence real.
fn spectrum(square: &Plane<f64>) -> Plane<f64> {
    let reach = (square.nrows() / 2) as f64;
    let waves = Plane::from_shape_fn((GRID, square.nrows()), |(i, d)| {
        elementary::cos(frequency(i) * (d as f64 - reach))
    });
    waves.dot(square).dot(&waves.t())
}

/// The frequency response of a surround.
fn surround((lambda_y, lambda_x): (f64, f64)) -> Plane<f64> {
    let loss = |lambda: f64| -> Vec<f64> {
        let mu = |i| 4.0 * elementary::sin(frequency(i) / 2.0).powi(2);
        (0..GRID).map(|i| lambda * lambda * mu(i)).collect()
    };
    let (down, across) = (loss(lambda_y), loss(lambda_x));
    Plane::from_shape_fn((GRID, GRID), |(y, x)| 1.0 / (1.0 + down[y] + across[x]))
}

/// The inner product of two spectra as a mean: by Parseval, the sum of products over the plane.
fn product(a: &Plane<f64>, b: &Plane<f64>) -> f64 {
    let sum: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
    sum / (GRID * GRID) as f64
}

/// A candidate: its space constants, the best gains for them (the pixel's first), the residual.
#[derive(Clone, Debug)]
struct Candidate {
    lambdas: Vec<(f64, f64)>,
    gains: Vec<f64>,
    /// Squared norm of the residual, without the ridge.
    left: f64,
    /// Squared norm of the residual and the ridge's penalty: what is minimised.
    price: f64,
    ridge: f64,
}

impl Candidate {
    /// The pixel itself with this gain, which is all that is to be reached.
    fn pixel(gain: f64, ridge: f64) -> Self {
        Self {
            lambdas: Vec::new(),
            gains: vec![gain],
            left: 0.0,
            price: 0.0,
            ridge,
        }
    }

    /// Whether two sheets have the same space constants within [`SAME`], or one is the pixel.
    fn repeats(&self) -> bool {
        let near = |a: f64, b: f64| a.max(b) <= SAME * a.min(b);
        let all = &self.lambdas;
        let twice = (0..all.len()).any(|i| {
            let (y, x) = all[i];
            all[..i].iter().any(|(v, u)| near(y, *v) && near(x, *u))
        });
        twice || all.iter().any(|(y, x)| y.max(*x) < LAMBDAS.0)
    }
}

/// The best candidate whose sheets are different ones. The ridge alone would split a sheet: two
/// halves of a gain have half the sum of squares.
fn distinct(target: &Plane<f64>, how: Fitting) -> Candidate {
    let larger = RIDGES.into_iter().filter(|ridge| *ridge > how.ridge);
    for ridge in std::iter::once(how.ridge).chain(larger) {
        let found = search(target, Fitting { ridge, ..how });
        if how.sheets == 1 || !found.repeats() {
            return found;
        }
    }
    let sheets = how.sheets - 1;
    distinct(target, Fitting { sheets, ..how })
}

fn search(target: &Plane<f64>, how: Fitting) -> Candidate {
    let (least, most, count) = LAMBDAS;
    let ratio = elementary::pow(most / least, 1.0 / (count - 1) as f64);
    let grid: Vec<f64> = (0..count)
        .map(|i| least * elementary::powi(ratio, i as u32))
        .collect();
    // The inner products of all surrounds of the grid, the pixel itself first.
    let one = Plane::ones((GRID, GRID));
    let mut fields = vec![one];
    fields.extend(grid.iter().map(|&l| surround((l, l))));
    let n = fields.len();
    let mut products = Plane::zeros((n, n));
    for i in 0..n {
        for j in 0..=i {
            let p = product(&fields[i], &fields[j]);
            products[[i, j]] = p;
            products[[j, i]] = p;
        }
    }
    let with_target: Vec<f64> = fields.iter().map(|field| product(field, target)).collect();
    let whole = product(target, target);
    let try_out = |chosen: &[usize]| {
        let places: Vec<usize> = [0]
            .into_iter()
            .chain(chosen.iter().map(|c| c + 1))
            .collect();
        let gram = |a: usize, b: usize| products[[places[a], places[b]]];
        let right: Vec<f64> = places.iter().map(|&p| with_target[p]).collect();
        let lambdas = chosen.iter().map(|&c| (grid[c], grid[c])).collect();
        gains(gram, &right, whole, how.ridge, lambdas)
    };
    let mut best = try_out(&[0]);
    let mut consider = |chosen: &[usize]| {
        let tried = try_out(chosen);
        if tried.lambdas.len() > best.lambdas.len() || tried.price < best.price {
            best = tried;
        }
    };
    for a in 0..count {
        match how.sheets {
            1 => consider(&[a]),
            2 => (0..a).for_each(|b| consider(&[a, b])),
            // Coarser: every second space constant.
            _ if a % 2 == 0 => {
                for b in (0..a).step_by(2) {
                    (0..b).step_by(2).for_each(|c| consider(&[a, b, c]));
                }
            }
            _ => {}
        }
    }
    let mut starts = vec![best];
    if how.anisotropic {
        // A sheet may run one way only; the search finds no way there from equal resistors.
        for (sy, sx) in [(4.0, 0.25), (0.25, 4.0)] {
            let mut start = starts[0].clone();
            for (y, x) in &mut start.lambdas {
                (*y, *x) = (*y * sy, *x * sx);
            }
            starts.push(start);
        }
    }
    let refined = starts
        .into_iter()
        .map(|start| refined(start, target, whole, how));
    refined
        .min_by(|a, b| a.price.total_cmp(&b.price))
        .unwrap_or_else(|| try_out(&[0]))
}

/// Refines by coordinate descent: moves each space constant up and down by shrinking factors.
fn refined(start: Candidate, target: &Plane<f64>, whole: f64, how: Fitting) -> Candidate {
    let mut best = solved(start.lambdas, target, whole, how.ridge);
    let mut step = 0.2f64;
    while step > 1e-4 {
        let mut better = false;
        for sheet in 0..best.lambdas.len() {
            let moves: &[(f64, f64)] = if how.anisotropic {
                &[(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)]
            } else {
                &[(1.0, 1.0), (-1.0, -1.0)]
            };
            for (my, mx) in moves {
                let mut lambdas = best.lambdas.clone();
                let (y, x) = lambdas[sheet];
                let within = |l: f64| l.clamp(LAMBDAS.0 / 8.0, LAMBDAS.1);
                lambdas[sheet] = (
                    within(y * elementary::exp(my * step)),
                    within(x * elementary::exp(mx * step)),
                );
                let tried = solved(lambdas, target, whole, how.ridge);
                if tried.price < best.price * (1.0 - 1e-12) {
                    best = tried;
                    better = true;
                }
            }
        }
        if !better {
            step *= 0.5;
        }
    }
    best
}

fn solved(lambdas: Vec<(f64, f64)>, target: &Plane<f64>, whole: f64, ridge: f64) -> Candidate {
    let mut fields = vec![Plane::ones((GRID, GRID))];
    fields.extend(lambdas.iter().map(|&l| surround(l)));
    let right: Vec<f64> = fields.iter().map(|field| product(field, target)).collect();
    gains(
        |a, b| product(&fields[a], &fields[b]),
        &right,
        whole,
        ridge,
        lambdas,
    )
}

/// The gains of least squares with the ridge: `(X'X + r) a = X'k`, by Gaussian elimination.
fn gains(
    gram: impl Fn(usize, usize) -> f64,
    right: &[f64],
    whole: f64,
    ridge: f64,
    lambdas: Vec<(f64, f64)>,
) -> Candidate {
    let n = right.len();
    let plain = Plane::from_shape_fn((n, n), |(i, j)| gram(i, j));
    let mut rows = plain.clone();
    let mut gains = right.to_vec();
    for i in 0..n {
        rows[[i, i]] += ridge.max(1e-14);
    }
    for i in 0..n {
        for j in i + 1..n {
            let part = rows[[j, i]] / rows[[i, i]];
            for k in i..n {
                rows[[j, k]] -= part * rows[[i, k]];
            }
            gains[j] -= part * gains[i];
        }
    }
    for i in (0..n).rev() {
        for j in i + 1..n {
            gains[i] -= rows[[i, j]] * gains[j];
        }
        gains[i] /= rows[[i, i]];
    }
    let mut left = whole;
    for i in 0..n {
        left -= 2.0 * gains[i] * right[i];
        for j in 0..n {
            left += gains[i] * plain[[i, j]] * gains[j];
        }
    }
    let price = left + ridge * gains.iter().map(|gain| gain * gain).sum::<f64>();
    Candidate {
        lambdas,
        gains,
        left,
        price,
        ridge,
    }
}

/// Norm of the field outside a window of reach `(ry, rx)`, relative to the field.
fn tail(field: &Candidate, (ry, rx): (usize, usize)) -> f64 {
    let mut all = Plane::from_elem((GRID, GRID), field.gains[0]);
    for (gain, &lambdas) in field.gains[1..].iter().zip(&field.lambdas) {
        all.scaled_add(*gain, &surround(lambdas));
    }
    let whole = product(&all, &all);
    let mean = 1.0 / GRID as f64;
    let waves = |reach: usize| {
        Plane::from_shape_fn((reach + 1, GRID), |(d, i)| {
            mean * elementary::cos(frequency(i) * d as f64)
        })
    };
    let quarter = waves(ry).dot(&all).dot(&waves(rx).t());
    let inside: f64 = quarter
        .indexed_iter()
        .map(|((y, x), w)| w * w * if y > 0 { 2.0 } else { 1.0 } * if x > 0 { 2.0 } else { 1.0 })
        .sum();
    if whole > 0.0 {
        (1.0 - inside / whole).max(0.0).sqrt()
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fitted(kernel: &Kernel, sheets: usize) -> Fit {
        let how = Fitting {
            sheets,
            anisotropic: false,
            ridge: 1e-4,
        };
        fit(kernel, how).unwrap()
    }

    fn named(name: &str) -> Kernel {
        Kernel::builtin(name).unwrap()
    }

    fn near(got: f64, want: f64) {
        assert!((got / want - 1.0).abs() < 0.02, "{got}, not {want}");
    }

    /// Figures found apart from this code, with another grid and another search.
    #[test]
    fn known_fits() {
        for (name, one, two) in [("csdvs-5", 0.109, 0.088), ("laplacian", 0.060, 0.0438)] {
            let kernel = named(name);
            let (single, double) = (fitted(&kernel, 1), fitted(&kernel, 2));
            near(single.error, one);
            near(double.error, two);
            assert!(double.gain > single.gain && single.odd < 1e-15);
        }
        near(fitted(&named("laplacian"), 1).sheets[0].lambda_x, 0.275);
        near(fitted(&named("csdvs-5"), 1).sheets[0].lambda_x, 1.89);
    }

    /// Without a ridge two sheets run together: the least one that keeps them apart is taken, so that
    /// more sheets never reach less than with a larger ridge.
    #[test]
    fn no_ridge_is_no_reason_for_fewer_sheets() {
        let kernel = named("dog");
        let of = |sheets, ridge| {
            let how = Fitting {
                sheets,
                anisotropic: false,
                ridge,
            };
            fit(&kernel, how).unwrap()
        };
        for sheets in [2, 3] {
            let (none, some) = (of(sheets, 0.0), of(sheets, 1e-9));
            assert_eq!([none.sheets.len(), some.sheets.len()], [sheets; 2]);
            assert!(none.ridge > 0.0 && none.ridge <= 1e-9 && some.ridge == 1e-9);
            assert!(
                none.error <= some.error * 1.001,
                "{} {}",
                none.error,
                some.error
            );
        }
        assert_eq!(of(1, 0.0).ridge, 0.0);
        let sheet = fitted(&named("csdvs-5"), 2);
        assert_eq!(sheet.ridge, 1e-4);
    }

    /// A kernel that is a sheet's is found again, on every space constant between.
    #[test]
    fn a_sheet_is_found_again() {
        for (lambda_y, lambda_x) in [(0.5, 0.5), (1.3, 1.3), (0.3, 1.7), (2.0, 0.4)] {
            let side = 41;
            let sheet = super::super::Sheet::anisotropic(lambda_y, lambda_x).unwrap();
            let mut point = Plane::zeros((121, 121));
            point[[60, 60]] = 1.0;
            let size = crate::plane::Size::of(&point);
            let mut steady = super::super::Steady::new(sheet, size).unwrap();
            let spread = steady.solve(&point).unwrap();
            let weights = Plane::from_shape_fn((side, side), |(y, x)| {
                point[[y + 40, x + 40]] - 0.8 * spread[[y + 40, x + 40]]
            });
            let how = Fitting {
                sheets: 1,
                anisotropic: lambda_y != lambda_x,
                ridge: 0.0,
            };
            let found = fit(&Kernel::new(weights).unwrap(), how).unwrap();
            assert!(found.error < 2e-3, "{lambda_y} {lambda_x}: {found:?}");
            let [sheet] = found.sheets[..] else {
                panic!("{found:?}")
            };
            near(sheet.lambda_y, lambda_y);
            near(sheet.lambda_x, lambda_x);
            near(sheet.gain, -0.8);
            near(found.centre, 1.0);
        }
    }

    /// A sheet is not split in two, which the ridge alone would pay for.
    #[test]
    fn sheets_differ() {
        for name in ["laplacian", "csdvs-5", "csdvs-7"] {
            let kernel = named(name);
            for sheets in 1..=3 {
                let found = fitted(&kernel, sheets).sheets;
                for (i, a) in found.iter().enumerate() {
                    let apart = |b: &FittedSheet| (a.lambda_x / b.lambda_x).ln().abs() > 0.04;
                    assert!(found[..i].iter().all(apart), "{name} {sheets}: {found:?}");
                }
            }
        }
        assert_eq!(
            fitted(&named("laplacian"), 3),
            fitted(&named("laplacian"), 2)
        );
    }

    /// What no resistors can do is named, and is all that is left of it.
    #[test]
    fn the_unreachable_part() {
        for name in ["sobel-x", "oblique-45", "binary-vertical"] {
            let found = fitted(&named(name), 2);
            assert_eq!((found.odd, found.error), (1.0, 1.0), "{name}");
            assert_eq!(found.gain, 0.0);
        }
        // A bar: even, the same in both mirrors, not on the diagonals.
        let bar = Kernel::from_rows(&[vec![0.0; 3], vec![1.0; 3], vec![0.0; 3]]).unwrap();
        let found = fitted(&bar, 2);
        assert!(found.odd < 1e-15 && found.mirrored < 1e-15);
        // Of 1 1 1 across, half of both ends is not reached by equal resistors.
        near(found.turned, (1.0f64 / 3.0).sqrt());
        let how = Fitting {
            sheets: 2,
            anisotropic: true,
            ridge: 1e-4,
        };
        let better = fit(&bar, how).unwrap();
        assert!(better.error < 0.8 * found.error, "{better:?}");
        assert!(found.error >= found.turned && better.error >= better.mirrored);
    }

    /// A kernel of one weight is the pixel itself: no sheet, whatever may be used.
    #[test]
    fn a_pixel_alone_needs_no_sheet() {
        let alone = Kernel::from_rows(&[vec![0.0; 3], vec![0.0, -2.0, 0.0], vec![0.0; 3]]).unwrap();
        for (kernel, weight) in [(named("dvs"), 1.0), (alone, -2.0)] {
            for sheets in 1..=3 {
                let found = fitted(&kernel, sheets);
                assert!(found.sheets.is_empty(), "{found:?}");
                assert_eq!((found.centre, found.uniform), (weight, weight));
                assert_eq!((found.error, found.gain), (0.0, 1.0));
            }
        }
        // The centre is all that can be reached of it; the rest is odd.
        let odd = Kernel::from_rows(&[vec![-1.0, 1.0, 1.0]]).unwrap();
        let found = fitted(&odd, 2);
        assert!(found.sheets.is_empty() && found.odd > 0.8);
        assert!((found.error - found.odd).abs() < 1e-15, "{found:?}");
    }

    #[test]
    fn nothing_cannot_be_fitted() {
        let zero = Kernel::from_rows(&[vec![0.0]]).unwrap();
        let how = |sheets| Fitting {
            sheets,
            anisotropic: false,
            ridge: 1e-4,
        };
        assert!(fit(&zero, how(1)).is_err());
        for sheets in [0, 4] {
            assert!(fit(&named("dvs"), how(sheets)).is_err());
        }
    }
}
