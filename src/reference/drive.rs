//! Drive: what a kernel sees.
//!
//! ```text
//! S(p) = sum over d of W(d) u(p + d)          u = R(I), the photoreceptor's signal
//! ```
//!
//! A correlation, as in the paper (So & Wetzstein, arXiv 2504.13457, Eq. 2) and in the
//! released code (`Conv2d`). What lies off the array is the nearest pixel (`replicate`) or
//! zero; zero is put in after the response, so that it means "no signal", not "no light".
//!
//! The sum is taken in the order of the kernel's rows, without fused multiply-add, so that
//! every machine gives the same bits.

use crate::{
    kernel::Kernel,
    plane::{Plane, Size},
};

use super::description::Border;

/// A plane with a rim, so that a kernel can be laid on every pixel; row after row.
#[derive(Clone, Debug)]
pub(super) struct Padded {
    values: Vec<f64>,
    size: Size,
    /// Rows above and below, columns left and right.
    rim: (usize, usize),
}

impl Padded {
    /// Room for planes of `size` under kernels that reach `rim` (rows, columns).
    pub(super) fn new(size: Size, rim: (usize, usize)) -> Self {
        let values = vec![0.0; (size.height + 2 * rim.0) * (size.width + 2 * rim.1)];
        Self { values, size, rim }
    }

    /// Takes a plane in and fills the rim.
    pub(super) fn fill(&mut self, plane: &Plane<f64>, border: Border) {
        let Size { height, width } = self.size;
        let (above, left) = self.rim;
        for (y, row) in self.values.chunks_exact_mut(width + 2 * left).enumerate() {
            let nearest = y.saturating_sub(above).min(height - 1);
            if border == Border::Zero && nearest + above != y {
                row.fill(0.0);
                continue;
            }
            let source = plane.row(nearest);
            for (to, from) in row[left..].iter_mut().zip(&source) {
                *to = *from;
            }
            let (west, east) = match border {
                Border::Replicate => (source[0], source[width - 1]),
                Border::Zero => (0.0, 0.0),
            };
            row[..left].fill(west);
            row[left + width..].fill(east);
        }
    }

    /// Row `y` of `kernel * plane`.
    fn row(&self, kernel: &Kernel, y: usize, out: &mut [f64]) {
        let (reach_y, reach_x) = kernel.reach();
        let stride = self.size.width + 2 * self.rim.1;
        out.fill(0.0);
        for (ky, weights) in kernel.weights().rows().into_iter().enumerate() {
            let start = (y + self.rim.0 - reach_y + ky) * stride + self.rim.1 - reach_x;
            for (kx, &weight) in weights.iter().enumerate() {
                let shifted = &self.values[start + kx..start + kx + out.len()];
                for (sum, &value) in out.iter_mut().zip(shifted) {
                    *sum += weight * value;
                }
            }
        }
    }

    /// `out = kernel * plane`; with four kernels, the pixel at (x, y) uses number
    /// `2 (y mod 2) + (x mod 2)`.
    pub(super) fn drive(&self, kernels: &[Kernel], out: &mut Plane<f64>) {
        let mut odd_columns = vec![0.0; self.size.width];
        for (y, mut row) in out.rows_mut().into_iter().enumerate() {
            let row = row
                .as_slice_mut()
                .expect("planes of the reference are contiguous");
            let [even, odd] = match kernels {
                [one] => {
                    self.row(one, y, row);
                    continue;
                }
                four => [&four[2 * (y % 2)], &four[2 * (y % 2) + 1]],
            };
            self.row(even, y, row);
            self.row(odd, y, &mut odd_columns);
            for (to, from) in row.iter_mut().zip(&odd_columns).skip(1).step_by(2) {
                *to = *from;
            }
        }
    }
}

/// `ln(max(S, floor) + 1)`: the released simulator's `log_temporal`, defined for every `S`.
///
/// It floors at 1e-8, and its first memory at 0.
pub(super) fn log_temporal(drive: &mut Plane<f64>, floor: f64) {
    drive.mapv_inplace(|s| (s.max(floor) + 1.0).ln());
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The slow twin: the definition, pixel by pixel.
    fn at(plane: &Plane<f64>, kernel: &Kernel, border: Border, y: usize, x: usize) -> f64 {
        let (height, width) = plane.dim();
        let (reach_y, reach_x) = kernel.reach();
        let mut sum = 0.0;
        for ((ky, kx), weight) in kernel.weights().indexed_iter() {
            let (py, px) = (
                (y + ky) as isize - reach_y as isize,
                (x + kx) as isize - reach_x as isize,
            );
            let (ny, nx) = (
                py.clamp(0, height as isize - 1),
                px.clamp(0, width as isize - 1),
            );
            if border == Border::Replicate || (ny, nx) == (py, px) {
                sum += weight * plane[[ny as usize, nx as usize]];
            }
        }
        sum
    }

    fn planes() -> impl Strategy<Value = Plane<f64>> {
        (1usize..9, 1usize..9).prop_flat_map(|(h, w)| {
            proptest::collection::vec(-9i8..9, h * w)
                .prop_map(move |v| Plane::from_shape_fn((h, w), |(y, x)| f64::from(v[y * w + x])))
        })
    }

    fn kernels() -> impl Strategy<Value = Kernel> {
        (0usize..4, 0usize..4).prop_flat_map(|(ry, rx)| {
            let (h, w) = (2 * ry + 1, 2 * rx + 1);
            proptest::collection::vec(-9i8..9, h * w).prop_map(move |v| {
                Kernel::new(Plane::from_shape_fn((h, w), |(y, x)| {
                    f64::from(v[y * w + x])
                }))
                .unwrap()
            })
        })
    }

    proptest! {
        #[test]
        fn rows_are_the_definition(plane in planes(), four in proptest::collection::vec(kernels(), 4), pattern: bool, zero: bool) {
            let border = if zero { Border::Zero } else { Border::Replicate };
            let kernels = if pattern { &four[..] } else { &four[..1] };
            let rim = kernels.iter().map(Kernel::reach).fold((0, 0), |a, b| (a.0.max(b.0), a.1.max(b.1)));
            let mut padded = Padded::new(Size::of(&plane), rim);
            padded.fill(&plane, border);
            let mut out = Plane::zeros(plane.dim());
            padded.drive(kernels, &mut out);
            for ((y, x), &value) in out.indexed_iter() {
                let kernel = &kernels[if pattern { 2 * (y % 2) + x % 2 } else { 0 }];
                prop_assert_eq!(value, at(&plane, kernel, border, y, x));
            }
        }
    }
}
