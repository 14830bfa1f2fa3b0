//! Proves that every number format rounds once, to the nearest, halves to even, and that
//! overflow does as it says: against slow twins (a search through all halves by exact
//! midpoints; rationals in 128-bit integers) and against the `fixed` crate.

use amacrine::number::{Bf16, F16, Format, FormatError, Number, Overflow, Q, Visitor, Width};
use half::{bf16, f16};
use proptest::prelude::*;

/// Reals where rounding is hard: near the halves of every format, subnormal, huge, tiny.
fn reals() -> impl Strategy<Value = f64> {
    let nudge = prop::sample::select(vec![0.0, 1e-9, -1e-9, 2f64.powi(-40), -2f64.powi(-40)]);
    let halves = (-70_000i64..70_000, 0i32..34, nudge)
        .prop_map(|(n, shift, nudge)| (n as f64 + 0.5) * 2f64.powi(-shift) * (1.0 + nudge));
    prop_oneof![
        4 => halves,
        2 => (any::<u16>(), any::<bool>(), -1i32..=1).prop_map(|(bits, wide, ulps)| {
            let near = if wide { bf16::from_bits(bits).to_f64() } else { f16::from_bits(bits).to_f64() };
            let next = if wide { bf16::from_bits(bits ^ 1).to_f64() } else { f16::from_bits(bits ^ 1).to_f64() };
            let middle = near.midpoint(next);
            if middle.is_finite() && middle != 0.0 {
                f64::from_bits(middle.to_bits().wrapping_add_signed(ulps.into()))
            } else {
                0.0
            }
        }),
        1 => any::<f64>().prop_filter("a number", |x| x.is_finite()),
        1 => -300.0..300.0f64,
    ]
}

/// The nearest of all halves, by exact midpoints: slow, and obviously right.
/// `all` is sorted; beyond the midpoint of the last and the one that would follow is infinity.
fn nearest(real: f64, all: &[(f64, u16)]) -> f64 {
    let above = all.partition_point(|(value, _)| *value < real);
    if above == 0 {
        return all[0].0;
    }
    if above == all.len() {
        return all[above - 1].0;
    }
    let ((low, low_bits), (high, _)) = (all[above - 1], all[above]);
    // The step to infinity is as long as the one before it.
    let middle = if high.is_infinite() {
        low + (low - all[above - 2].0) / 2.0
    } else if low.is_infinite() {
        high - (all[above + 1].0 - high) / 2.0
    } else {
        low.midpoint(high)
    };
    // Infinity counts as even: its bits are the next number's.
    let low_even = low_bits & 1 == 0 && low.is_finite();
    match real.partial_cmp(&middle).unwrap() {
        std::cmp::Ordering::Less => low,
        std::cmp::Ordering::Greater => high,
        std::cmp::Ordering::Equal => {
            if low_even {
                low
            } else {
                high
            }
        }
    }
}

fn all_halves(value: impl Fn(u16) -> f64) -> Vec<(f64, u16)> {
    let mut all: Vec<(f64, u16)> = (0..=u16::MAX)
        .map(|bits| (value(bits), bits))
        .filter(|(value, bits)| !value.is_nan() && *bits != 0x8000)
        .collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all
}

/// `real · 2^fraction` as an exact fraction of integers, where it is not huge.
fn steps(real: f64, fraction: u8) -> Option<(i128, i128)> {
    let bits = real.to_bits();
    let exponent = ((bits >> 52) & 0x7ff) as i32;
    let mantissa = (bits & ((1 << 52) - 1)) as i128;
    let (mantissa, exponent) = if exponent == 0 {
        (mantissa, -1074)
    } else {
        (mantissa | 1 << 52, exponent - 1075)
    };
    let mantissa = if real < 0.0 { -mantissa } else { mantissa };
    match exponent + i32::from(fraction) {
        up @ 0..=70 => Some((mantissa << up, 1)),
        // Far below half a step only the sign is left, and that does not matter.
        down @ -120..0 => Some((mantissa, 1 << -down)),
        down if down < 0 => Some((0, 1)),
        _ => None,
    }
}

/// Nearest integer, halves to even, by looking at both candidates.
fn round((numerator, denominator): (i128, i128)) -> i128 {
    let low = numerator.div_euclid(denominator);
    let (below, above) = (
        numerator - low * denominator,
        (low + 1) * denominator - numerator,
    );
    if below < above || (below == above && low % 2 == 0) {
        low
    } else {
        low + 1
    }
}

fn overflow(value: i128, bits: u8, rule: Overflow) -> i64 {
    let half = 1i128 << (bits - 1);
    match rule {
        Overflow::Saturate => value.clamp(-half, half - 1) as i64,
        Overflow::Wrap => ((value + half).rem_euclid(2 * half) - half) as i64,
    }
}

fn rules() -> impl Strategy<Value = Overflow> {
    prop::sample::select(vec![Overflow::Saturate, Overflow::Wrap])
}

fn fixed_agrees<T: Width>(
    fraction: u8,
    rule: Overflow,
    a: f64,
    b: f64,
) -> Result<(), TestCaseError> {
    let q = Q::<T>::new(fraction).with_overflow(rule);
    let fraction = fraction.min(T::BITS);
    if let Some(exact) = steps(a, fraction) {
        prop_assert_eq!(q.hold(a).into(), overflow(round(exact), T::BITS, rule));
    } else if rule == Overflow::Saturate {
        prop_assert_eq!(
            q.hold(a).into(),
            overflow(
                if a > 0.0 {
                    i128::MAX / 4
                } else {
                    i128::MIN / 4
                },
                T::BITS,
                rule
            )
        );
    }
    let (a, b) = (q.hold(a), q.hold(b));
    prop_assert_eq!(q.hold(q.value(a)), a, "what is held is held");
    let (wide_a, wide_b): (i64, i64) = (a.into(), b.into());
    let (wide_a, wide_b) = (i128::from(wide_a), i128::from(wide_b));
    prop_assert_eq!(q.add(a, b).into(), overflow(wide_a + wide_b, T::BITS, rule));
    prop_assert_eq!(q.sub(a, b).into(), overflow(wide_a - wide_b, T::BITS, rule));
    prop_assert_eq!(
        q.mul(a, b).into(),
        overflow(round((wide_a * wide_b, 1 << fraction)), T::BITS, rule)
    );
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn fixed_point_agrees_with_rationals(
        fraction in 0u8..=32, rule in rules(), a in reals(), b in reals()
    ) {
        fixed_agrees::<i8>(fraction, rule, a, b)?;
        fixed_agrees::<i16>(fraction, rule, a, b)?;
        fixed_agrees::<i32>(fraction, rule, a, b)?;
    }

    #[test]
    fn fixed_point_agrees_with_the_fixed_crate(a in reals()) {
        use fixed::{FixedI8, FixedI16, FixedI32, types::extra::{U0, U7, U8, U12, U16, U24, U32}};
        macro_rules! agree {
            ($($crate_type:ident $frac:ident $width:ty, $fraction:literal;)*) => {$(
                let theirs = $crate_type::<$frac>::saturating_from_num(a).to_bits();
                prop_assert_eq!(Q::<$width>::new($fraction).hold(a), theirs);
                if a.abs() < 1e30 {
                    let theirs = $crate_type::<$frac>::wrapping_from_num(a).to_bits();
                    let ours = Q::<$width>::new($fraction).with_overflow(Overflow::Wrap);
                    prop_assert_eq!(ours.hold(a), theirs);
                }
            )*};
        }
        agree! {
            FixedI8 U0 i8, 0; FixedI8 U7 i8, 7; FixedI8 U8 i8, 8;
            FixedI16 U8 i16, 8; FixedI16 U12 i16, 12; FixedI16 U16 i16, 16;
            FixedI32 U0 i32, 0; FixedI32 U24 i32, 24; FixedI32 U32 i32, 32;
        }
    }
}

#[test]
fn halves_agree_with_a_search_through_all_of_them() {
    fn check<N: Number>(number: N, value: impl Fn(u16) -> f64) {
        let all = all_halves(value);
        let mut runner = proptest::test_runner::TestRunner::new(ProptestConfig::with_cases(20_000));
        let result = runner.run(&(reals(), reals()), |(a, b)| {
            let held = |x| number.value(number.hold(x));
            prop_assert_eq!(held(a), nearest(a, &all), "{}", a);
            let (x, y) = (number.hold(a), number.hold(b));
            let (a, b) = (number.value(x), number.value(y));
            // Products of halves are exact in f64; sums of halves that are not too far apart too.
            if (a * b).is_finite() {
                prop_assert_eq!(number.value(number.mul(x, y)), nearest(a * b, &all));
            }
            if (a + b) - a == b && (a + b) - b == a && (a + b).is_finite() {
                prop_assert_eq!(number.value(number.add(x, y)), nearest(a + b, &all));
                prop_assert_eq!(
                    number.value(number.sub(x, number.hold(-b))),
                    nearest(a + b, &all)
                );
            }
            Ok(())
        });
        result.unwrap();
    }
    check(F16, |bits| f16::from_bits(bits).to_f64());
    check(Bf16, |bits| bf16::from_bits(bits).to_f64());
}

#[test]
fn hard_cases_of_binary16() {
    let held = |x| F16.value(F16.hold(x));
    assert_eq!(held(2049.0), 2048.0, "halfway, down to even");
    assert_eq!(held(2051.0), 2052.0, "halfway, up to even");
    assert_eq!(
        held(2049.0 + 1e-9),
        2050.0,
        "just above halfway: rounding twice gets this wrong"
    );
    assert_eq!(held(65519.9), 65504.0);
    assert_eq!(held(65520.0), f64::INFINITY);
    assert_eq!(held(2f64.powi(-25)), 0.0, "half the smallest subnormal");
    assert_eq!(held(2f64.powi(-25) * (1.0 + 1e-12)), 2f64.powi(-24));
    assert_eq!(
        held(3.0 * 2f64.powi(-25)),
        2f64.powi(-23),
        "subnormal halfway, to even"
    );
}

#[test]
fn names_round_trip_and_unknown_ones_list_the_known() {
    for name in [
        "f64",
        "f32",
        "f16",
        "bf16",
        "q8.8",
        "q4.12",
        "q8.24",
        "q1.7",
        "q0.8",
        "q32.0",
        "q8.8-wrap",
    ] {
        let format: Format = name.parse().unwrap();
        assert_eq!(format.to_string(), name);
    }
    assert_eq!("exact".parse(), Ok(Format::F64));
    assert_eq!(Q::<i16>::new(12).format(), "q4.12".parse().unwrap());
    for name in [
        "", "q", "q8", "q8.", "q.8", "q+8.8", "Q8.8", "q8.8-", "f128", "q-8.16", "q300.8",
    ] {
        let error = name.parse::<Format>().unwrap_err();
        assert!(matches!(error, FormatError::Unknown { .. }), "{name}");
        let help = miette::Diagnostic::help(&error).unwrap().to_string();
        assert!(
            ["exact", "f32", "f16", "bf16", "q8.8", "wrap"]
                .iter()
                .all(|word| help.contains(word))
        );
    }
    assert!(matches!(
        "q8.9".parse::<Format>(),
        Err(FormatError::Width { bits: 17, .. })
    ));
}

/// A name that a kind of format lacks would be empty.
#[test]
fn each_kind_of_format_has_a_name() {
    let mut floats: Vec<Format> = Format::examples().collect();
    for format in &floats {
        assert_eq!(format.to_string().parse(), Ok(*format), "{format:?}");
    }
    assert!(matches!(floats.pop(), Some(Format::Fixed(_))));
    assert_eq!(floats, Format::floats().collect::<Vec<_>>());
}

/// Twice the largest number, and twice the least.
struct Twice;

impl Visitor for Twice {
    type Output = [f64; 2];

    fn visit<N: Number>(self, number: N) -> [f64; 2] {
        let (least, most) = number.format().limits();
        [least, most].map(|end| {
            let end = number.hold(end);
            number.value(number.add(end, end))
        })
    }
}

/// Where a format has ends its numbers stay within them, and become infinite elsewhere.
#[test]
fn ends_are_where_numbers_stay() {
    let fixed = ["q1.7", "q8.8-wrap", "q16.0", "q8.24", "q32.0-wrap"];
    let fixed = fixed.map(|name| name.parse().unwrap());
    for format in Format::examples().chain(fixed) {
        let [below, above] = format.visit(Twice);
        let (least, most) = format.limits();
        let Some([low, high]) = format.ends() else {
            assert_eq!(
                [below, above],
                [f64::NEG_INFINITY, f64::INFINITY],
                "{format}"
            );
            continue;
        };
        assert_eq!(
            [low, high],
            [least, most + 2.0 * format.half_step()],
            "{format}"
        );
        for value in [below, above] {
            assert!((low..high).contains(&value), "{format}: {value}");
        }
        assert_eq!(format.wraps(), above != most, "{format}");
    }
}

#[test]
fn bytes_are_those_of_the_bits() {
    for (name, bytes) in [
        ("f64", 8),
        ("f32", 4),
        ("f16", 2),
        ("bf16", 2),
        ("q1.7", 1),
        ("q8.8", 2),
        ("q8.24", 4),
    ] {
        assert_eq!(name.parse::<Format>().unwrap().bytes(), bytes, "{name}");
    }
}
