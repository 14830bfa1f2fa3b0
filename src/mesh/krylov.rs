//! A network of unequal parts in time, by a Krylov subspace method.
//!
//! Over an interval in which the signal is a straight line, the state is a particular solution
//! (also a straight line) and a transient that decays: `exp(-t C⁻¹ K)` of its initial value. The
//! exponential is applied in a Lanczos subspace (Saad, SIAM J. Numer. Anal. 29(1):209-228, 1992),
//! which grows until the residual is negligible. The residual has a rigorous bound: it enters
//! through the last basis vector alone and can only decay, so it is at most the integral over time
//! of that vector's coefficient.

use super::{MeshError, Network, network::dot, signal::check_time};
use crate::{elementary, plane::Plane};

/// Most basis vectors; an interval that needs more is cut in two.
const MAX_BASIS: usize = 96;
/// Most pieces of an interval; for a grid of 256x256 each takes a second.
const MAX_PIECES: u64 = 4000;
/// Bound on the relative residual outside the subspace.
const NOTHING: f64 = 1e-14;
/// A transient that has decayed by this many e-folds is dropped.
const GONE: f64 = 40.0;

impl Network {
    /// The state after `seconds`, over which the signal goes from `earlier` to `later` in a
    /// straight line. `seconds` is in the unit of capacitance over conductance.
    ///
    /// # Errors
    /// When a plane has another size or a pixel that is no number, the time is none, the
    /// laterals are not resistors, or the network is so stiff that the time would have to be cut
    /// into more than four thousand pieces.
    pub fn advance(
        &self,
        surround: &Plane<f64>,
        (earlier, later): (&Plane<f64>, &Plane<f64>),
        seconds: f64,
    ) -> Result<Plane<f64>, MeshError> {
        if !self.is_linear() {
            return Err(MeshError::Laterals);
        }
        check_time("time", seconds)?;
        let state = self.values(surround)?;
        let (p0, p1) = (self.values(earlier)?, self.values(later)?);
        if seconds == 0.0 {
            return Ok(surround.clone());
        }
        let weighed = |p: &[f64]| -> Vec<f64> {
            p.iter().zip(&self.transverse).map(|(p, g)| p * g).collect()
        };
        let (settled, rise) = (
            self.taken_up(&weighed(&p0))?,
            self.taken_up(&weighed(&minus(&p1, &p0)))?,
        );
        // The constant lag of the state behind a signal that rises linearly.
        let charge: Vec<f64> = rise
            .iter()
            .zip(&self.capacitance)
            .map(|(h, c)| h * c / seconds)
            .collect();
        let behind = self.taken_up(&charge)?;
        let roots: Vec<f64> = self.capacitance.iter().map(|c| c.sqrt()).collect();
        let rest = state.iter().zip(&settled).zip(&behind).zip(&roots);
        let mut rest: Vec<f64> = rest.map(|(((h, s), b), root)| (h - s + b) * root).collect();
        // No mode decays more slowly than by the smallest `g/C`, the weakest tie to a signal.
        let ties = self.transverse.iter().zip(&self.capacitance);
        let slowest = ties.map(|(g, c)| g / c).fold(f64::INFINITY, f64::min);
        let mut left = seconds;
        if slowest * seconds > GONE {
            rest.fill(0.0);
            left = 0.0;
        }
        let mut piece = seconds;
        while left > 0.0 {
            piece = piece.min(left);
            match self.faded(&rest, &roots, piece) {
                Some(after) => {
                    rest = after;
                    left -= piece;
                }
                None => piece *= 0.5,
            }
            if piece * (MAX_PIECES as f64) < left {
                return Err(MeshError::Steps {
                    what: "network",
                    most: MAX_PIECES,
                });
            }
        }
        let moved: Vec<f64> = (0..rest.len())
            .map(|i| settled[i] + rise[i] - behind[i] + rest[i] / roots[i])
            .collect();
        Ok(self.plane(&moved))
    }

    /// `exp(-t C^-1/2 K C^-1/2)` of a vector; `None` if the subspace is too small for the interval.
    fn faded(&self, from: &[f64], roots: &[f64], time: f64) -> Option<Vec<f64>> {
        let length = dot(from, from).sqrt();
        if length == 0.0 {
            return Some(from.to_vec());
        }
        let mut basis = vec![from.iter().map(|v| v / length).collect::<Vec<f64>>()];
        let (mut own, mut next) = (Vec::new(), Vec::new());
        while let Some(last) = basis.last() {
            let voltages: Vec<f64> = last.iter().zip(roots).map(|(v, root)| v / root).collect();
            let pushed = self.pushed(&self.down, &self.across, &voltages);
            let mut new: Vec<f64> = pushed.iter().zip(roots).map(|(i, root)| i / root).collect();
            own.push(dot(&new, last));
            // Gram-Schmidt twice: rounding leaves a part of the older basis vectors the first time.
            for _ in 0..2 {
                for other in &basis {
                    let part = dot(&new, other);
                    for (new, other) in new.iter_mut().zip(other) {
                        *new -= part * other;
                    }
                }
            }
            let norm = dot(&new, &new).sqrt();
            let count = basis.len();
            let all = norm <= 1e-14 * own[0].abs() || count == from.len();
            if all || count.is_multiple_of(8) || count == MAX_BASIS {
                let shares = exponential(&own, &next, time);
                if all || norm * held_by_last(&own, &next, &shares) <= NOTHING {
                    let mut sum = vec![0.0; from.len()];
                    for (direction, share) in basis.iter().zip(&shares) {
                        for (sum, v) in sum.iter_mut().zip(direction) {
                            *sum += length * share * v;
                        }
                    }
                    return Some(sum);
                }
                if count == MAX_BASIS {
                    return None;
                }
            }
            next.push(norm);
            basis.push(new.iter().map(|v| v / norm).collect());
        }
        None
    }
}

/// The integral over the interval of the last basis vector's coefficient. With `T` tridiagonal it
/// is the last component of `T^-1 (1 - exp(-t T)) e1`, in which all terms have one sign, so nothing
/// cancels.
fn held_by_last(own: &[f64], next: &[f64], shares: &[f64]) -> f64 {
    let (mut sum, mut pivot) = (1.0 - shares[0], own[0]);
    for i in 1..own.len() {
        let factor = next[i - 1] / pivot;
        sum = -shares[i] - factor * sum;
        pivot = own[i] - factor * next[i - 1];
    }
    (sum / pivot).abs()
}

fn minus(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

/// The first column of `exp(-t T)` for a symmetric tridiagonal `T`, by scaling and squaring: a
/// Taylor series for an interval so short that it converges at once, doubled again and again.
fn exponential(own: &[f64], next: &[f64], time: f64) -> Vec<f64> {
    let n = own.len();
    let norm: f64 = (0..n)
        .map(|i| own[i].abs() + 2.0 * next.get(i).copied().unwrap_or(0.0))
        .fold(0.0, f64::max);
    let doublings = elementary::log2((norm * time).max(0.25)).ceil() as i32 + 2;
    let short = time / 2f64.powi(doublings);
    let entry = |i: usize, j: usize| match i.abs_diff(j) {
        0 => -short * own[i],
        1 => -short * next.get(i.min(j)).copied().unwrap_or(0.0),
        _ => 0.0,
    };
    let unit = |i: usize, j: usize| if i == j { 1.0 } else { 0.0 };
    let mut term = Plane::from_shape_fn((n, n), |(i, j)| unit(i, j));
    let mut sum = term.clone();
    let short_t = Plane::from_shape_fn((n, n), |(i, j)| entry(i, j));
    for k in 1..14 {
        term = term.dot(&short_t) / f64::from(k);
        sum += &term;
    }
    for _ in 0..doublings {
        sum = sum.dot(&sum);
    }
    sum.column(0).to_vec()
}
