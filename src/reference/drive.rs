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
//! every machine gives the same bits. A block of pixels is summed at a time, so that the sums
//! stay in registers: one multiplication, one addition and one load for each weight and pixel.

use multiversion::multiversion;

use crate::{
    kernel::Kernel,
    number::{Number, Real},
};

use super::signal::Padded;

/// The kernels of a channel, as a number format holds them: one, or four in a 2x2 pattern.
#[derive(Clone, Debug)]
pub(super) struct Weights<H> {
    kernels: Vec<Held<H>>,
}

/// One kernel: its rows of weights.
#[derive(Clone, Debug)]
struct Held<H> {
    rows: Vec<Vec<H>>,
    reach: (usize, usize),
}

impl<H: Copy + Default + Send + Sync> Weights<H> {
    pub(super) fn new<N: Number<Held = H>>(number: &N, kernels: &[Kernel]) -> Self {
        let held = |kernel: &Kernel| Held {
            rows: kernel
                .weights()
                .rows()
                .into_iter()
                .map(|row| row.iter().map(|w| number.hold(*w)).collect())
                .collect(),
            reach: kernel.reach(),
        };
        Self {
            kernels: kernels.iter().map(held).collect(),
        }
    }

    /// Row `y` of `W * plane`; with four kernels, the pixel at (x, y) uses number
    /// `2 (y mod 2) + (x mod 2)`.
    pub(super) fn row<N: Number<Held = H>>(
        &self,
        number: &N,
        padded: &Padded<H>,
        y: usize,
        out: &mut [H],
        other: &mut [H],
    ) {
        match &self.kernels[..] {
            [one] => one.row(number, padded, y, out),
            four => {
                four[2 * (y % 2)].row(number, padded, y, out);
                four[2 * (y % 2) + 1].row(number, padded, y, other);
                for (to, from) in out.iter_mut().zip(other).skip(1).step_by(2) {
                    *to = *from;
                }
            }
        }
    }
}

impl<H: Copy + Default + Send + Sync> Held<H> {
    fn row<N: Number<Held = H>>(&self, number: &N, padded: &Padded<H>, y: usize, out: &mut [H]) {
        let source = padded.from(y, self.reach);
        // Eight vector registers of sums.
        if size_of::<H>() > 4 {
            correlate::<N, 32>(number, &self.rows, source, out);
        } else {
            correlate::<N, 64>(number, &self.rows, source, out);
        }
    }
}

#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn correlate<N: Number, const BLOCK: usize>(
    number: &N,
    rows: &[Vec<N::Held>],
    (source, stride): (&[N::Held], usize),
    out: &mut [N::Held],
) {
    for (block, out) in out.chunks_mut(BLOCK).enumerate() {
        let mut sums = [N::ZERO; BLOCK];
        for (row, weights) in rows.iter().enumerate() {
            let start = row * stride + block * BLOCK;
            let Some(source) = source.get(start..start + weights.len() - 1 + BLOCK) else {
                continue;
            };
            for (source, &weight) in source.windows(BLOCK).zip(weights) {
                for (sum, &value) in sums.iter_mut().zip(source) {
                    *sum = number.add(*sum, number.mul(weight, value));
                }
            }
        }
        out.copy_from_slice(&sums[..out.len()]);
    }
}

/// `ln(max(S, floor) + 1)`: the released simulator's `log_temporal`, defined for every `S`.
///
/// It floors at 1e-8, and its first memory at 0.
pub(super) fn log_temporal<N: Number>(number: &N, drive: &mut [N::Held], floor: f64) {
    for s in drive {
        *s = number.hold((number.real(*s).to_f64().max(floor) + 1.0).ln());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        number::F64,
        plane::{Plane, Size},
        reference::Border,
    };
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
        (1usize..9, 1usize..90).prop_flat_map(|(h, w)| {
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
            let mut padded = Padded::new(Size::of(&plane), 0..plane.nrows(), rim, 0.0);
            for y in 0..plane.nrows() {
                let row = |row: &mut [f64]| { row.copy_from_slice(&plane.row(y).to_vec()); Ok::<(), ()>(()) };
                padded.fill(y, border, 0.0, row).unwrap();
            }
            let weights = Weights::new(&F64, kernels);
            let mut out = vec![0.0; plane.ncols()];
            let mut other = out.clone();
            for y in 0..plane.nrows() {
                weights.row(&F64, &padded, y, &mut out, &mut other);
                for (x, &value) in out.iter().enumerate() {
                    let kernel = &kernels[if pattern { 2 * (y % 2) + x % 2 } else { 0 }];
                    prop_assert_eq!(value, at(&plane, kernel, border, y, x));
                }
            }
        }
    }
}
