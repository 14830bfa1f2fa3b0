//! Sheets whose parts differ, against a direct solver and against what is known of them.

use super::{furthest, scene, sheet, solve};
use amacrine::{
    mesh::{Between, Flow, Laterals, MeshError, Mismatch, Network, Sheet},
    plane::{Plane, Size},
};
use proptest::prelude::*;

fn chip(sheet: Sheet, size: (usize, usize), sigma: f64, seed: u64) -> Network {
    let mismatch = Mismatch {
        lateral: sigma,
        transverse: sigma,
        capacitance: sigma,
    };
    let network = Network::uniform(sheet, Size::new(size.0, size.1)).unwrap();
    network.with_mismatch(mismatch, seed)
}

/// The slow twin: a banded Cholesky factorisation of the conductances.
fn direct(network: &Network, signal: &Plane<f64>) -> Plane<f64> {
    let (height, width) = signal.dim();
    let n = height * width;
    let own = network.transverse();
    let (down, across) = network.lateral();
    // Row i of the band: entries (i, i - width ..= i).
    let mut band = vec![vec![0.0; width + 1]; n];
    let mut x: Vec<f64> = signal.iter().zip(&own).map(|(p, g)| p * g).collect();
    for (i, ((at, g), (d, a))) in own.indexed_iter().zip(down.iter().zip(&across)).enumerate() {
        band[i][width] += g;
        if at.0 + 1 < height {
            band[i][width] += d;
            band[i + width][width] += d;
            band[i + width][0] -= d;
        }
        if at.1 + 1 < width {
            band[i][width] += a;
            band[i + 1][width] += a;
            band[i + 1][width - 1] -= a;
        }
    }
    for i in 0..n {
        for j in i.saturating_sub(width)..=i {
            let mut sum = band[i][j + width - i];
            for k in i.saturating_sub(width)..j {
                if k + width >= j {
                    sum -= band[i][k + width - i] * band[j][k + width - j];
                }
            }
            band[i][j + width - i] = if i == j {
                sum.sqrt()
            } else {
                sum / band[j][width]
            };
        }
    }
    for i in 0..n {
        for k in i.saturating_sub(width)..i {
            x[i] -= band[i][k + width - i] * x[k];
        }
        x[i] /= band[i][width];
    }
    for i in (0..n).rev() {
        x[i] /= band[i][width];
        for k in i.saturating_sub(width)..i {
            x[k] -= band[i][k + width - i] * x[i];
        }
    }
    Plane::from_shape_vec((height, width), x).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]
    #[test]
    fn settled_is_what_the_direct_solver_gives(
        size in (1usize..20, 1usize..20),
        down in proptest::sample::select(vec![0.0, 0.1, 1.0, 10.0, 100.0]),
        across in proptest::sample::select(vec![0.0, 0.1, 1.0, 10.0, 100.0]),
        sigma in proptest::sample::select(vec![0.0, 0.01, 0.2, 1.0]),
        seed: u64,
    ) {
        let sheet = Sheet::anisotropic(down, across).unwrap();
        let network = chip(sheet, size, sigma, seed);
        let signal = scene(size.0, size.1, seed);
        let settled = network.settle(&signal).unwrap();
        let error = furthest(&settled.surround, &direct(&network, &signal));
        // Gershgorin's circles, from the parts as they are.
        let most = |plane: &Plane<f64>| plane.iter().copied().fold(0.0, f64::max);
        let (own, (down, across)) = (network.transverse(), network.lateral());
        let least = own.iter().copied().fold(f64::INFINITY, f64::min);
        let condition = (most(&own) + 4.0 * (most(&down) + most(&across))) / least;
        prop_assert!(error < 1e-15 * (20.0 + condition), "{error:e} {settled:?}");
        prop_assert!(settled.error < 1e-12);
    }

    /// Equal parts: the sheet itself, in space and time.
    #[test]
    fn equal_parts_are_the_sheet(
        size in (1usize..16, 1usize..16),
        lambda in proptest::sample::select(vec![0.0, 0.3, 3.0, 30.0, 1e4]),
        time in proptest::sample::select(vec![1e-3, 0.1, 1.0, 30.0]),
        seed: u64,
    ) {
        let network = chip(sheet(lambda), size, 0.0, 0);
        let (a, b) = (scene(size.0, size.1, seed), scene(size.0, size.1, !seed));
        let settled = network.settle(&a).unwrap().surround;
        prop_assert!(furthest(&settled, &solve(sheet(lambda), &a)) < 1e-13);
        if lambda < 100.0 {
            let mut flow = Flow::settled(sheet(lambda), 1.0, &a).unwrap();
            flow.advance(&b, time, Between::Ramp).unwrap();
            let moved = network.advance(&settled, (&a, &b), time).unwrap();
            prop_assert!(furthest(&moved, flow.surround()) < 2e-12 / time.min(1.0));
        }
    }
}

/// The number of steps depends on the spread, not on size or space constant.
#[test]
fn steps_do_not_grow() {
    for lambda in [0.1, 3.0, 100.0, 1e4] {
        for side in [16, 128] {
            let network = chip(sheet(lambda), (side, side), 0.2, 4);
            let settled = network.settle(&scene(side, side, 1)).unwrap();
            assert!(
                settled.iterations < 150,
                "{lambda} {side}: {}",
                settled.iterations
            );
            assert!(settled.error < 1e-12, "{lambda} {side}: {}", settled.error);
        }
    }
}

/// Two half steps are one whole, with parts that differ; a long time settles.
#[test]
fn networks_move() {
    let network = chip(sheet(3.0), (9, 12), 0.3, 7);
    let (a, b) = (scene(9, 12, 1), scene(9, 12, 2));
    let start = network.settle(&a).unwrap().surround;
    let whole = network.advance(&start, (&a, &b), 0.7).unwrap();
    let middle = &a * 0.5 + &b * 0.5;
    let half = network.advance(&start, (&a, &middle), 0.35).unwrap();
    let halves = network.advance(&half, (&middle, &b), 0.35).unwrap();
    assert!(furthest(&whole, &halves) < 1e-12);
    let end = network.advance(&whole, (&b, &b), 1e4).unwrap();
    assert!(furthest(&end, &network.settle(&b).unwrap().surround) < 1e-12);
    assert!(furthest(&whole, &start) > 0.1);
}

/// Each resistor makes noise of its own, `2 kT G`; together they leave `kT/C` on every
/// node and nothing between nodes, whatever the parts: `A S + S Aᵀ + D = 0`.
#[test]
fn noise_of_unequal_parts_is_kt_over_c() {
    let network = chip(sheet(2.0), (6, 6), 0.5, 3);
    let (n, kt) = (36, 0.7);
    let dark = Plane::zeros((6, 6));
    let capacitance: Vec<f64> = network.capacitance().iter().copied().collect();
    // Column j of the conductances: minus the currents that node j at 1 pushes.
    let column = |j: usize| -> Vec<f64> {
        let mut unit = Plane::zeros((6, 6));
        unit[[j / 6, j % 6]] = 1.0;
        network
            .currents(&dark, &unit)
            .unwrap()
            .iter()
            .map(|i| -i)
            .collect()
    };
    let k: Vec<Vec<f64>> = (0..n).map(column).collect();
    // Noise currents, resistor by resistor.
    let mut noise = vec![vec![0.0; n]; n];
    let own = network.transverse();
    let (down, across) = network.lateral();
    for i in 0..n {
        let at = (i / 6, i % 6);
        noise[i][i] += 2.0 * kt * own[at];
        let mut between = |j: usize, g: f64| {
            for (a, b, sign) in [(i, i, 1.0), (j, j, 1.0), (i, j, -1.0), (j, i, -1.0)] {
                noise[a][b] += sign * 2.0 * kt * g;
            }
        };
        if at.0 + 1 < 6 {
            between(i + 6, down[at]);
        }
        if at.1 + 1 < 6 {
            between(i + 1, across[at]);
        }
    }
    for i in 0..n {
        for j in 0..n {
            // A = -K/C, S = kT/C on the diagonal.
            let a_s = -k[j][i] / capacitance[i] * kt / capacitance[j];
            let s_a = -k[i][j] / capacitance[j] * kt / capacitance[i];
            let d = noise[i][j] / (capacitance[i] * capacitance[j]);
            assert!((a_s + s_a + d).abs() < 1e-12 * d.abs().max(1.0), "{i} {j}");
        }
    }
    // And so it is drawn.
    let draws = 20_000u64;
    let sum: f64 = (0..draws)
        .map(|m| network.noise(kt, 5, m)[[2, 2]].powi(2))
        .sum();
    let want = kt / network.capacitance()[[2, 2]];
    let got = sum / draws as f64;
    assert!(
        (got / want - 1.0).abs() < 4.0 * (2.0 / draws as f64).sqrt(),
        "{got} {want}"
    );
}

/// Laterals that bend: far from the bend they are resistors; two nodes are solved by hand;
/// the currents of what was found are none.
#[test]
fn bending_laterals() {
    let signal = scene(14, 11, 2);
    let network = chip(sheet(2.0), (14, 11), 0.2, 9);
    let linear = network.settle(&signal).unwrap().surround;
    let kinds: [fn(f64) -> Laterals; 2] = [
        |scale| Laterals::Saturating { scale },
        |scale| Laterals::Opening { scale },
    ];
    for kind in kinds {
        let mut before = 0.0;
        for scale in [1e6, 1.0, 0.3, 0.1, 0.03, 0.01] {
            let bent = network.clone().with_laterals(kind(scale)).unwrap();
            let settled = bent.settle(&signal).unwrap();
            let left = bent.currents(&signal, &settled.surround).unwrap();
            let most = left.iter().fold(0.0, |m: f64, i| m.max(i.abs()));
            assert!(most < 1e-11, "{:?}: {most:e}", kind(scale));
            let off = furthest(&settled.surround, &linear);
            if scale > 1e5 {
                assert!(off < 1e-12, "{off}");
            } else {
                assert!(
                    off > before && settled.newton < 100,
                    "{scale}: {off}, {}",
                    settled.newton
                );
            }
            before = off;
        }
    }
    // Saturated laterals hardly smooth, open ones hardly resist.
    let far = |laterals| {
        let bent = network.clone().with_laterals(laterals).unwrap();
        bent.settle(&signal).unwrap().surround
    };
    assert!(furthest(&far(Laterals::Saturating { scale: 1e-4 }), &signal) < 0.01);
    let open = far(Laterals::Opening { scale: 1e-4 });
    let spread = open
        .iter()
        .fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
    assert!(spread.1 - spread.0 < 0.05, "{spread:?}");
    // Two nodes with signals -1 and 1: h = 1 - 2... solved by bisection.
    let two = chip(sheet(1.5), (1, 2), 0.0, 0);
    let pair = ndarray::arr2(&[[-1.0, 1.0]]);
    for (laterals, f) in [
        (
            Laterals::Saturating { scale: 0.4 },
            (|v: f64| 0.4 * (v / 0.4).tanh()) as fn(f64) -> f64,
        ),
        (Laterals::Opening { scale: 0.4 }, |v: f64| {
            0.4 * (v / 0.4).sinh()
        }),
    ] {
        let settled = two
            .clone()
            .with_laterals(laterals)
            .unwrap()
            .settle(&pair)
            .unwrap();
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..80 {
            let h: f64 = 0.5 * (low + high);
            if 1.0 - h > 2.25 * f(2.0 * h) {
                low = h;
            } else {
                high = h;
            }
        }
        assert!((settled.surround[[0, 1]] - low).abs() < 1e-13);
        assert!((settled.surround[[0, 0]] + low).abs() < 1e-13);
    }
}

/// Mismatch is a fixed pattern of the chip, log-normal around the nominal value.
#[test]
fn mismatch_is_log_normal() {
    let network = chip(sheet(3.0), (200, 200), 0.2, 11);
    let (down, across) = network.lateral();
    let inside = |p: &Plane<f64>, nominal: f64| -> Vec<f64> {
        p.iter()
            .filter(|v| **v > 0.0)
            .map(|v| (v / nominal).ln())
            .collect()
    };
    for logs in [
        inside(&network.transverse(), 1.0),
        inside(&down, 9.0),
        inside(&across, 9.0),
        inside(&network.capacitance(), 1.0),
    ] {
        let n = logs.len() as f64;
        let mean = logs.iter().sum::<f64>() / n;
        let sigma = (logs.iter().map(|l| (l - mean).powi(2)).sum::<f64>() / n).sqrt();
        assert!(mean.abs() < 4.0 * 0.2 / n.sqrt() && (sigma / 0.2 - 1.0).abs() < 0.02);
    }
    assert_eq!(network, chip(sheet(3.0), (200, 200), 0.2, 11));
    assert_ne!(network, chip(sheet(3.0), (200, 200), 0.2, 12));
}

#[test]
fn impossible_parts_are_refused() {
    let one = Plane::<f64>::ones((3, 4));
    let (down, across) = (Plane::ones((2, 4)), Plane::ones((3, 3)));
    assert!(Network::new(&one, &down, &across, &one).is_ok());
    for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let mut bad = one.clone();
        bad[[2, 1]] = value;
        let refused = Network::new(&bad, &down, &across, &one).unwrap_err();
        assert!(
            refused
                .to_string()
                .starts_with("the transverse conductance at x = 1, y = 2 is")
        );
        assert!(Network::new(&one, &down, &across, &bad).is_err());
    }
    // An open resistor is one.
    let mut cut = down.clone();
    cut[[1, 1]] = 0.0;
    assert!(Network::new(&one, &cut, &across, &one).is_ok());
    cut[[1, 1]] = -0.1;
    assert!(Network::new(&one, &cut, &across, &one).is_err());
    assert!(matches!(
        Network::new(&one, &across, &down, &one),
        Err(MeshError::Size { .. })
    ));
    let network = Network::new(&one, &down, &across, &one).unwrap();
    for scale in [0.0, -1.0, f64::NAN] {
        assert!(
            network
                .clone()
                .with_laterals(Laterals::Opening { scale })
                .is_err()
        );
    }
    let bent = network
        .clone()
        .with_laterals(Laterals::Opening { scale: 1.0 })
        .unwrap();
    assert_eq!(
        bent.advance(&one, (&one, &one), 1.0),
        Err(MeshError::Laterals)
    );
    assert!(network.advance(&one, (&one, &one), -1.0).is_err());
    let mut bad = one.clone();
    bad[[0, 3]] = f64::NAN;
    assert!(
        network
            .settle(&bad)
            .unwrap_err()
            .to_string()
            .contains("x = 3, y = 0")
    );
}
