//! Formats: rounding, sums of products, cancellation, subnormals, overflow, memories that add.

use amacrine::number::{Format, Number, Overflow, Visitor};

use crate::{
    bound::{Bounds as _, gamma},
    light::{draws, exact_dot},
    page::{Table, Worst, decades},
};

const FORMATS: [&str; 11] = [
    "f64",
    "f32",
    "f16",
    "bf16",
    "q8.0",
    "q1.7",
    "q1.7-wrap",
    "q8.8",
    "q8.8-wrap",
    "q8.24",
    "q16.16-wrap",
];

pub fn table() -> Table {
    let mut table = Table::default();
    for name in FORMATS {
        let format: Format = name.parse().unwrap();
        format.visit(Rows {
            name,
            table: &mut table,
        });
    }
    table
}

/// The rows of one format.
struct Rows<'a> {
    name: &'a str,
    table: &'a mut Table,
}

impl Visitor for Rows<'_> {
    type Output = ();

    fn visit<N: Number>(self, number: N) {
        let Self { name, table } = self;
        let format = number.format();
        let what = |what: &str| format!("`{name}`: {what}");
        table.within(
            &what("a number held"),
            "1e-9 to 1e9",
            &beyond(&number),
            if format.unit_roundoff() > 0.0 {
                "u |x|, or half a subnormal"
            } else {
                "half an LSB"
            },
            held(&number),
        );
        let (kind, bound) = if format.unit_roundoff() > 0.0 {
            ("its error", "γ(n) Σ|w x| + n half steps")
        } else {
            ("sums are exact, products are rounded", "n half LSB")
        };
        let (dots, most) = dots(&number);
        table.within(
            &what("sums of 1 to 4096 products"),
            &format!("light 1e-6 to {most:.0e}"),
            kind,
            bound,
            dots,
        );
        if let Some(worst) = cancellation(&number) {
            table.within(
                &what("5x5 weights that sum to 0, ±1e-3 to ±1e4"),
                "uniform light 1e-6 to 1e9",
                "what is left of 0",
                "γ(27) Σ|w x| + 77 half steps",
                worst,
            );
        }
        if let Some(worst) = subnormals(&number) {
            table.within(
                &what("products below the smallest normal number"),
                "25 products",
                "digits go one by one",
                "n half subnormals",
                worst,
            );
        }
        if let Format::Fixed(fixed) = format {
            let (low, high) = format.limits();
            let one = number.hold(high);
            let sum = number.add(number.add(one, one), number.hold(-high));
            let (sum, wraps) = (number.value(sum), fixed.overflow() == Overflow::Wrap);
            assert_eq!(sum, if wraps { high } else { 0.0 });
            table.happens(
                &what("a sum that leaves the range on its way back into it"),
                &format!("{high} + {high} - {high}"),
                &format!("{sum}, range {low} to {high}"),
            );
        }
        adding(name, &number, table);
    }
}

/// What becomes of 1e9.
fn beyond<N: Number>(number: &N) -> String {
    let got = number.value(number.hold(1e9));
    let limits = number.format().limits();
    assert_eq!(number.format().hold_bound(1e9).is_finite(), limits.1 >= 1e9);
    if got == 1e9 {
        "1e9 is held".into()
    } else {
        format!("1e9 becomes {got}")
    }
}

fn held<N: Number>(number: &N) -> Worst {
    let mut worst = Worst::default();
    for scale in decades(-9, 9) {
        for real in draws(1, 400).into_iter().map(|d| d * scale) {
            let bound = number.format().hold_bound(real);
            if bound < f64::INFINITY {
                let error = (number.value(number.hold(real)) - real).abs();
                worst.see(error, bound, format_args!("{real:e}"));
            }
        }
    }
    worst
}

/// Weights and values as they are held, how far their sum of products is off, and the bound.
fn dot<N: Number>(number: &N, terms: &[(N::Held, N::Held)]) -> (f64, f64) {
    let mut sum = N::ZERO;
    for (weight, value) in terms {
        sum = number.add(sum, number.mul(*weight, *value));
    }
    let reals = || (terms.iter()).map(|(w, x)| (number.value(*w), number.value(*x)));
    let (exact, rest) = exact_dot(reals());
    let size: f64 = reals().map(|(w, x)| (w * x).abs()).sum();
    let error = ((number.value(sum) - exact) - rest).abs();
    (error, number.format().dot_bound(terms.len(), size))
}

/// And up to which light something can be said.
fn dots<N: Number>(number: &N) -> (Worst, f64) {
    let mut worst = Worst::default();
    let mut most = 0.0;
    for scale in decades(-6, 9) {
        for count in [1, 2, 9, 25, 121, 4096] {
            for seed in 0..12 {
                let weights = draws(seed, count);
                let light = draws(seed + 100, count);
                let terms: Vec<_> = (weights.iter().zip(&light))
                    .map(|(w, x)| (number.hold(*w), number.hold((x + 1.0) / 2.0 * scale)))
                    .collect();
                let (error, bound) = dot(number, &terms);
                if bound + number.format().hold_bound(scale) < f64::INFINITY {
                    worst.see(error, bound, format_args!("{count} terms of {scale:e}"));
                    most = scale;
                }
            }
        }
    }
    (worst, most)
}

/// A centre and its surround, which in exact numbers leave nothing of uniform light. Weights and
/// light are rounded as well: two more roundings a term, and the same in steps.
fn cancellation<N: Number>(number: &N) -> Option<Worst> {
    let format = number.format();
    if format.unit_roundoff() == 0.0 {
        return None;
    }
    let mut worst = Worst::default();
    for size in decades(-3, 4) {
        for light in decades(-6, 9).map(|light| light / 3.0) {
            let weight = |i: usize| if i == 12 { size } else { -size / 24.0 };
            let mut sum = N::ZERO;
            for i in 0..25 {
                let product = number.mul(number.hold(weight(i)), number.hold(light));
                sum = number.add(sum, product);
            }
            let all = 2.0 * size * light;
            // Where a weight or the light is itself subnormal, its own step counts.
            let steps = 25.0 * (1.0 + size.max(1.0) + light.max(1.0));
            let bound = format.dot_bound(27, all) + 1.1 * steps * format.half_step();
            if bound + format.hold_bound(light) < f64::INFINITY {
                let what = format_args!("±{size:e} under {light:e}");
                worst.see(number.value(sum).abs(), bound, what);
            }
        }
    }
    Some(worst)
}

/// Normal weights and values whose products are not: both are made of ordinary ones by a power
/// of two, so that what the sum should be is known.
fn subnormals<N: Number>(number: &N) -> Option<Worst> {
    let format = number.format();
    if format.unit_roundoff() == 0.0 {
        return None;
    }
    let smallest = 2.0 * format.half_step() * if format == Format::F64 { 0.5 } else { 1.0 };
    let normal = smallest / (2.0 * format.unit_roundoff());
    // So small that the products lie below the smallest normal number.
    let down = 2f64.powi((normal.log2() / 2.0).floor() as i32 - 2);
    let mut worst = Worst::default();
    for seed in 0..200 {
        let ordinary = |seed| {
            draws(seed, 25)
                .into_iter()
                .map(|d| f64::midpoint(d.abs(), 1.0))
        };
        let signs = draws(seed + 900, 25);
        let terms: Vec<_> = ordinary(seed)
            .zip(ordinary(seed + 500))
            .zip(signs)
            .map(|((w, x), sign)| {
                (
                    number.hold((w * down).copysign(sign)),
                    number.hold(x * down),
                )
            })
            .collect();
        let mut sum = N::ZERO;
        for (weight, value) in &terms {
            sum = number.add(sum, number.mul(*weight, *value));
        }
        let up = |held: &N::Held| number.value(*held) / down;
        let (exact, rest) = exact_dot(terms.iter().map(|(w, x)| (up(w), up(x))));
        let error = ((number.value(sum) / down / down - exact) - rest).abs();
        // The half of f64 is no double before it is scaled.
        let half = smallest / down / down / 2.0;
        worst.see(error, 25.0 * half, format_args!("seed {seed}"));
    }
    Some(worst)
}

/// A memory that adds its threshold again and again, as a chip does, and not as the reference
/// does, which counts.
fn adding<N: Number>(name: &str, number: &N, table: &mut Table) {
    let format = number.format();
    let theta = number.hold(0.2);
    let step = number.value(theta);
    let steps = 1_000_000_000u64;
    let (mut memory, mut done) = (N::ZERO, 0u64);
    let mut worst = Worst::default();
    let mut stops = None;
    while done < steps {
        let next = number.add(memory, theta);
        if next == memory {
            stops = Some(done);
            break;
        }
        // It has come round.
        if number.value(next) < number.value(memory) {
            break;
        }
        (memory, done) = (next, done + 1);
        if done.is_power_of_two() {
            let exact = done as f64 * step;
            let bound = gamma(done as usize, format.unit_roundoff()) * exact;
            if bound < f64::INFINITY {
                let error = (done as f64).mul_add(-step, number.value(memory)).abs();
                worst.see(error, bound, format_args!("{done} steps"));
            }
        }
    }
    let value = number.value(memory);
    let happens = match stops {
        _ if step == 0.0 => "0.2 is held as 0: the memory never moves".to_owned(),
        Some(after) => format!("it stops at {value} after {after} steps"),
        None if done == steps => {
            let off = (steps as f64).mul_add(-step, value).abs() / step;
            format!("it is off by {off:.0} steps in the end")
        }
        None => format!(
            "after {value} comes {}",
            number.value(number.add(memory, theta))
        ),
    };
    let what = format!("`{name}`: adding 0.2 again and again");
    let bound = if format.unit_roundoff() > 0.0 {
        "γ(n) n θ, while n u < 1"
    } else {
        "exact before that"
    };
    if worst.cases() == 0 {
        table.happens(&what, "1e9 steps", &happens);
    } else {
        table.within(&what, "1e9 steps", &happens, bound, worst);
    }
}
