//! How far rounding can take a result, whatever the numbers: bounds, not estimates.
//!
//! With `u` the unit roundoff of a format and `gamma(n) = n u / (1 - n u)`, a dot product of `n`
//! held weights and held values, each operation rounded once and in any order, is off by at most
//!
//! ```text
//! gamma(n) sum |w x|  +  n s          floats; s is half the smallest step there is
//!                        n s          fixed point, whose sums are exact; s is half an LSB
//! ```
//!
//! as long as nothing overflows (Higham, *Accuracy and Stability of Numerical Algorithms*, 2nd
//! edition, SIAM 2002, sections 2.2 and 3.1; the second term is what underflow costs).
//! `docs/extremes.md` shows how much of these bounds is used.

use amacrine::number::{Format, Number, Visitor};
use proptest::prelude::*;

/// `n u / (1 - n u)`: what `n` roundings can do to a number, as a part of it; infinite where
/// nothing can be said.
pub fn gamma(n: usize, unit_roundoff: f64) -> f64 {
    let all = n as f64 * unit_roundoff;
    if all < 1.0 {
        all / (1.0 - all)
    } else {
        f64::INFINITY
    }
}

/// The bounds of a format.
pub trait Bounds {
    /// What rounding to the nearest can change a number by, as a part of it, where neither
    /// overflow nor underflow plays a part: half the distance from 1 to the next. 0 in fixed
    /// point, where [`Format::half_step`] says it all.
    fn unit_roundoff(self) -> f64;

    /// By how much holding `real` can change it.
    ///
    /// Infinite beyond [`Format::limits`].
    fn hold_bound(self, real: f64) -> f64;

    /// By how much a dot product of `terms` held weights and held values can be off, where the
    /// products are `size` together, each without its sign.
    ///
    /// Infinite where a sum on the way can leave the format, and where there are so many terms
    /// that nothing can be said. The rounding of weights and values themselves is not in it:
    /// for floats count two terms more.
    fn dot_bound(self, terms: usize, size: f64) -> f64;
}

impl Bounds for Format {
    fn unit_roundoff(self) -> f64 {
        match self {
            Self::F64 => f64::EPSILON / 2.0,
            Self::F32 => f64::from(f32::EPSILON) / 2.0,
            Self::F16 => half::f16::EPSILON.to_f64() / 2.0,
            Self::Bf16 => half::bf16::EPSILON.to_f64() / 2.0,
            Self::Fixed(_) => 0.0,
        }
    }

    fn hold_bound(self, real: f64) -> f64 {
        let (low, high) = self.limits();
        if real >= low && real <= high {
            (self.unit_roundoff() * real.abs()).max(self.half_step())
        } else {
            f64::INFINITY
        }
    }

    fn dot_bound(self, terms: usize, size: f64) -> f64 {
        let relative = gamma(terms, self.unit_roundoff());
        // What underflow took from a product is rounded with the sums.
        let lost = terms as f64 * self.half_step() * (1.0 + relative);
        let bound = relative * size + lost;
        let (low, high) = self.limits();
        if size + bound <= high.min(-low) {
            bound
        } else {
            f64::INFINITY
        }
    }
}

const ALL: [&str; 9] = [
    "f64",
    "f32",
    "f16",
    "bf16",
    "q1.7",
    "q8.0",
    "q8.8",
    "q4.12-wrap",
    "q8.24",
];

fn format(name: &str) -> Format {
    name.parse().unwrap()
}

/// A number in one format, as a double.
struct Held(f64);

impl Visitor for Held {
    type Output = f64;
    fn visit<N: Number>(self, number: N) -> f64 {
        number.value(number.hold(self.0))
    }
}

#[test]
fn roundoff_is_half_the_distance_from_one_to_the_next() {
    for name in ["f64", "f32", "f16", "bf16"] {
        let u = format(name).unit_roundoff();
        // To even at the middle, up beyond it.
        assert_eq!(format(name).visit(Held(1.0 + u)), 1.0, "{name}");
        assert_eq!(format(name).visit(Held(1.0 - u)), 1.0 - u, "{name}");
        if name != "f64" {
            let up = format(name).visit(Held(1.0 + 1.01 * u));
            assert_eq!(up, 1.0 + 2.0 * u, "{name}");
        }
    }
}

#[test]
fn limits_are_held_and_no_step_is_smaller() {
    for name in ALL {
        let format = format(name);
        let (low, high) = format.limits();
        let step = format.half_step();
        for end in [low, high] {
            assert_eq!(format.visit(Held(end)), end, "{name}");
        }
        if name != "f64" {
            assert_eq!(format.visit(Held(2.0 * step)), 2.0 * step, "{name}");
            assert_eq!(format.visit(Held(0.99 * step)), 0.0, "{name}");
            assert_eq!(format.visit(Held(1.01 * step)), 2.0 * step, "{name}");
        }
    }
    assert_eq!(format("q8.8").limits(), (-128.0, 127.996_093_75));
    assert!(format("q4.12-wrap").wraps() && !format("q4.12").wraps());
}

#[test]
fn nothing_is_said_beyond_the_limits() {
    for name in ALL {
        let (_, high) = format(name).limits();
        assert_eq!(format(name).hold_bound(high * 1.01), f64::INFINITY);
    }
}

#[test]
fn figures_of_the_literature() {
    let of = |name, n| gamma(n, format(name).unit_roundoff());
    for (name, bound) in [("f32", 1.49e-6), ("f16", 0.01236), ("bf16", 0.1082)] {
        assert!((of(name, 25) / bound - 1.0).abs() < 1e-2, "{name}");
    }
    assert_eq!(of("bf16", 256), f64::INFINITY);
    assert_eq!(format("q8.8").dot_bound(25, 100.0), 25.0 / 512.0);
    assert_eq!(format("q8.8").dot_bound(25, 128.0), f64::INFINITY);
    assert_eq!(format("f16").dot_bound(2, 65_504.0), f64::INFINITY);
}

/// A dot product in one format, and how far off it is.
struct Dot<'a>(&'a [(f64, f64)]);

impl Visitor for Dot<'_> {
    type Output = (f64, f64);
    fn visit<N: Number>(self, number: N) -> (f64, f64) {
        let (mut sum, mut exact, mut size) = (N::ZERO, 0.0, 0.0);
        for (weight, value) in self.0 {
            let (weight, value) = (number.hold(*weight), number.hold(*value));
            sum = number.add(sum, number.mul(weight, value));
            let product = number.value(weight) * number.value(value);
            (exact, size) = (exact + product, size + product.abs());
        }
        let bound = number.format().dot_bound(self.0.len(), size);
        ((number.value(sum) - exact).abs(), bound)
    }
}

proptest! {
    /// Not for f64, against which the others are measured.
    #[test]
    fn no_dot_product_is_off_by_more(
        name in proptest::sample::select(&ALL[1..]),
        terms in proptest::collection::vec((-2.0f64..2.0, -3.0f64..3.0), 0..60),
        scale in -9i32..4,
    ) {
        let scale = 10f64.powi(scale);
        let terms: Vec<_> = terms.into_iter().map(|(w, x)| (w, x * scale)).collect();
        let (error, bound) = format(name).visit(Dot(&terms));
        // The doubles of the exact sum are themselves a hair off.
        prop_assert!(error <= bound * (1.0 + 1e-6) + 1e-18, "{name}: {error} {bound}");
    }
}
