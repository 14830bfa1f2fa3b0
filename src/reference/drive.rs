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
//!
//! Where a product is many instructions, as in all formats but f32 and f64, and a kernel has few
//! different weights, as a surround of equal ones has, each pixel is multiplied once by each of
//! those, and a sum is additions alone: the same products in the same order.

use multiversion::multiversion;

use crate::{
    kernel::Kernel,
    number::{Format, Number, Real},
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
    shared: Option<Shared<H>>,
}

/// The weights of a kernel that has few different ones.
#[derive(Clone, Debug)]
struct Shared<H> {
    /// Each once.
    weights: Vec<H>,
    /// Which of them stands where, row by row of the kernel.
    places: Vec<Place>,
}

#[derive(Clone, Copy, Debug)]
struct Place {
    /// Number of the weight.
    weight: usize,
    row: usize,
    column: usize,
}

/// What the different weights of a channel make of each pixel of a band: a plane for each, one
/// after the other; none where a product is made anew for each sum.
#[derive(Clone, Debug, Default)]
pub(super) struct Products<H>(Vec<H>);

impl<H: Copy + Default + Send + Sync> Weights<H> {
    pub(super) fn new<N: Number<Held = H>>(number: &N, kernels: &[Kernel]) -> Self {
        let held = |kernel: &Kernel| {
            let rows = kernel.weights().rows().into_iter();
            let rows = rows.map(|row| row.iter().map(|w| number.hold(*w)).collect());
            let rows: Vec<Vec<H>> = rows.collect();
            Held {
                shared: Shared::new(number, &rows),
                rows,
                reach: kernel.reach(),
            }
        };
        Self {
            kernels: kernels.iter().map(held).collect(),
        }
    }

    /// Makes the products of all pixels, where they are made once.
    pub(super) fn multiply<N: Number<Held = H>>(
        &self,
        number: &N,
        padded: &Padded<H>,
        products: &mut Products<H>,
    ) {
        let Some(shared) = self.shared() else { return };
        let values = padded.all();
        let Products(products) = products;
        products.resize(shared.weights.len() * values.len(), N::ZERO);
        let planes = products.chunks_mut(values.len().max(1));
        for (&weight, plane) in shared.weights.iter().zip(planes) {
            scale(number, weight, values, plane);
        }
    }

    /// The weights of which products are made once.
    fn shared(&self) -> Option<&Shared<H>> {
        match &self.kernels[..] {
            [one] => one.shared.as_ref(),
            _ => None,
        }
    }

    /// As [`Weights::row`], from the products if there are some.
    pub(super) fn row_of<N: Number<Held = H>>(
        &self,
        number: &N,
        (padded, products): (&Padded<H>, &Products<H>),
        y: usize,
        out: &mut [H],
        other: &mut [H],
    ) {
        match (&self.kernels[..], self.shared()) {
            ([one], Some(shared)) => {
                let (at, stride) = (padded.place(y, one.reach), padded.stride());
                let plane = padded.all().len();
                let at =
                    |place: &Place| place.weight * plane + at + place.row * stride + place.column;
                let places: Vec<_> = shared.places.iter().map(at).collect();
                add_up(number, &places, &products.0, out);
            }
            _ => self.row(number, padded, y, out, other),
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

impl<H: Copy> Shared<H> {
    /// None if it would not pay: each different weight takes a plane.
    fn new<N: Number<Held = H>>(number: &N, rows: &[Vec<H>]) -> Option<Self> {
        if matches!(number.format(), Format::F32 | Format::F64) {
            return None;
        }
        let mut shared = Self {
            weights: Vec::new(),
            places: Vec::new(),
        };
        for (row, weights) in rows.iter().enumerate() {
            for (column, &held) in weights.iter().enumerate() {
                let bits = |held| number.value(held).to_bits();
                let known = shared.weights.iter().position(|w| bits(*w) == bits(held));
                let weight = known.unwrap_or(shared.weights.len());
                if known.is_none() {
                    shared.weights.push(held);
                }
                shared.places.push(Place {
                    weight,
                    row,
                    column,
                });
            }
        }
        (4 * shared.weights.len() <= shared.places.len()).then_some(shared)
    }
}

#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn scale<N: Number>(number: &N, weight: N::Held, values: &[N::Held], out: &mut [N::Held]) {
    for (out, &value) in out.iter_mut().zip(values) {
        *out = number.mul(weight, value);
    }
}

/// Sums of what lies at these places of `source`, for each pixel of a row.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn add_up<N: Number>(number: &N, places: &[usize], source: &[N::Held], out: &mut [N::Held]) {
    const BLOCK: usize = 64;
    for (block, out) in out.chunks_mut(BLOCK).enumerate() {
        let mut sums = [N::ZERO; BLOCK];
        for &at in places {
            let start = at + block * BLOCK;
            let Some(source) = source.get(start..start + BLOCK) else {
                continue;
            };
            for (sum, &value) in sums.iter_mut().zip(source) {
                *sum = number.add(*sum, value);
            }
        }
        out.copy_from_slice(&sums[..out.len()]);
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
        number::{Bf16, F16, F64, Q},
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

    /// Whether products that are made once give the same sums as those made for each sum.
    fn products_give_the_same<N: Number>(number: &N, plane: &Plane<f64>, kernel: &Kernel) {
        let rows = 0..plane.nrows();
        let mut padded = Padded::new(Size::of(plane), rows.clone(), kernel.reach(), N::ZERO);
        for y in rows.clone() {
            let row = |row: &mut [N::Held]| {
                for (to, light) in row.iter_mut().zip(plane.row(y)) {
                    *to = number.hold(light / 7.0);
                }
                Ok::<(), ()>(())
            };
            padded.fill(y, Border::Replicate, N::ZERO, row).unwrap();
        }
        let weights = Weights::new(number, std::slice::from_ref(kernel));
        assert!(weights.shared().is_some());
        let mut products = Products::default();
        weights.multiply(number, &padded, &mut products);
        let mut other = vec![N::ZERO; plane.ncols()];
        let (mut once, mut anew) = (other.clone(), other.clone());
        for y in rows {
            weights.row_of(number, (&padded, &products), y, &mut once, &mut other);
            weights.row(number, &padded, y, &mut anew, &mut other);
            for (once, anew) in once.iter().zip(&anew) {
                let bits = |held: &N::Held| number.value(*held).to_bits();
                assert_eq!(bits(once), bits(anew));
            }
        }
    }

    proptest! {
        #[test]
        fn products_are_made_once_for_few_weights(
            plane in planes(),
            (reach_y, reach_x) in (1usize..3, 1usize..3),
            two in (-9i8..9, -9i8..9),
            which in proptest::collection::vec(any::<bool>(), 25),
        ) {
            let kernel = Plane::from_shape_fn((2 * reach_y + 1, 2 * reach_x + 1), |(y, x)| {
                f64::from(if which[y * 5 + x] { two.0 } else { two.1 }) / 24.0
            });
            let kernel = Kernel::new(kernel).unwrap();
            products_give_the_same(&F16, &plane, &kernel);
            products_give_the_same(&Bf16, &plane, &kernel);
            products_give_the_same(&Q::<i16>::new(12), &plane, &kernel);
        }

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
