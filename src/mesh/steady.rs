//! The settled state of a uniform grid, exactly, in `O(N log N)`: a cosine transform along the
//! rows, and for each mode a tridiagonal system (a ladder of resistors) down the columns.
//!
//! The modes of the rows split the grid into independent ladders, one for each mode `k`:
//!
//! ```text
//! (s + λy² n) h[y] - λy² (h[y-1] + h[y+1]) = p[y]        s = 1 + λx² μ(k), n = 1 or 2 neighbours
//! ```
//!
//! A ladder is solved by Gaussian elimination from the top down and substitution from the bottom
//! up. The variable that is eliminated is not the pivot `s + λy² n`, in which a large `λ` swallows
//! the 1, but the node's conductance to its signal, `e`, with which the pivot is `e + λy²` and the
//! next node's `e` is `s + λy² e / (e + λy²)`. Nothing is subtracted anywhere, so every pivot is
//! right to its last digits whatever the `λ` (the argument of Grassmann, Taksar and Heyman,
//! Operations Research 33(5):1107-1116, 1985), and the error does not grow with the condition
//! number `1 + 8 λ²`.
//!
//! The middle of the signal's range is subtracted first and added at the end, and the result is
//! clamped to that range, in which the exact one lies: uniform light comes back to the bit.

use multiversion::multiversion;

use super::{Float, MeshError, Sheet, cosine::Cosine, sheet::eigenvalues, signal::checked_range};
use crate::plane::{Plane, Size};

/// A solver for sheets of one size and space constant.
#[derive(Clone, Debug)]
pub struct Steady<T: Float = f64> {
    sheet: Sheet,
    size: Size,
    cosine: Cosine<T>,
    /// `λy²`.
    lateral: T,
    /// Row by row, the reciprocal pivot of each mode.
    pivots: Vec<T>,
    /// A row of zeros that makes a pair with the last row of an odd number.
    spare: Vec<T>,
}

impl<T: Float> Steady<T> {
    /// Prepares for signals of `size`.
    ///
    /// # Errors
    /// When the size is empty, or the space constant beyond what the number can hold.
    pub fn new(sheet: Sheet, size: Size) -> Result<Self, MeshError> {
        if size.pixels() == 0 {
            return Err(MeshError::Empty { size });
        }
        let (lambda_y, lambda_x) = sheet.lambdas();
        let value = lambda_y.max(lambda_x);
        if value > T::MOST_LAMBDA {
            let most = T::MOST_LAMBDA;
            return Err(MeshError::Lambda { value, most });
        }
        let lateral = lambda_y * lambda_y;
        let own: Vec<f64> = eigenvalues(size.width)
            .map(|mu| 1.0 + lambda_x * lambda_x * mu)
            .collect();
        let mut pivots = Vec::with_capacity(size.pixels());
        let mut to_signal = own.clone();
        for y in 0..size.height {
            let on = if y + 1 < size.height { lateral } else { 0.0 };
            for (e, s) in to_signal.iter_mut().zip(&own) {
                let pivot = *e + on;
                pivots.push(T::nearest(1.0 / pivot));
                *e = s + lateral * (*e / pivot);
            }
        }
        Ok(Self {
            sheet,
            size,
            cosine: Cosine::new(size.width),
            lateral: T::nearest(lateral),
            pivots,
            spare: vec![T::nearest(0.0); size.width],
        })
    }

    /// The sheet.
    #[must_use]
    pub const fn sheet(&self) -> Sheet {
        self.sheet
    }

    /// The settled `H` of `signal`, `[y, x]`, in the signal's unit.
    ///
    /// # Errors
    /// When the signal has another size than the sheet, or a pixel that is no number.
    pub fn solve(&mut self, signal: &Plane<T>) -> Result<Plane<T>, MeshError> {
        let mut surround = Plane::from_elem(self.size.shape(), T::nearest(0.0));
        self.solve_into(signal, &mut surround)?;
        Ok(surround)
    }

    /// [`Steady::solve`] into a plane that is there already.
    ///
    /// # Errors
    /// As [`Steady::solve`]; the plane is then as it was.
    pub fn solve_into(
        &mut self,
        signal: &Plane<T>,
        surround: &mut Plane<T>,
    ) -> Result<(), MeshError> {
        for got in [Size::of(signal), Size::of(surround)] {
            if got != self.size {
                let want = self.size;
                return Err(MeshError::Size { got, want });
            }
        }
        let (low, high) = checked_range(signal)?;
        if self.sheet.lambdas() == (0.0, 0.0) || low == high {
            surround.assign(signal);
            return Ok(());
        }
        if !surround.is_standard_layout() {
            *surround = Plane::from_elem(self.size.shape(), T::nearest(0.0));
        }
        surround.assign(signal);
        let off = low + (high - low) * T::nearest(0.5);
        if let Some(values) = surround.as_slice_mut() {
            self.down(values, off);
            self.up(values, (low, off, high));
        }
        Ok(())
    }

    /// Transforms the rows to modes and eliminates from the top to the bottom.
    fn down(&mut self, values: &mut [T], off: T) {
        let width = self.size.width;
        let mut above: Option<(&[T], &[T])> = None;
        let rows = values.chunks_mut(2 * width);
        for (rows, pivots) in rows.zip(self.pivots.chunks(2 * width)) {
            let (a, b) = rows.split_at_mut(width);
            let (pivots_a, pivots_b) = pivots.split_at(width);
            if b.is_empty() {
                self.spare.fill(off);
                self.cosine.forward(a, &mut self.spare, off);
            } else {
                self.cosine.forward(a, b, off);
            }
            eliminate(a, above, self.lateral);
            eliminate(b, Some((a, pivots_a)), self.lateral);
            above = Some(if b.is_empty() {
                (a, pivots_a)
            } else {
                (b, pivots_b)
            });
        }
    }

    /// Substitutes from the bottom to the top and transforms modes back to rows.
    fn up(&mut self, values: &mut [T], range: (T, T, T)) {
        let width = self.size.width;
        let mut below = vec![T::nearest(0.0); width];
        let rows = values.chunks_mut(2 * width).rev();
        for (rows, pivots) in rows.zip(self.pivots.chunks(2 * width).rev()) {
            let (a, b) = rows.split_at_mut(width);
            let (pivots_a, pivots_b) = pivots.split_at(width);
            if b.is_empty() {
                substitute(a, &below, pivots_a, self.lateral);
                below.copy_from_slice(a);
                self.spare.fill(T::nearest(0.0));
                self.cosine.inverse(a, &mut self.spare);
            } else {
                substitute(b, &below, pivots_b, self.lateral);
                substitute(a, b, pivots_a, self.lateral);
                below.copy_from_slice(a);
                self.cosine.inverse(a, b);
            }
            put_back(rows, range);
        }
    }
}

/// `q[y] = p[y] + (l / pivot[y-1]) q[y-1]`, of the row above and its pivots. The factor is at most
/// 1, so nothing overflows or underflows, whatever `l` is.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn eliminate<T: Float>(row: &mut [T], above: Option<(&[T], &[T])>, lateral: T) {
    let Some((above, pivots)) = above else {
        return;
    };
    for ((q, above), pivot) in row.iter_mut().zip(above).zip(pivots) {
        *q = *q + lateral * *pivot * *above;
    }
}

/// `h[y] = q[y] / pivot[y] + (l / pivot[y]) h[y+1]`.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn substitute<T: Float>(row: &mut [T], below: &[T], pivots: &[T], lateral: T) {
    for ((q, below), pivot) in row.iter_mut().zip(below).zip(pivots) {
        *q = *q * *pivot + lateral * *pivot * *below;
    }
}

/// Adds the middle back, and clamps to the range of the signal.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn put_back<T: Float>(values: &mut [T], (low, off, high): (T, T, T)) {
    for value in values {
        let whole = *value + off;
        let whole = if whole < low { low } else { whole };
        *value = if whole > high { high } else { whole };
    }
}
