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
//! Where the rows' length is one that is transformed slowly (346 = 2 · 173) and the columns' is not
//! (260), the transform runs down the columns and the ladders across: the same equations, of the
//! sheet on its side.
//!
//! The middle of the signal's range is subtracted first and added at the end, and the result is
//! clamped to that range, in which the exact one lies: uniform light comes back to the bit.

use multiversion::multiversion;

use super::{
    Float, MeshError, Sheet,
    cosine::{COLUMNS, Cosine},
    sheet::eigenvalues,
    signal::checked_range,
};
use crate::plane::{Plane, Size};

/// A solver for sheets of one size and space constant.
#[derive(Clone, Debug)]
pub struct Steady<T: Float = f64> {
    sheet: Sheet,
    size: Size,
    /// The modes of the columns, where they are transformed and the ladders run across.
    on_its_side: Option<Vec<T>>,
    cosine: Cosine<T>,
    /// `λ²` along the ladders.
    lateral: T,
    /// Rung by rung of the ladders, the reciprocal pivot of each mode.
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
        let turned = Cosine::<T>::burden(size.height) < Cosine::<T>::burden(size.width);
        let (rungs, length, along, across) = if turned {
            (size.width, size.height, lambda_x, lambda_y)
        } else {
            (size.height, size.width, lambda_y, lambda_x)
        };
        let lateral = along * along;
        let own: Vec<f64> = eigenvalues(length)
            .map(|mu| 1.0 + across * across * mu)
            .collect();
        let mut pivots = Vec::with_capacity(size.pixels());
        let mut to_signal = own.clone();
        for rung in 0..rungs {
            let on = if rung + 1 < rungs { lateral } else { 0.0 };
            for (e, s) in to_signal.iter_mut().zip(&own) {
                let pivot = *e + on;
                pivots.push(T::nearest(1.0 / pivot));
                *e = s + lateral * (*e / pivot);
            }
        }
        Ok(Self {
            sheet,
            size,
            on_its_side: turned.then(|| vec![T::nearest(0.0); size.pixels()]),
            cosine: Cosine::new(length),
            lateral: T::nearest(lateral),
            pivots,
            spare: vec![T::nearest(0.0); length],
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
        let off = low + (high - low) * T::nearest(0.5);
        if let Some(mut modes) = self.on_its_side.take() {
            if let Some(values) = signal.as_slice() {
                self.across(values, &mut modes, off);
            } else {
                surround.assign(signal);
                let values = surround.as_slice().unwrap_or_default();
                self.across(values, &mut modes, off);
            }
            let values = surround.as_slice_mut().unwrap_or_default();
            self.back(&mut modes, values, (low, off, high));
            self.on_its_side = Some(modes);
            return Ok(());
        }
        surround.assign(signal);
        if let Some(values) = surround.as_slice_mut() {
            self.down(values, off);
            self.up(values, (low, off, high));
        }
        Ok(())
    }

    /// [`Steady::down`] of the sheet on its side: columns to modes, from the left to the right.
    fn across(&mut self, values: &[T], modes: &mut [T], off: T) {
        let Size { height, width } = self.size;
        let mut above: Option<(&[T], &[T])> = None;
        let blocks = modes.chunks_mut(COLUMNS * height);
        let pivots = self.pivots.chunks(COLUMNS * height);
        for (block, (modes, pivots)) in blocks.zip(pivots).enumerate() {
            let columns = (values, width, COLUMNS * block);
            self.cosine.forward_columns(columns, off, modes);
            for (modes, pivots) in modes.chunks_mut(height).zip(pivots.chunks(height)) {
                eliminate(modes, above, self.lateral);
                above = Some((modes, pivots));
            }
        }
    }

    /// [`Steady::up`] of the sheet on its side: from the right to the left, modes to columns.
    fn back(&mut self, modes: &mut [T], values: &mut [T], range: (T, T, T)) {
        let Size { height, width } = self.size;
        self.spare.fill(T::nearest(0.0));
        let blocks = modes.chunks_mut(COLUMNS * height);
        let blocks = blocks.zip(self.pivots.chunks(COLUMNS * height));
        for (block, (modes, pivots)) in blocks.enumerate().rev() {
            let mut below = &self.spare[..];
            for (modes, pivots) in modes.chunks_mut(height).zip(pivots.chunks(height)).rev() {
                substitute(modes, below, pivots, self.lateral);
                below = modes;
            }
            let columns = (&mut *values, width, COLUMNS * block);
            self.cosine
                .inverse_columns(modes, columns, |value| whole(value, range));
            self.spare.copy_from_slice(&modes[..height]);
        }
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
fn put_back<T: Float>(values: &mut [T], range: (T, T, T)) {
    for value in values {
        *value = whole(*value, range);
    }
}

/// A value with the middle added, clamped.
#[inline]
fn whole<T: Float>(value: T, (low, off, high): (T, T, T)) -> T {
    let whole = value + off;
    let whole = if whole < low { low } else { whole };
    if whole > high { high } else { whole }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// To the bit: a sheet on its side is the sheet that is turned, turned back.
        #[test]
        fn on_its_side_is_the_same_sheet(
            (height, width) in (1usize..40, prop_oneof![Just(13usize), Just(26), Just(17), Just(34), Just(47), Just(94)]),
            lambdas in (0f64..20.0, 0f64..20.0),
            seed in 1u64..1000,
        ) {
            prop_assume!(Cosine::<f64>::burden(height) == 0);
            let random = |(y, x): (usize, usize)| {
                ((seed ^ (y * 97 + x) as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40) as f64
            };
            let signal = Plane::from_shape_fn((height, width), random);
            let turned = Plane::from_shape_fn((width, height), |(x, y)| random((y, x)));
            let sheet = Sheet::anisotropic(lambdas.0, lambdas.1).unwrap();
            let mut own = Steady::<f64>::new(sheet, Size::of(&signal)).unwrap();
            prop_assert!(own.on_its_side.is_some());
            let sheet = Sheet::anisotropic(lambdas.1, lambdas.0).unwrap();
            let mut other = Steady::<f64>::new(sheet, Size::of(&turned)).unwrap();
            prop_assert!(other.on_its_side.is_none());
            let own = own.solve(&signal).unwrap();
            let other = other.solve(&turned).unwrap();
            for ((x, y), value) in other.indexed_iter() {
                prop_assert_eq!(value.to_bits(), own[(y, x)].to_bits());
            }
        }
    }

    #[test]
    fn slow_lengths_are_known() {
        let burdens = [1, 2, 256, 330, 260, 257, 173, 346, 251].map(Cosine::<f64>::burden);
        assert_eq!(burdens, [0, 0, 0, 0, 1, 1, 2, 2, 1]);
    }
}
