//! The weights of a channel, and the rows of drive that they compute.

use crate::{
    elementary,
    kernel::Kernel,
    number::{Number, Real},
    reference::signal::{BLOCK, Padded},
};

use super::{
    line::{Line, add_rows, correlate, correlate_two},
    product::{Place, Shared, add_up, scale},
    width::is_wide,
};

/// The kernels of a channel, as a number format holds them: one, or four in a 2x2 pattern.
#[derive(Clone, Debug)]
pub(crate) struct Weights<H> {
    kernels: Vec<Held<H>>,
}

/// One kernel: its weights.
#[derive(Clone, Debug)]
struct Held<H> {
    lines: Vec<Line<H>>,
    reach: (usize, usize),
    shared: Option<Shared<H>>,
}

/// Working memory for a row of drive.
#[derive(Clone, Debug, Default)]
pub(crate) struct Parts<H> {
    /// Sums of rows that have equal weights, one after the other.
    sums: Vec<H>,
    /// The drive by the second kernel of a pattern.
    other: Vec<H>,
}

/// Intermediate results of a channel for the pixels of a band.
#[derive(Clone, Debug, Default)]
pub(crate) struct Made<H> {
    /// The products of all pixels with the different weights, one plane after the other; empty
    /// where products are not shared.
    products: Vec<H>,
    /// A row of sums that was computed along with the one above it.
    ahead: Vec<H>,
    /// Its number, if there is one.
    row: Option<usize>,
}

impl<H: Copy + Default + Send + Sync> Weights<H> {
    pub(crate) fn new<N: Number<Held = H>>(number: &N, kernels: &[Kernel]) -> Self {
        let held = |kernel: &Kernel| {
            let rows = kernel.weights().rows().into_iter();
            let rows = rows.map(|row| row.iter().map(|w| number.hold(*w)).collect());
            let rows: Vec<Vec<H>> = rows.collect();
            Held {
                shared: Shared::new(number, &rows),
                lines: Line::all(number, rows),
                reach: kernel.reach(),
            }
        };
        Self {
            kernels: kernels.iter().map(held).collect(),
        }
    }

    /// Computes the products of all pixels, where they are shared.
    pub(in crate::reference) fn multiply<N: Number<Held = H>>(
        &self,
        number: &N,
        padded: &Padded<H>,
        Made { products, .. }: &mut Made<H>,
    ) {
        let Some(shared) = self.shared() else { return };
        let values = padded.all();
        products.resize(shared.weights.len() * values.len(), N::ZERO);
        let planes = products.chunks_mut(values.len().max(1));
        for (&weight, plane) in shared.weights.iter().zip(planes) {
            scale(number, weight, values, plane);
        }
    }

    /// The different weights, where products are shared.
    fn shared(&self) -> Option<&Shared<H>> {
        match &self.kernels[..] {
            [one] => one.shared.as_ref(),
            _ => None,
        }
    }

    /// As [`Weights::row`], of pixels whose products were computed; rows must be asked for in
    /// order, as row `y + 1` may be computed along.
    pub(crate) fn row_in_order<N: Number<Held = H>>(
        &self,
        number: &N,
        (padded, made): (&Padded<H>, &mut Made<H>),
        y: usize,
        out: &mut [H],
        parts: &mut Parts<H>,
    ) {
        let [one] = &self.kernels[..] else {
            return self.row(number, padded, y, out, parts);
        };
        if let Some(shared) = &one.shared {
            let (at, stride) = (padded.place(y, one.reach), padded.stride());
            let plane = padded.all().len();
            let at = |place: &Place| place.weight * plane + at + place.row * stride + place.column;
            let places: Vec<_> = shared.places.iter().map(at).collect();
            add_up(number, &places, &made.products, out);
        } else if made.row.take() == Some(y) {
            out.copy_from_slice(&made.ahead);
        } else if one.pays_in_pairs(number) && padded.rows().contains(&(y + 1)) {
            made.row = Some(y + 1);
            made.ahead.resize(out.len(), N::ZERO);
            one.two_rows(number, padded, y, (out, &mut made.ahead));
        } else {
            one.row(number, padded, y, out, &mut parts.sums);
        }
    }

    /// Row `y` of `W * plane`; with four kernels, the pixel at (x, y) uses number
    /// `2 (y mod 2) + (x mod 2)`.
    pub(crate) fn row<N: Number<Held = H>>(
        &self,
        number: &N,
        padded: &Padded<H>,
        y: usize,
        out: &mut [H],
        parts: &mut Parts<H>,
    ) {
        match &self.kernels[..] {
            [one] => one.row(number, padded, y, out, &mut parts.sums),
            four => {
                let Parts { sums, other } = parts;
                other.resize(out.len(), N::ZERO);
                four[2 * (y % 2)].row(number, padded, y, out, sums);
                four[2 * (y % 2) + 1].row(number, padded, y, other, sums);
                for (to, from) in out.iter_mut().zip(other).skip(1).step_by(2) {
                    *to = *from;
                }
            }
        }
    }
}

impl<H: Copy + Default + Send + Sync> Held<H> {
    /// Whether two rows together take less time than one after the other: where no equal rows of
    /// the kernel are added first.
    fn pays_in_pairs<N: Number<Held = H>>(&self, number: &N) -> bool {
        is_wide(number)
            && self.lines.len() > 1
            && self.lines.iter().all(|line| line.rows.len() == 1)
    }

    /// Rows `y` and `y + 1`.
    fn two_rows<N: Number<Held = H>>(
        &self,
        number: &N,
        padded: &Padded<H>,
        y: usize,
        rows: (&mut [H], &mut [H]),
    ) {
        let source = padded.from(y, self.reach);
        // So many that the sums fill eight vector registers.
        if size_of::<H>() > 4 {
            correlate_two::<N, 32, 16>(number, &self.lines, source, rows);
        } else {
            correlate_two::<N, 64, 32>(number, &self.lines, source, rows);
        }
    }

    fn row<N: Number<Held = H>>(
        &self,
        number: &N,
        padded: &Padded<H>,
        y: usize,
        out: &mut [H],
        sums: &mut Vec<H>,
    ) {
        let (source, stride) = padded.from(y, self.reach);
        let whole = out.len().next_multiple_of(BLOCK) + 2 * self.reach.1;
        let summed = self.lines.iter().filter(|line| line.rows.len() > 1);
        sums.resize(summed.clone().count() * whole, N::ZERO);
        for (line, sum) in summed.zip(sums.chunks_mut(whole)) {
            add_rows(number, &line.rows, (source, stride), sum);
        }
        let sums = (&sums[..], whole);
        // So many that the sums fill eight vector registers.
        if size_of::<H>() > 4 {
            correlate::<N, 32, true>(number, &self.lines, (source, stride), sums, out);
        } else {
            correlate::<N, 64, true>(number, &self.lines, (source, stride), sums, out);
        }
    }
}

/// `ln(max(S, floor) + 1)`: the released simulator's `log_temporal`, defined for every `S`.
///
/// It floors at 1e-8, and its first memory at 0.
pub(crate) fn log_temporal<N: Number>(number: &N, drive: &mut [N::Held], floor: f64) {
    for s in drive {
        *s = number.hold(elementary::ln(number.real(*s).to_f64().max(floor) + 1.0));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        number::{Bf16, F16, F32, F64, Q},
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
            // Many have equal rows.
            let weights = proptest::collection::vec(-9i8..9, h * w);
            let rows = proptest::collection::vec(0..h, h);
            (weights, rows).prop_map(move |(weights, rows)| {
                Kernel::new(Plane::from_shape_fn((h, w), |(y, x)| {
                    f64::from(weights[rows[y] * w + x])
                }))
                .unwrap()
            })
        })
    }

    /// Whether rows are the same in order as each by itself, frame after frame.
    fn order_changes_nothing<N: Number>(number: &N, plane: &Plane<f64>, kernel: &Kernel) {
        let rows = 0..plane.nrows();
        let mut padded = Padded::new(Size::of(plane), rows.clone(), kernel.reach(), N::ZERO);
        let weights = Weights::new(number, std::slice::from_ref(kernel));
        let (mut made, mut parts) = (Made::default(), Parts::default());
        let mut in_order = vec![N::ZERO; plane.ncols()];
        let mut alone = in_order.clone();
        for brightness in [7.0, 3.0] {
            for y in rows.clone() {
                let row = |row: &mut [N::Held]| {
                    for (to, light) in row.iter_mut().zip(plane.row(y)) {
                        *to = number.hold(light / brightness);
                    }
                    Ok::<(), ()>(())
                };
                padded.fill(y, Border::Replicate, N::ZERO, row).unwrap();
            }
            weights.multiply(number, &padded, &mut made);
            for y in rows.clone() {
                weights.row_in_order(number, (&padded, &mut made), y, &mut in_order, &mut parts);
                weights.row(number, &padded, y, &mut alone, &mut parts);
                for (in_order, alone) in in_order.iter().zip(&alone) {
                    let bits = |held: &N::Held| number.value(*held).to_bits();
                    assert_eq!(bits(in_order), bits(alone));
                }
            }
        }
    }

    #[test]
    fn equal_rows_are_one_line_of_wide_floats() {
        let kernel = [Kernel::builtin("csdvs-5").unwrap()];
        let wide = Weights::new(&F64, &kernel);
        let rows: Vec<_> = wide.kernels[0].lines.iter().map(|l| &l.rows[..]).collect();
        assert_eq!(rows, [&[0, 1, 3, 4][..], &[2]]);
        assert_eq!(Weights::new(&F16, &kernel).kernels[0].lines.len(), 5);
        assert!(!wide.kernels[0].pays_in_pairs(&F64));
        let other = [Kernel::builtin("sobel-y").unwrap()];
        assert!(Weights::new(&F64, &other).kernels[0].pays_in_pairs(&F64));
    }

    proptest! {
        #[test]
        fn two_rows_are_one_after_the_other(plane in planes(), kernel in kernels()) {
            order_changes_nothing(&F32, &plane, &kernel);
            order_changes_nothing(&F64, &plane, &kernel);
        }

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
            let weights = Weights::new(&F16, std::slice::from_ref(&kernel));
            prop_assert!(weights.shared().is_some());
            order_changes_nothing(&F16, &plane, &kernel);
            order_changes_nothing(&Bf16, &plane, &kernel);
            order_changes_nothing(&Q::<i16>::new(12), &plane, &kernel);
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
            let mut parts = Parts::default();
            for y in 0..plane.nrows() {
                weights.row(&F64, &padded, y, &mut out, &mut parts);
                for (x, &value) in out.iter().enumerate() {
                    let kernel = &kernels[if pattern { 2 * (y % 2) + x % 2 } else { 0 }];
                    prop_assert_eq!(value, at(&plane, kernel, border, y, x));
                }
            }
        }
    }
}
