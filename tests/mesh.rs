//! The resistor sheet against what is known of it in closed form: lattice Green's functions,
//! ladders, resistances of the infinite grid, conservation and symmetry; against an elimination
//! that keeps every digit (a slow twin that subtracts nothing); and at the extremes.

#[path = "mesh/network.rs"]
mod network;
#[path = "mesh/sensor.rs"]
mod sensor;

use std::{f64::consts::PI, iter};

use amacrine::{
    mesh::{Between, Euler, Flow, MOST_LAMBDA, MeshError, Sheet, Steady},
    plane::{Plane, Size},
    rng::{GOLDEN, mix, uniform},
};
use proptest::prelude::*;

/// A picture of chance: smooth light with texture on it.
fn scene(height: usize, width: usize, seed: u64) -> Plane<f64> {
    Plane::from_shape_fn((height, width), |(y, x)| {
        let h = mix(mix(seed.wrapping_mul(GOLDEN) ^ (y as u64) << 32).wrapping_add(x as u64));
        uniform(h) + (0.1 * x as f64).sin() + y as f64 / height as f64
    })
}

fn sheet(lambda: f64) -> Sheet {
    Sheet::new(lambda).unwrap()
}

fn solve(sheet: Sheet, signal: &Plane<f64>) -> Plane<f64> {
    let mut steady = Steady::new(sheet, Size::of(signal)).unwrap();
    steady.solve(signal).unwrap()
}

fn furthest(a: &Plane<f64>, b: &Plane<f64>) -> f64 {
    assert_eq!(a.dim(), b.dim());
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max)
}

/// The least and the most.
fn ends(plane: &Plane<f64>) -> (f64, f64) {
    let none = (f64::MAX, f64::MIN);
    plane
        .iter()
        .fold(none, |(low, high), v| (low.min(*v), high.max(*v)))
}

fn point(size: (usize, usize), at: (usize, usize)) -> Plane<f64> {
    let mut plane = Plane::zeros(size);
    plane[at] = 1.0;
    plane
}

/// The slow twin: node after node is eliminated, star to mesh. Conductances between nodes and
/// to the signals only ever grow by products of others, so every digit is right whatever λ is.
fn twin(sheet: Sheet, signal: &Plane<f64>) -> Plane<f64> {
    let (height, width) = signal.dim();
    let n = height * width;
    let (down, across) = sheet.lambdas();
    let mut tie = vec![vec![0.0; n]; n];
    for i in 0..n {
        if i + width < n {
            tie[i][i + width] = down * down;
            tie[i + width][i] = down * down;
        }
        if i % width + 1 < width {
            tie[i][i + 1] = across * across;
            tie[i + 1][i] = across * across;
        }
    }
    let mut own = vec![1.0; n];
    let mut pull: Vec<f64> = signal.iter().copied().collect();
    let mut pivots = vec![0.0; n];
    for k in 0..n {
        let pivot = own[k] + tie[k][k + 1..].iter().sum::<f64>();
        pivots[k] = pivot;
        for i in k + 1..n {
            let share = tie[i][k] / pivot;
            if share == 0.0 {
                continue;
            }
            own[i] += share * own[k];
            pull[i] += share * pull[k];
            let through = tie[k].clone();
            for (j, (tie, through)) in tie[i].iter_mut().zip(through).enumerate().skip(k + 1) {
                if j != i {
                    *tie += share * through;
                }
            }
        }
    }
    let mut settled = vec![0.0; n];
    for k in (0..n).rev() {
        let others: f64 = (k + 1..n).map(|j| tie[k][j] * settled[j]).sum();
        settled[k] = (pull[k] + others) / pivots[k];
    }
    Plane::from_shape_vec((height, width), settled).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    /// Any size, any space constants, to the last digits.
    #[test]
    fn settled_is_what_elimination_gives(
        (height, width) in (1usize..13, 1usize..13),
        down in proptest::sample::select(vec![0.0, 1e-6, 0.01, 0.5, 1.0, 3.0, 10.0, 1e3, 1e4, 1e6, 1e9, 1e150]),
        across in proptest::sample::select(vec![0.0, 1e-6, 0.01, 0.5, 1.0, 3.0, 10.0, 1e3, 1e4, 1e6, 1e9, 1e150]),
        seed: u64,
    ) {
        let sheet = Sheet::anisotropic(down, across).unwrap();
        let signal = scene(height, width, seed);
        let most = signal.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let error = furthest(&solve(sheet, &signal), &twin(sheet, &signal));
        // The elimination rounds once more for every pixel.
        let bound = (1e-14 + f64::EPSILON * (height * width) as f64) * most;
        prop_assert!(error < bound, "{height}x{width}, {down}, {across}: {error}");
    }

    /// What any sheet does, whatever it is.
    #[test]
    fn laws_of_a_sheet(
        (height, width) in (1usize..40, 1usize..40),
        exponent in -3.0f64..7.0,
        seed: u64,
        shift in -1e3f64..1e3,
    ) {
        let sheet = sheet(10f64.powf(exponent));
        let (a, b) = (scene(height, width, seed), scene(height, width, !seed));
        let (ha, hb) = (solve(sheet, &a), solve(sheet, &b));
        // The mean is kept, and nothing is brighter than the brightest.
        prop_assert!((ha.sum() - a.sum()).abs() < 1e-13 * a.len() as f64);
        prop_assert!(ends(&a).0 <= ends(&ha).0 && ends(&ha).1 <= ends(&a).1);
        // Superposition; a level added is a level added.
        let both = solve(sheet, &(&a * 2.0 - &b * 0.5));
        prop_assert!(furthest(&both, &(&ha * 2.0 - &hb * 0.5)) < 1e-13);
        prop_assert!(furthest(&solve(sheet, &(&a + shift)), &(&ha + shift)) < 1e-12);
        // Reciprocity: a pulls on b as b on a.
        prop_assert!(((&a * &hb).sum() - (&b * &ha).sum()).abs() < 1e-12 * a.len() as f64);
        // Turned light, turned surround.
        let turned = |p: &Plane<f64>| { let mut t = p.t().to_owned(); t.invert_axis(ndarray::Axis(0)); t.as_standard_layout().to_owned() };
        prop_assert!(furthest(&solve(sheet, &turned(&a)), &turned(&ha)) < 1e-13);
    }

    /// Two half steps are one whole; a long time settles; a straight line is a line of steps.
    #[test]
    fn laws_of_time(
        (height, width) in (1usize..24, 1usize..24),
        exponent in -2.0f64..4.0,
        tau in proptest::sample::select(vec![0.0, 1e-6, 1e-3, 1.0]),
        seconds in proptest::sample::select(vec![1e-7, 1e-4, 1e-2, 3.0]),
        step: bool,
        seed: u64,
    ) {
        let sheet = sheet(10f64.powf(exponent));
        let (a, b) = (scene(height, width, seed), scene(height, width, !seed));
        let between = if step { Between::Step } else { Between::Ramp };
        let mut whole = Flow::settled(sheet, tau, &a).unwrap();
        prop_assert!(furthest(whole.surround(), &solve(sheet, &a)) < 1e-13);
        let mut halves = whole.clone();
        whole.advance(&b, seconds, between).unwrap();
        let middle = if step { b.clone() } else { &a * 0.25 + &b * 0.75 };
        halves.advance(&middle, 0.75 * seconds, between).unwrap();
        halves.advance(&b, 0.25 * seconds, between).unwrap();
        prop_assert!(furthest(whole.surround(), halves.surround()) < 1e-13);
        if tau > 0.0 {
            // No time, no change.
            whole.advance(&a, 0.0, between).unwrap();
            prop_assert!(furthest(whole.surround(), halves.surround()) < 1e-13);
        }
        whole.advance(&b, 1e3, between).unwrap();
        if !step { whole.advance(&b, 1e3, between).unwrap(); }
        prop_assert!(furthest(whole.surround(), &solve(sheet, &b)) < 1e-12);
    }
}

/// `R(m, n)` between nodes of the infinite grid of 1 ohm resistors (Atkinson and van Steenwijk,
/// American Journal of Physics 67:486, 1999; Cserti, 68:896, 2000). An open grid of 181x181 is
/// within 4e-4 of it around its middle.
#[test]
fn resistances_of_the_infinite_grid() {
    let known = [
        ((0, 1), 0.5),
        ((1, 1), 2.0 / PI),
        ((0, 2), 2.0 - 4.0 / PI),
        ((1, 2), 4.0 / PI - 0.5),
        ((2, 2), 8.0 / (3.0 * PI)),
        ((0, 3), 17.0 / 2.0 - 24.0 / PI),
        ((1, 3), 46.0 / (3.0 * PI) - 4.0),
        ((2, 3), 4.0 / (3.0 * PI) + 0.5),
        ((3, 3), 46.0 / (15.0 * PI)),
    ];
    // A sheet that is all but cut from its signals; λ² is 1/g in ohms.
    let lambda = 1e6;
    let error = |side: usize, (dy, dx): (usize, usize), want: f64| {
        let middle = side / 2;
        let (a, b) = ((middle, middle), (middle + dy, middle + dx));
        let mut current = point((side, side), a);
        current[b] = -1.0;
        let settled = solve(sheet(lambda), &current);
        (lambda * lambda * (settled[a] - settled[b]) - want).abs()
    };
    for (to, want) in known {
        let (small, large) = (error(61, to, want), error(181, to, want));
        assert!(large < 4e-4, "{to:?}: {large}");
        // The error falls with the square of the side.
        assert!(large < small / 7.0, "{to:?}: {small}, {large}");
    }
    assert!(error(181, (0, 1), 0.5) < 2e-5);
}

/// The screened lattice: `ε/2π ∫ exp(-|m| a) cos(n b) / sinh a db`, `cosh a = 2 + ε/2 - cos b`,
/// `ε = 1/λ²`. The integrand is periodic and smooth, so the trapezoid rule has every digit.
#[test]
fn point_spread_is_the_lattice_greens_function() {
    let integral = |lambda: f64, m: i32, n: i32| {
        let epsilon = 1.0 / (lambda * lambda);
        let steps = 4096;
        let sum: f64 = (0..steps)
            .map(|i| {
                let b = 2.0 * PI * (f64::from(i) + 0.5) / f64::from(steps);
                let a = (2.0 + epsilon / 2.0 - b.cos()).acosh();
                (-f64::from(m) * a).exp() * (f64::from(n) * b).cos() / a.sinh()
            })
            .sum();
        epsilon * sum / (2.0 * f64::from(steps))
    };
    // And as published figures: h00, h10, h11, h20.
    let figures = [
        (0.5, [0.536_591, 0.073_182_0, 0.019_275_2, 0.010_314_7]),
        (1.0, [0.254_050, 0.067_562_3, 0.032_012_4, 0.019_736_9]),
        (3.0, [0.049_507_9, 0.023_105_3, 0.016_420_1, 0.012_640_4]),
        (
            10.0,
            [0.006_415_6, 0.003_931_64, 0.003_260_62, 0.002_829_03],
        ),
    ];
    for (lambda, figures) in figures {
        let side = 801;
        let middle = side / 2;
        let spread = solve(sheet(lambda), &point((side, side), (middle, middle)));
        for ((m, n), figure) in [(0, 0), (1, 0), (1, 1), (2, 0)].into_iter().zip(figures) {
            let got = spread[[middle + m, middle + n]];
            let want = integral(lambda, m as i32, n as i32);
            assert!((got - want).abs() < 1e-14, "{lambda} {m} {n}: {got} {want}");
            assert!(
                (got / figure - 1.0).abs() < 5e-6,
                "{lambda} {m} {n}: {got} {figure}"
            );
        }
    }
}

/// A ladder: `h_n = tanh(u/2) exp(-u |n|)` with `u = 2 asinh(1 / 2λ)`, and at an open end its
/// image, as if the other side of the end were a mirror.
#[test]
fn ladder_and_its_image() {
    for lambda in [0.3, 1.0, 5.0, 20.0] {
        let u = 2.0 * (0.5f64 / lambda).asinh();
        let source = 3;
        for (size, turned) in [((1, 1200), false), ((1200, 1), true)] {
            let at = if turned { (source, 0) } else { (0, source) };
            let settled = solve(sheet(lambda), &point(size, at));
            for (n, &got) in settled.iter().enumerate().take(200) {
                let direct = (-u * (n as f64 - source as f64).abs()).exp();
                let image = (-u * (n + source + 1) as f64).exp();
                let want = (u / 2.0).tanh() * (direct + image);
                assert!(
                    (got - want).abs() < 2e-15,
                    "{size:?} {lambda} {n}: {got} {want}"
                );
            }
        }
    }
    // The ratio from node to node at λ 5, which a continuum would have at 0.8187308.
    let settled = solve(sheet(5.0), &point((1, 1001), (0, 500)));
    assert!((settled[[0, 503]] / settled[[0, 502]] - 0.819_002_5).abs() < 1e-7);
}

/// A point of light that is switched on has given `1 - exp(-t/τ)` to the sheet after `t`,
/// whatever the resistors: they only share it out.
#[test]
fn light_arrives_with_the_time_constant() {
    let dark = Plane::zeros((31, 20));
    let light = point((31, 20), (4, 17));
    for lambda in [0.1, 3.0, 1e3] {
        for time in [1e-5, 1e-3, 2e-3, 1e-2] {
            let mut flow = Flow::settled(sheet(lambda), 1e-3, &dark).unwrap();
            flow.advance(&light, time, Between::Step).unwrap();
            let want = 1.0 - (-time / 1e-3f64).exp();
            assert!((flow.surround().sum() - want).abs() < 1e-14);
            assert!(flow.surround().iter().all(|h| *h > -1e-16));
        }
    }
}

/// Many Euler steps that are small enough go where the exact solution is.
#[test]
fn small_steps_lead_to_the_exact_state() {
    let (a, b) = (scene(9, 14, 1), scene(9, 14, 2));
    let (lambda, tau, time) = (2.0, 1e-3, 7e-4);
    let run = |steps: u32| {
        let dt = time / f64::from(steps);
        let mut h = solve(sheet(lambda), &a);
        for n in 0..steps {
            let part = (f64::from(n) + 0.5) / f64::from(steps);
            let p = &a * (1.0 - part) + &b * part;
            let slope = |h: &Plane<f64>| {
                Plane::from_shape_fn((9, 14), |(y, x)| {
                    let near = |v: Option<&f64>| v.map_or(0.0, |v| v - h[[y, x]]);
                    let lap = near(h.get([y.wrapping_sub(1), x]))
                        + near(h.get([y + 1, x]))
                        + near(h.get([y, x.wrapping_sub(1)]))
                        + near(h.get([y, x + 1]));
                    (p[[y, x]] - h[[y, x]] + lambda * lambda * lap) / tau
                })
            };
            // The midpoint rule.
            let half = &h + &(slope(&h) * (dt / 2.0));
            h = &h + &(slope(&half) * dt);
        }
        h
    };
    let mut flow = Flow::settled(sheet(lambda), tau, &a).unwrap();
    flow.advance(&b, time, Between::Ramp).unwrap();
    let (coarse, fine) = (run(2000), run(4000));
    let extrapolated = &fine * (4.0 / 3.0) - &coarse * (1.0 / 3.0);
    assert!(furthest(&extrapolated, flow.surround()) < 1e-10);
}

/// Every node has the variance kT/C and knows nothing of its neighbours, at any time; in time
/// the mean of the sheet forgets with τ, a single mode with τ times its gain.
#[test]
fn noise_is_in_equilibrium() {
    let (height, width, sigma, tau) = (5, 6, 0.3, 1e-3);
    let still = Plane::from_elem((height, width), 7.0);
    for lambda in [0.5, 5.0] {
        let runs = 4000u64;
        let (mut own, mut side, mut again, mut mean) = (0.0, 0.0, 0.0, 0.0);
        for seed in 0..runs {
            let mut flow = Flow::settled(sheet(lambda), tau, &still).unwrap();
            flow = flow.with_noise(sigma, seed);
            let before = flow.surround() - 7.0;
            flow.advance(&still, tau / 2.0, Between::Ramp).unwrap();
            let now = flow.surround() - 7.0;
            own += now[[2, 3]] * now[[2, 3]];
            side += now[[2, 3]] * now[[2, 4]];
            again += now.sum() * before.sum() / (height * width) as f64;
            mean += now[[0, 0]];
        }
        let runs = runs as f64;
        let near = |got: f64, want: f64, spread: f64| {
            let bound = 4.5 * spread / runs.sqrt();
            assert!(
                (got / runs - want).abs() < bound,
                "{} {want} {bound}",
                got / runs
            );
        };
        let kt_c = sigma * sigma;
        near(own, kt_c, 2f64.sqrt() * kt_c);
        near(side, 0.0, kt_c);
        near(mean, 0.0, sigma);
        near(again, kt_c * (-0.5f64).exp(), 1.3 * kt_c);
    }
}

/// Uniform light comes back to the bit, light of 120 dB to a part in 10^15 of its brightest;
/// a mesh without laterals gives back what it got.
#[test]
fn plain_light_is_not_touched() {
    for value in [0.1, 1e6 / 3.0, -7.7e-200, 1e290] {
        for lambda in [0.0, 1e-6, 10.0, 1e6] {
            let uniform = Plane::from_elem((13, 17), value);
            assert_eq!(solve(sheet(lambda), &uniform), uniform);
        }
    }
    let signal = scene(13, 17, 3);
    assert_eq!(solve(sheet(0.0), &signal), signal);
    // The square of 1e-6 is far below the last digit of 1 + 8 λ².
    assert!(furthest(&solve(sheet(1e-6), &signal), &signal) < 1e-11);
    assert!(furthest(&solve(sheet(1e-6), &signal), &twin(sheet(1e-6), &signal)) < 1e-15);
    // Black but for one lamp a million times brighter.
    let mut lamp = scene(12, 11, 4);
    lamp[[3, 3]] = 1e6;
    for lambda in [0.1, 10.0, 1e4] {
        let error = furthest(&solve(sheet(lambda), &lamp), &twin(sheet(lambda), &lamp));
        assert!(error < 1e-15 * 1e6, "{lambda}: {error}");
    }
    // As λ grows, only the mean is left.
    let mean = signal.sum() / signal.len() as f64;
    assert!(
        furthest(
            &solve(sheet(1e9), &signal),
            &Plane::from_elem((13, 17), mean)
        ) < 1e-15
    );
}

/// Single precision is within 3e-6 of the light's range for every λ from 1e-3 to 1e6.
#[test]
fn single_precision_is_documented() {
    for (height, width) in [(256, 256), (1024, 32), (32, 1024), (97, 101)] {
        let signal = scene(height, width, 5).mapv(|v| f64::from(v as f32));
        let single = signal.mapv(|v| v as f32);
        let size = Size::of(&signal);
        let (low, high) = ends(&signal);
        for exponent in -3..=6 {
            let sheet = sheet(10f64.powi(exponent));
            let mut steady = Steady::<f32>::new(sheet, size).unwrap();
            let got = steady.solve(&single).unwrap().mapv(f64::from);
            let error = furthest(&got, &solve(sheet, &signal));
            let error = error / (high - low);
            assert!(error < 3e-6, "{size}, λ 1e{exponent}: {error}");
            let mut flow = Flow::<f32>::settled(sheet, 1e-3, &single).unwrap();
            flow.advance(&single, 1e-3, Between::Ramp).unwrap();
            let got = flow.surround().mapv(f64::from);
            let error = furthest(&got, &solve(sheet, &signal)) / (high - low);
            assert!(error < 3e-6, "{size}, λ 1e{exponent}, in time: {error}");
        }
    }
}

/// The largest sensors, lines of pixels, and sides that are prime: across and down, the two
/// ways in which the sheet is taken apart give the same.
#[test]
fn any_size() {
    let sizes = [
        (1, 1),
        (1, 2),
        (2, 1),
        (1, 4099),
        (4099, 1),
        (3, 1009),
        (1021, 7),
        (260, 346),
        (719, 1279),
        (2, 2),
    ];
    for (height, width) in sizes {
        let signal = scene(height, width, 6);
        for lambda in [0.5, 10.0, 1e4] {
            let settled = solve(sheet(lambda), &signal);
            let turned = signal.t().as_standard_layout().to_owned();
            let other = solve(sheet(lambda), &turned);
            let error = furthest(&settled, &other.t().as_standard_layout().to_owned());
            assert!(error < 1e-13, "{width}x{height}, {lambda}: {error}");
        }
    }
}

#[test]
fn four_thousand_by_four_thousand() {
    let side = 4096;
    // A wave that fits: the surround is the wave times its gain.
    let (ky, kx) = (3, 640);
    let wave = |k: usize, n: usize| (PI * k as f64 * (2 * n + 1) as f64 / (2 * side) as f64).cos();
    let down: Vec<f64> = (0..side).map(|y| wave(ky, y)).collect();
    let across: Vec<f64> = (0..side).map(|x| wave(kx, x)).collect();
    let signal = Plane::from_shape_fn((side, side), |(y, x)| down[y] * across[x]);
    let sheet = sheet(10.0);
    let cycles = |k: usize| k as f64 / (2 * side) as f64;
    let gain = sheet.gain(cycles(ky), cycles(kx));
    let settled = solve(sheet, &signal);
    assert!(furthest(&settled, &(&signal * gain)) < 1e-13);
    // And from the other side.
    let turned = signal.t().as_standard_layout().to_owned();
    assert!(furthest(&solve(sheet, &turned), &(&turned * gain)) < 1e-13);
}

#[test]
fn what_cannot_be_answered_is_refused() {
    for lambda in [-1.0, f64::NAN, f64::INFINITY, 1e151] {
        assert!(matches!(Sheet::new(lambda), Err(MeshError::Lambda { .. })));
    }
    assert!(Sheet::new(MOST_LAMBDA).is_ok() && Sheet::new(-0.0).is_ok());
    let size = Size::new(4, 5);
    assert!(matches!(
        Steady::<f32>::new(sheet(1e16), size),
        Err(MeshError::Lambda { most, .. }) if most == 1e15
    ));
    assert!(Steady::<f32>::new(sheet(1e15), size).is_ok());
    assert!(matches!(
        Steady::<f64>::new(sheet(1.0), Size::new(0, 5)),
        Err(MeshError::Empty { .. })
    ));
    let mut steady = Steady::new(sheet(1.0), size).unwrap();
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300] {
        for at in [(0, 0), (3, 4), (2, 1)] {
            let mut signal = scene(4, 5, 7);
            signal[at] = bad;
            let place = format!("x = {}, y = {} is", at.1, at.0);
            let refused = steady.solve(&signal).unwrap_err();
            assert!(refused.to_string().contains(&place), "{refused}");
            let refused = Flow::settled(sheet(1.0), 1e-3, &signal).unwrap_err();
            assert!(refused.to_string().contains(&place), "{refused}");
            let mut flow = Flow::settled(sheet(1.0), 1e-3, &scene(4, 5, 7)).unwrap();
            assert!(flow.advance(&signal, 1e-3, Between::Ramp).is_err());
        }
    }
    assert!(matches!(
        steady.solve(&scene(5, 4, 1)),
        Err(MeshError::Size { .. })
    ));
    let signal = scene(4, 5, 8);
    for time in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(
            Flow::settled(sheet(1.0), time, &signal),
            Err(MeshError::Time { .. })
        ));
        let mut flow = Flow::settled(sheet(1.0), 1e-3, &signal).unwrap();
        assert!(flow.advance(&signal, time, Between::Step).is_err());
    }
}

/// How far uniform light that begins to ramp takes the surround from the straight line between
/// two frames, over what the light changes; light that goes on as it went takes it nowhere.
#[test]
fn between_frames_the_line_is_near() {
    let flat = |level: f64| Plane::from_elem((3, 4), level);
    let off = |tau: f64, pairs: u32| {
        let mut flow = Flow::settled(sheet(3.0), tau, &flat(0.0)).unwrap();
        for n in 1..pairs {
            flow.advance(&flat(n.into()), 1.0, Between::Ramp).unwrap();
        }
        let begin = f64::from(pairs - 1);
        let before = flow.surround()[[1, 1]];
        let parts = 400;
        let curve: Vec<f64> = (1..=parts)
            .map(|i| {
                let part = f64::from(i) / f64::from(parts);
                let seconds = 1.0 / f64::from(parts);
                flow.advance(&flat(begin + part), seconds, Between::Ramp)
                    .unwrap();
                flow.surround()[[1, 1]]
            })
            .collect();
        let after = curve[curve.len() - 1];
        let line = (1..=parts).map(|i| before + (after - before) * f64::from(i) / f64::from(parts));
        iter::zip(curve, line)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max)
    };
    let first = [0.01, 0.1, 0.2, 1.0 / 2.7, 1.0, 10.0].map(|tau| off(tau, 1));
    assert!(first.iter().all(|off| *off < 0.107), "{first:?}");
    assert!(first[3] > 0.106 && first[3] >= first.into_iter().fold(0.0, f64::max));
    assert!(off(0.1, 8) < 1e-12 && off(0.0, 1) < 1e-12);
}

/// v2e's rule stops before it has arrived: what is left of a uniform step of ln 1.2 after a
/// frame, with a time constant of 0.
#[test]
fn v2e_stops_early() {
    let before = Plane::zeros((6, 7));
    let step = 1.2f64.ln();
    let after = Plane::from_elem((6, 7), step);
    for (lambda, left) in [
        (1.0, 3.8e-5),
        (3.0, 4.3e-4),
        (10.0, 5.0e-3),
        (30.0, 0.045),
        (100.0, 0.182),
    ] {
        let mut euler = Euler::begin(sheet(lambda), 0.0, &before).unwrap();
        euler.advance(&after, 1e-3).unwrap();
        let got = step - euler.surround()[[3, 3]];
        assert!(
            (got / left - 1.0).abs() < 0.2,
            "{lambda}: {got}, not {left}"
        );
    }
    // With a time constant and all its steps it comes near the exact one.
    let (a, b) = (scene(12, 12, 1), scene(12, 12, 2));
    let mut euler = Euler::begin(sheet(2.0), 1e-3, &solve(sheet(2.0), &a)).unwrap();
    euler.advance(&b, 1e-3).unwrap();
    assert_eq!(euler.steps(), 20);
    let mut flow = Flow::settled(sheet(2.0), 1e-3, &a).unwrap();
    flow.advance(&b, 1e-3, Between::Step).unwrap();
    let error = furthest(euler.surround(), flow.surround());
    assert!(error > 1e-4 && error < 0.05, "{error}");
    assert!(Euler::begin(Sheet::anisotropic(1.0, 2.0).unwrap(), 0.0, &a).is_err());
}
