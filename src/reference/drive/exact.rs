//! Which drives a fixed-point format does not hold: those that are not what held weights make of held
//! signals, by more than rounding.
//!
//! Sums of fixed point are exact, and each product is rounded once. So a drive that is off by more
//! than half a step a weight has left the format on its way: it was cut off, it came in again at the
//! other end, or a sum was cut off and came back.

use crate::{
    kernel::Kernel,
    number::{Format, Number},
    reference::signal::Padded,
    sensor::Overflowed,
};

/// The kernels of a channel as a fixed-point format holds them, in doubles: one, or four in a 2x2
/// pattern.
#[derive(Clone, Debug)]
pub(crate) struct Exact {
    kernels: Vec<Held>,
}

/// One kernel.
#[derive(Clone, Debug)]
struct Held {
    /// Its rows that have a weight, and their places.
    rows: Vec<(usize, Vec<f64>)>,
    reach: (usize, usize),
    /// The sizes of its weights, added up.
    size: f64,
    /// What rounding can do to a drive.
    rounding: f64,
    /// The end of the format that is nearer to 0.
    end: f64,
}

impl Exact {
    /// None where the format is not fixed point.
    pub(crate) fn new<N: Number>(number: &N, kernels: &[Kernel]) -> Option<Self> {
        let format = number.format();
        match format {
            // One with ends whose sums are rounded would need another bound.
            Format::F64 | Format::F32 | Format::F16 | Format::Bf16 => return None,
            Format::Fixed(_) => {}
        }
        let held = |kernel: &Kernel| {
            let weights = kernel.weights().mapv(|w| number.value(number.hold(w)));
            let rows = weights.rows().into_iter().map(|row| row.to_vec());
            let terms = weights.iter().filter(|w| **w != 0.0).count();
            Held {
                rows: { rows.enumerate() }
                    .filter(|(_, row)| row.iter().any(|w| *w != 0.0))
                    .collect(),
                reach: kernel.reach(),
                size: weights.iter().map(|w| w.abs()).sum(),
                rounding: terms as f64 * format.half_step(),
                end: format.limits().1,
            }
        };
        Some(Self {
            kernels: kernels.iter().map(held).collect(),
        })
    }

    /// Whether the format holds all that comes of signals of this size at most: their drives, and, of
    /// memories of drives, the differences of two.
    pub(crate) fn holds(&self, signal: f64, differences: bool) -> bool {
        let times = if differences { 2.0 } else { 1.0 };
        let holds = |it: &Held| times * it.most(signal) <= it.end;
        self.kernels.iter().all(holds)
    }

    /// Of the drives of row `y`.
    pub(crate) fn overflowed<N: Number>(
        &self,
        number: &N,
        padded: &Padded<N::Held>,
        y: usize,
        drive: &[N::Held],
    ) -> Overflowed {
        let at = match &self.kernels[..] {
            [one] => one.beyond(number, padded, y, drive, (0, 1)),
            four => (0..2)
                .filter_map(|x| Some((four.get(2 * (y % 2) + x)?, x)))
                .map(|(kernel, x)| kernel.beyond(number, padded, y, drive, (x, 2)))
                .sum(),
        };
        Overflowed {
            at,
            of: drive.len() as u64,
        }
    }
}

impl Held {
    /// The largest drive that signals of this size make, rounded.
    fn most(&self, signal: f64) -> f64 {
        // Sums of doubles are rounded, too.
        self.size * signal * (1.0 + 1e-9) + self.rounding
    }

    /// How many drives of row `y`, from a first column on and so many apart, are not held.
    fn beyond<N: Number>(
        &self,
        number: &N,
        padded: &Padded<N::Held>,
        y: usize,
        drive: &[N::Held],
        (first, apart): (usize, usize),
    ) -> u64 {
        let (source, stride) = padded.from(y, self.reach);
        let width = drive.len() + 2 * self.reach.1;
        let values = |row: usize| source[row * stride..][..width].iter();
        let most = self.rows.iter().flat_map(|(row, _)| values(*row));
        let most = most.fold(0.0, |most, held| f64::max(most, number.value(*held).abs()));
        let bound = self.rounding + self.size * most * f64::EPSILON * width as f64;
        // Nearly always no light of this row can make so much.
        if self.size * most + bound <= self.end {
            return 0;
        }
        let mut sums = vec![0.0; drive.len()];
        let mut signal = vec![0.0; width];
        for (row, weights) in &self.rows {
            for (to, held) in signal.iter_mut().zip(values(*row)) {
                *to = number.value(*held);
            }
            for (column, weight) in weights.iter().enumerate().filter(|(_, w)| **w != 0.0) {
                for (sum, signal) in sums.iter_mut().zip(&signal[column..]) {
                    *sum += weight * signal;
                }
            }
        }
        let cells = drive.iter().zip(&sums).skip(first).step_by(apart);
        let is_off =
            |(held, exact): &(&N::Held, &f64)| (number.value(**held) - **exact).abs() > bound;
        cells.filter(is_off).count() as u64
    }
}

/// The largest signal of a plane, without its sign.
pub(crate) fn largest<N: Number>(number: &N, padded: &Padded<N::Held>) -> f64 {
    let all = padded.all().iter();
    let (low, high) = all.fold((N::ZERO, N::ZERO), |(low, high), held| {
        (
            if *held < low { *held } else { low },
            if *held > high { *held } else { high },
        )
    });
    f64::max(-number.value(low), number.value(high))
}

/// Of numbers that were held, from what they were before.
pub(crate) fn held<N: Number>(number: &N, held: &[N::Held], reals: &[f64]) -> Overflowed {
    let half_step = number.format().half_step();
    let off = |(held, real): &(&N::Held, &f64)| (number.value(**held) - **real).abs() > half_step;
    Overflowed {
        at: held.iter().zip(reals).filter(off).count() as u64,
        of: held.len() as u64,
    }
}

/// Of the differences of held numbers, which a fixed-point format holds exactly, or not at all.
pub(crate) fn differences<N: Number>(number: &N, one: &[N::Held], other: &[N::Held]) -> Overflowed {
    let is_off = |(a, b): &(&N::Held, &N::Held)| {
        number.value(number.sub(**a, **b)) != number.value(**a) - number.value(**b)
    };
    Overflowed {
        at: one.iter().zip(other).filter(is_off).count() as u64,
        of: one.len() as u64,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        number::{F64, Q},
        plane::{Plane, Size},
        reference::{
            Border,
            drive::{Parts, Weights},
        },
    };

    /// The drives of one row of light under kernels, and how many are not held.
    fn row(number: Q<i16>, kernels: &[Vec<Vec<f64>>], light: &[f64]) -> (Vec<f64>, Overflowed) {
        let kernels: Vec<_> = { kernels.iter() }
            .map(|rows| Kernel::from_rows(rows).unwrap())
            .collect();
        let reach = { kernels.iter() }.fold((0, 0), |reach: (usize, usize), kernel| {
            let own = kernel.reach();
            (reach.0.max(own.0), reach.1.max(own.1))
        });
        let mut padded = Padded::new(Size::new(1, light.len()), 0..1, reach, 0);
        let fill = |row: &mut [i16]| {
            for (to, light) in row.iter_mut().zip(light) {
                *to = number.hold(*light);
            }
            Ok::<(), ()>(())
        };
        padded.fill(0, Border::Replicate, 0, fill).unwrap();
        let mut drive = vec![0; light.len()];
        let mut parts = Parts::default();
        Weights::new(&number, &kernels).row(&number, &padded, 0, &mut drive, &mut parts);
        let exact = Exact::new(&number, &kernels).unwrap();
        let overflowed = exact.overflowed(&number, &padded, 0, &drive);
        (
            drive.iter().map(|held| number.value(*held)).collect(),
            overflowed,
        )
    }

    #[test]
    fn what_is_cut_off_and_what_comes_back_are_counted() {
        let q8_8 = Q::<i16>::new(8);
        let wrap = q8_8.with_overflow(crate::number::Overflow::Wrap);
        let light = [0.0, 0.25, 0.5, 1.0];
        let one = |weight: f64| vec![vec![vec![weight]]];
        let (drive, at) = row(q8_8, &one(127.0), &light);
        assert_eq!((drive[3], at), (127.0, Overflowed { at: 0, of: 4 }));
        // 200 is itself beyond: what is held of it makes the drive that it makes.
        assert_eq!(row(q8_8, &one(200.0), &light).1.at, 0);
        let light = [0.0, 1.0, 1.5, -2.0];
        let (drive, at) = row(q8_8, &one(100.0), &light);
        assert_eq!(
            (&drive[1..], at.at),
            (&[100.0, 127.996_093_75, -128.0][..], 2)
        );
        let (drive, at) = row(wrap, &one(100.0), &light);
        assert_eq!((&drive[1..], at.at), (&[100.0, -106.0, 56.0][..], 2));
        // A sum that is cut off and comes back lies within the ends, and is wrong.
        let back = vec![vec![vec![100.0, 100.0, -100.0]]];
        let (drive, at) = row(q8_8, &back, &[1.0; 5]);
        assert!(drive.iter().all(|drive| *drive < 28.0), "{drive:?}");
        assert_eq!(at, Overflowed { at: 5, of: 5 });
        // Two's complement comes back right.
        let (drive, at) = row(wrap, &back, &[1.0; 5]);
        assert_eq!((drive[0], at.at), (100.0, 0));
    }

    #[test]
    fn rounding_is_not_counted_and_each_kernel_of_a_pattern_has_its_columns() {
        let q8_8 = Q::<i16>::new(8);
        let thirds = vec![vec![vec![1.0 / 3.0; 25]]];
        let light: Vec<f64> = (0..40).map(|x| f64::from(x) * 0.37).collect();
        assert_eq!(row(q8_8, &thirds, &light).1.at, 0);
        let four: Vec<_> = [1.0, 100.0, 1.0, 1.0].map(|w| vec![vec![w]]).to_vec();
        let (drive, at) = row(q8_8, &four, &[3.0; 7]);
        assert_eq!((drive[0], drive[1], at.at), (3.0, 127.996_093_75, 3));
        assert!(Exact::new(&F64, &[Kernel::new(Plane::ones((1, 1))).unwrap()]).is_none());
    }

    #[test]
    fn differences_are_held_or_not() {
        let q8_8 = Q::<i16>::new(8);
        let hold = |all: [f64; 3]| all.map(|real| q8_8.hold(real));
        let (one, other) = (hold([100.0, -100.0, 3.5]), hold([-100.0, 20.0, 1.25]));
        assert_eq!(
            differences(&q8_8, &one, &other),
            Overflowed { at: 1, of: 3 }
        );
        let reals = [100.0, -100.001, 128.0];
        assert_eq!(held(&q8_8, &hold(reals), &reals).at, 1);
    }
}
