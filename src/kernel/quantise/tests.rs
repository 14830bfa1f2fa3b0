use super::*;
use crate::{kernel::Kernel, number::signed_digits};
use proptest::prelude::*;

fn kernel(weights: &[f64]) -> Kernel {
    let rows: Vec<Vec<f64>> = weights.chunks(3).map(<[f64]>::to_vec).collect();
    Kernel::from_rows(&rows).unwrap()
}

fn kernels() -> impl Strategy<Value = Kernel> {
    let weight = prop_oneof![4 => -2.0..2.0f64, 1 => Just(0.0), 1 => Just(1.0)];
    proptest::collection::vec(weight, 9)
        .prop_filter("all 0", |weights| weights.iter().any(|w| *w != 0.0))
        .prop_map(|weights| kernel(&weights))
}

/// The slow twin: every choice of levels, each with its own best scale.
fn least_error(kernel: &Kernel, all: &[f64], sum: Option<f64>) -> f64 {
    let weights: Vec<f64> = kernel.weights().iter().copied().collect();
    let own: f64 = weights.iter().map(|w| w * w).sum();
    let mut gain: f64 = 0.0;
    let choices = all.len().pow(weights.len() as u32);
    for choice in 0..choices {
        let (mut rest, mut both, mut square, mut total) = (choice, 0.0, 0.0, 0.0);
        for w in &weights {
            let level = all[rest % all.len()];
            rest /= all.len();
            both += w * level;
            square += level * level;
            total += level;
        }
        if both > 0.0 && sum.is_none_or(|sum| sum == total) {
            gain = gain.max(both * both / square);
        }
    }
    ((own - gain).max(0.0) / own).sqrt()
}

fn error(name: &str, kernel: &Kernel, sum: Sum) -> f64 {
    let quantiser: Quantiser = name.parse().unwrap();
    quantiser
        .quantise(kernel, sum, 0)
        .unwrap()
        .relative_error(kernel)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn binary_and_ternary_are_the_best_there_are(kernel in kernels()) {
        prop_assert!((error("binary", &kernel, Sum::Free) - least_error(&kernel, &[-1.0, 1.0], None)).abs() < 1e-9);
        prop_assert!((error("ternary", &kernel, Sum::Free) - least_error(&kernel, &[-1.0, 0.0, 1.0], None)).abs() < 1e-9);
    }

    #[test]
    fn balanced_ternary_is_the_best_of_the_balanced(kernel in kernels()) {
        let weights = kernel.weights();
        prop_assume!(weights.iter().any(|w| *w != weights[[0, 0]]));
        let best = Quantiser::TERNARY.quantise(&kernel, Sum::Zero, 0).unwrap();
        prop_assert_eq!(best.levels.sum(), 0.0);
        let least = least_error(&kernel, &[-1.0, 0.0, 1.0], Some(0.0));
        prop_assert!((best.relative_error(&kernel) - least).abs() < 1e-9);
    }
}

proptest! {
    #[test]
    fn powers_of_two_are_the_best_there_are(weights in proptest::collection::vec(-2.0..2.0f64, 3)) {
        let kernel = kernel(&weights);
        let all = [-4.0, -2.0, -1.0, 0.0, 1.0, 2.0, 4.0];
        prop_assert!((error("po2-3", &kernel, Sum::Free) - least_error(&kernel, &all, None)).abs() < 1e-9);
        let all = [-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0];
        prop_assert!((error("int-3", &kernel, Sum::Free) - least_error(&kernel, &all, None)).abs() < 1e-9);
    }

    /// The closed forms of what is left: binary keeps `(sum |w|)² / n` of `sum w²`; the best
    /// ternary kernel is no worse than the common rule, and two scales no worse than one.
    #[test]
    fn errors_are_in_their_order(kernel in kernels()) {
        let weights = kernel.weights();
        let own: f64 = weights.iter().map(|w| w * w).sum();
        let sum: f64 = weights.iter().map(|w| w.abs()).sum();
        let left = (1.0 - sum * sum / (9.0 * own)).max(0.0).sqrt();
        prop_assert!((error("binary", &kernel, Sum::Free) - left).abs() < 1e-7);
        let ternary = error("ternary", &kernel, Sum::Free);
        prop_assert!(ternary <= error("binary", &kernel, Sum::Free) + 1e-9);
        prop_assert!(ternary <= error("ternary-0.7", &kernel, Sum::Free) + 1e-9);
        prop_assert!(error("ternary-split", &kernel, Sum::Free) <= ternary + 1e-9);
        prop_assert!(error("po2-3", &kernel, Sum::Free) <= ternary + 1e-9);
        prop_assert!(error("int-4", &kernel, Sum::Free) <= error("int-3", &kernel, Sum::Free) + 1e-9);
    }

    /// Half a step, one step, one step; unless the format is full.
    #[test]
    fn fixed_point_is_within_a_step(kernel in kernels(), fraction in 0u32..12, seed: u64) {
        let step = 2f64.powi(-(fraction as i32));
        for (rounding, bound, low) in [("", 0.5, -0.5), (":floor", 1.0, 0.0), (":stochastic", 1.0, -1.0)] {
            let quantiser: Quantiser = format!("q4.{fraction}{rounding}").parse().unwrap();
            let Ok(quantised) = quantiser.quantise(&kernel, Sum::Free, seed) else { continue };
            prop_assert_eq!(quantised.scale, 1.0);
            for (w, l) in kernel.weights().iter().zip(quantised.levels.weights()) {
                prop_assert!(((w - l) / step) <= bound && ((w - l) / step) >= low);
                prop_assert_eq!((l / step).fract(), 0.0);
            }
        }
    }

    /// The slow twin: every choice of levels that has the sum.
    #[test]
    fn levels_with_a_sum_are_the_nearest(values in proptest::collection::vec(-5.0..5.0f64, 4), sum in -8i64..8) {
        let all = [-4, -2, -1, 0, 1, 2, 4];
        let far = |levels: &[f64]| -> f64 { levels.iter().zip(&values).map(|(l, v)| (l - v).powi(2)).sum() };
        let mut least = f64::INFINITY;
        for choice in 0..7usize.pow(4) {
            let levels: Vec<f64> = (0..4).map(|i| all[choice / 7usize.pow(i) % 7] as f64).collect();
            if levels.iter().sum::<f64>() == sum as f64 {
                least = least.min(far(&levels));
            }
        }
        let fast = total::nearest(&values, &all, sum).unwrap();
        prop_assert_eq!(fast.iter().sum::<f64>(), sum as f64);
        prop_assert!((far(&fast) - least).abs() < 1e-9);
        // Without gaps, by steps.
        let every: Vec<i64> = (-4..=4).collect();
        let slow = total::nearest(&values, &every, sum).unwrap();
        let mut steps: Vec<f64> = values.iter().map(|v| v.round().clamp(-4.0, 4.0)).collect();
        total::settle(&values, &mut steps, (-4.0, 4.0), sum as f64).unwrap();
        prop_assert!((far(&steps) - far(&slow)).abs() < 1e-9);
    }

    #[test]
    fn sums_are_kept(kernel in kernels()) {
        let weights = kernel.weights();
        prop_assume!(weights.iter().any(|w| *w != weights[[0, 0]]));
        for name in ["ternary", "ternary-0.7", "po2-3", "int-5", "csd-40", "q4.6"] {
            let quantiser: Quantiser = name.parse().unwrap();
            if let Ok(zero) = quantiser.quantise(&kernel, Sum::Zero, 0) {
                prop_assert_eq!(zero.levels.sum(), 0.0, "{}", name);
            }
            if let Ok(kept) = quantiser.quantise(&kernel, Sum::Kept, 0) {
                let step = if name == "q4.6" { 1.0 / 64.0 } else { 1.0 };
                let off = kept.levels.sum() - kernel.sum() / kept.scale;
                prop_assert!(off.abs() <= 0.5 * step + 1e-9, "{}: {}", name, off);
            }
        }
    }

    /// More digits are never worse, and the budget is kept.
    #[test]
    fn digits_are_within_the_budget(kernel in kernels(), budget in 1u32..40) {
        let quantise = |budget| format!("csd-{budget}").parse::<Quantiser>().unwrap().quantise(&kernel, Sum::Free, 0);
        let Ok(quantised) = quantise(budget) else { return Ok(()) };
        let used: u32 = quantised.levels.weights().iter().map(|l| signed_digits(*l as i64)).sum();
        prop_assert!(used <= budget);
        let more = quantise(budget + 1).unwrap();
        prop_assert!(more.relative_error(&kernel) <= quantised.relative_error(&kernel) + 1e-12);
        // Half a step of the finest level each, once the budget is ample.
        let ample = quantise(100).unwrap();
        for (w, l) in kernel.weights().iter().zip(ample.levels.weights()) {
            prop_assert!((w / ample.scale - l).abs() <= 0.5 + 1e-9);
        }
    }
}

/// A factor that all levels share would only take words and range.
#[test]
fn levels_have_no_common_factor() {
    let sobel = [-1.0, 0.0, 1.0, -2.0, 0.0, 2.0, -1.0, 0.0, 1.0];
    let shown: Vec<f64> = sobel.iter().map(|w| 0.1 * w).collect();
    for (name, sum) in [
        ("int-5", Sum::Free),
        ("int-5", Sum::Zero),
        ("int-4", Sum::Kept),
        ("po2-4", Sum::Free),
    ] {
        let quantiser: Quantiser = name.parse().unwrap();
        let quantised = quantiser.quantise(&kernel(&shown), sum, 0).unwrap();
        let levels: Vec<f64> = quantised.levels.weights().iter().copied().collect();
        assert_eq!(levels, sobel, "{name} {sum:?}");
        assert!((quantised.scale - 0.1).abs() < 1e-15);
    }
}

#[test]
fn levels_within_one_are_the_same_kernel() {
    let kernel = kernel(&[0.3, -2.0, 1.1, 0.0, 7.5, -0.2, 1.0, 1.0, -3.0]);
    for to in ["ternary", "int-5", "po2-3", "q4.3"] {
        let quantised = to.parse::<Quantiser>().unwrap();
        let quantised = quantised.quantise(&kernel, Sum::Free, 0).unwrap();
        let within = quantised.clone().within_one();
        assert_eq!(within.kernel(), quantised.kernel());
        let largest = within
            .levels
            .weights()
            .iter()
            .fold(0.0, |m: f64, l| m.max(l.abs()));
        assert!(largest > 0.5 && largest <= 1.0, "{to}: {largest}");
    }
}

const SEEDS: u64 = 20_000;

/// Within 4 sigma of the weight itself.
#[test]
fn stochastic_rounding_has_the_right_mean() {
    let quantiser: Quantiser = "q4.2:stochastic".parse().unwrap();
    let weights = [0.1, -0.3, 0.74, 1.0, -1.24, 0.02, 0.5, 0.6, -0.9];
    let kernel = kernel(&weights);
    let mut sums = [0.0; 9];
    for seed in 0..SEEDS {
        let quantised = quantiser.quantise(&kernel, Sum::Free, seed).unwrap();
        for (sum, level) in sums.iter_mut().zip(quantised.levels.weights()) {
            *sum += level;
        }
    }
    for (w, sum) in weights.iter().zip(sums) {
        let part = (w * 4.0) - (w * 4.0).floor();
        let sigma = 0.25 * (part * (1.0 - part) / SEEDS as f64).sqrt();
        let mean = sum / SEEDS as f64;
        assert!(
            (mean - w).abs() <= 4.0 * sigma + 1e-12,
            "{mean}, not {w}, seeds 0 to {SEEDS}"
        );
    }
}

#[test]
fn names_are_read_as_they_are_written() {
    for name in [
        "binary",
        "ternary",
        "ternary-0.7",
        "ternary-split",
        "po2-3",
        "int-5",
        "csd-40",
        "q3.4",
        "q3.4:floor",
        "q1.0:stochastic",
    ] {
        assert_eq!(name.parse::<Quantiser>().unwrap().to_string(), name);
    }
    for (name, said) in [
        ("tertiary", "`tertiary` is no quantiser"),
        ("po2-0", "`po2-0` is no quantiser: 0 is not within 1 to 8"),
        ("int-x", "`int-x` is no quantiser: `x` is no whole number"),
        (
            "q34",
            "`q34` is no quantiser: a Q format is written as q3.4",
        ),
        ("q3.4:up", "`q3.4:up` is no quantiser: `up` is no rounding"),
    ] {
        assert_eq!(name.parse::<Quantiser>().unwrap_err().to_string(), said);
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let dark = kernel(&[0.0; 9]);
    assert_eq!(
        Quantiser::TERNARY.quantise(&dark, Sum::Free, 0),
        Err(QuantiseError::Nothing)
    );
    let bright = kernel(&[0.1; 9]);
    let odd = Quantiser::BINARY
        .quantise(&bright, Sum::Zero, 0)
        .unwrap_err();
    assert_eq!(
        odd.to_string(),
        "no choice of levels of binary sums to 0 over 9 weights"
    );
    let coarse: Quantiser = "q4.0".parse().unwrap();
    assert!(matches!(
        coarse.quantise(&bright, Sum::Free, 0),
        Err(QuantiseError::Vanished { .. })
    ));
    assert!(
        Quantiser::TERNARY_SPLIT
            .quantise(&bright, Sum::Zero, 0)
            .is_err()
    );
}

/// A kernel without a sum has the same levels in f32, whose sum is rounding, and with a sum that is
/// small beside a level.
#[test]
fn a_sum_that_no_level_can_have_costs_nothing() {
    let gauss = |y: i32, x: i32, sigma: f64| {
        let square = f64::from(y * y + x * x);
        (-square / (2.0 * sigma * sigma)).exp() / (sigma * sigma)
    };
    let places = || (-3..=3).flat_map(|y| (-3..=3).map(move |x| (y, x)));
    let mut weights: Vec<f64> = places()
        .map(|(y, x)| gauss(y, x, 1.0) - gauss(y, x, 2.0))
        .collect();
    let mean = weights.iter().sum::<f64>() / 49.0;
    for weight in &mut weights {
        *weight = 0.37 * (*weight - mean);
    }
    let levels = |quantiser: &str, weights: &[f64]| {
        let kernel = Kernel::from_rows(&weights.chunks(7).map(Vec::from).collect::<Vec<_>>());
        let quantiser: Quantiser = quantiser.parse().unwrap();
        let found = quantiser.quantise(&kernel.unwrap(), Sum::Kept, 0);
        found.unwrap().levels
    };
    let narrow: Vec<f64> = weights.iter().map(|w| f64::from(*w as f32)).collect();
    assert_ne!(narrow.iter().sum::<f64>(), 0.0);
    let uneven: Vec<f64> = weights.iter().map(|weight| weight + 1e-5).collect();
    for quantiser in ["ternary", "int-3", "int-5", "po2-3"] {
        let whole = levels(quantiser, &weights);
        assert_eq!(levels(quantiser, &narrow), whole, "{quantiser}");
        assert_eq!(levels(quantiser, &uneven), whole, "{quantiser}");
    }
}

/// Where no levels have the kernel's sum, the nearest that they can have is kept.
#[test]
fn a_sum_is_kept_as_near_as_the_levels_allow() {
    let levels = |to: &str, weights: &[f64]| {
        let quantiser: Quantiser = to.parse().unwrap();
        let found = quantiser.quantise(&kernel(weights), Sum::Kept, 0).unwrap();
        let weights = found.kernel();
        weights.weights().iter().sum::<f64>()
    };
    // The largest number of q1.2 is 3/4.
    assert_eq!(levels("q1.2", &[1.0]), 0.75);
    // As far as a format reaches, however fine it is; not for weights that are all beyond it.
    for (to, sum) in [("q3.0", 27.0), ("q3.4", 35.4375), ("q3.8", 35.964_843_75)] {
        assert_eq!(levels(to, &[5.0; 9]), sum, "{to}");
    }
    let far: Quantiser = "q3.4".parse().unwrap();
    let told = far.quantise(&kernel(&[9.0; 9]), Sum::Kept, 0).unwrap_err();
    let told = told.to_string();
    assert!(
        told.ends_with("of q3.4 sums to 81 over 9 weights"),
        "{told}"
    );
    let digits: Quantiser = "csd-3".parse().unwrap();
    let told = digits
        .quantise(&kernel(&[3.0; 9]), Sum::Kept, 0)
        .unwrap_err();
    let told = told.to_string();
    assert!(
        told.ends_with("of csd-3 sums to 27 over 9 weights"),
        "{told}"
    );
    // Nine weights of one size have no even sum.
    let even = [1.0, -1.0, 1.0, -1.0, 0.2, 1.0, -1.0, 1.0, -1.0];
    let sum = levels("binary", &even);
    assert!(sum.abs() > 0.5 && sum.abs() < 1.0, "{sum}");
    // Of -1 and 1 the one on the side of the sum, -0.2 of them, which is rounded to 0.
    let below = [0.5, -0.5, 1.5, -1.5, 2.5, -2.5, 0.25, 0.75, -1.25];
    let sum = levels("binary", &below);
    assert!((-1.5..-1.0).contains(&sum), "{sum}");
}

/// A rule for each weight is not undone for the sum.
#[test]
fn a_rounding_is_what_it_says() {
    let weights = [0.4, -0.7, 0.2, 1.1, -1.9, 0.6, 0.3, -0.1, 0.45];
    let steps = |to: &str, sum| {
        let quantiser: Quantiser = to.parse().unwrap();
        quantiser.quantise(&kernel(&weights), sum, 7)
    };
    let floors = weights.map(|w: f64| (w * 4.0).floor() / 4.0);
    let found = steps("q3.2:floor", Sum::Kept).unwrap();
    assert_eq!(found.kernel().weights().as_slice().unwrap(), floors);
    for to in ["q3.2:floor", "q3.2:stochastic"] {
        assert_eq!(steps(to, Sum::Kept), steps(to, Sum::Free));
        let told = steps(to, Sum::Zero).unwrap_err().to_string();
        assert!(told.contains("rounds each weight by itself"), "{told}");
    }
    assert_ne!(steps("q3.2", Sum::Kept), steps("q3.2:floor", Sum::Kept));
}

/// Parseval: the change of the response over all frequencies is the error of the weights.
#[test]
fn the_response_changes_by_the_error() {
    let kernel = Kernel::builtin("rgc-5x5").unwrap();
    let quantised = Quantiser::TERNARY.quantise(&kernel, Sum::Zero, 0).unwrap();
    let change = Change::between(&kernel, &quantised.kernel());
    assert!((change.rms - quantised.relative_error(&kernel)).abs() < 1e-9);
    assert!(change.largest > 0.0 && change.uniform.1.abs() < 1e-12);
    let same = Change::between(&kernel, &kernel);
    assert_eq!((same.largest, same.rms), (0.0, 0.0));
}
