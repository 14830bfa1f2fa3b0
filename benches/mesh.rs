//! How fast a sheet is solved, on one thread, and how the time grows with the size.
//!
//! `cargo bench --bench mesh` (half a minute), or with `-- --quick` (seconds, rougher). Every
//! figure is the median over repetitions, with half the distance of its quartiles. The last columns are the time of a pixel over the
//! logarithm of the row's length: flat if the time grows as N log N and memory keeps up.

#[path = "common/timed.rs"]
mod timed;

use std::{hint::black_box, time::Duration};

use amacrine::{
    mesh::{Between, Euler, Float, Flow, Laterals, Mismatch, Network, Sheet, Steady},
    plane::{Plane, Size},
    rng::{mix, uniform},
};

use crate::timed::Timed;

fn scene(size: Size, seed: u64) -> Plane<f64> {
    Plane::from_shape_fn(size.shape(), |(y, x)| {
        uniform(mix(seed ^ mix((y * 65_536 + x) as u64 + 1)))
    })
}

/// The time of a call, over about `budget` seconds.
fn timed(budget: f64, call: impl FnMut()) -> Timed {
    Timed::new(5, Duration::from_secs_f64(budget), call)
}

/// Milliseconds and their spread.
fn ms(time: Timed) -> String {
    format!("{:.3} {:>5}", time.median * 1e3, time.plus_minus())
}

struct Row {
    steady: Timed,
    flow: Timed,
}

fn measured<T: Float>(size: Size, budget: f64) -> Row {
    let sheet = Sheet::new(10.0).unwrap();
    let held = |seed| scene(size, seed).mapv(T::nearest);
    let (a, b) = (held(1), held(2));
    let mut steady = Steady::<T>::new(sheet, size).unwrap();
    let mut surround = a.clone();
    let steady = timed(budget, || {
        steady.solve_into(black_box(&a), &mut surround).unwrap();
    });
    let mut flow = Flow::<T>::settled(sheet, 1e-3, &a).unwrap();
    let flow = timed(budget, || {
        flow.advance(black_box(&b), 1e-3, Between::Ramp).unwrap();
    });
    Row { steady, flow }
}

fn main() {
    let quick = std::env::args().any(|argument| argument == "--quick");
    let budget = if quick { 0.05 } else { 1.0 };
    println!("{}", timed::cpu());
    println!("one thread; λ 10; milliseconds, median and spread\n");
    println!(
        "{:<11} {:>16} {:>16} {:>16} {:>16} {:>16} {:>16}",
        "size",
        "steady f64",
        "steady f32",
        "frame f64",
        "frame f32",
        "ns/px/log2 f64",
        "ns/px/log2 f32"
    );
    let largest = if quick { 1024 } else { 4096 };
    let mut sizes: Vec<Size> = (5..=12)
        .map(|power| Size::new(1 << power, 1 << power))
        .filter(|size| size.width <= largest)
        .collect();
    // A sensor's size, a prime, a line.
    sizes.extend([
        Size::new(260, 346),
        Size::new(251, 257),
        Size::new(1, 65_536),
    ]);
    for size in sizes {
        let (double, single) = (measured::<f64>(size, budget), measured::<f32>(size, budget));
        let each =
            |time: Timed| 1e9 * time.median / size.pixels() as f64 / (size.width as f64).log2();
        println!(
            "{:<11} {:>16} {:>16} {:>16} {:>16} {:>16.3} {:>16.3}",
            size.to_string(),
            ms(double.steady),
            ms(single.steady),
            ms(double.flow),
            ms(single.flow),
            each(double.steady),
            each(single.steady)
        );
    }

    against_powers_of_two(budget, if quick { 3 } else { 9 });
    unequal_parts(budget);
    euler(budget);
    silicon();
}

/// What a pixel of a sensor costs whose sides are no powers of two, as a multiple of 256x256, in
/// pairs of measurements.
fn against_powers_of_two(budget: f64, times: usize) {
    println!("\n346x260 for each pixel, times 256x256 (median of {times} pairs, and spread):");
    let (odd, even) = (Size::new(260, 346), Size::new(256, 256));
    let pixels = odd.pixels() as f64 / even.pixels() as f64;
    let budget = budget / 4.0;
    let each = |name: &str, of: &dyn Fn(Size) -> f64| {
        let ratios = (0..times).map(|_| of(odd) / of(even) / pixels);
        let ratio = Timed::from_seconds(ratios.collect());
        println!(
            "  {name:<11} {:>5.2} {:>5}",
            ratio.median,
            ratio.plus_minus()
        );
    };
    each("steady f64", &|size| {
        measured::<f64>(size, budget).steady.median
    });
    each("steady f32", &|size| {
        measured::<f32>(size, budget).steady.median
    });
    each("frame f64", &|size| {
        measured::<f64>(size, budget).flow.median
    });
    each("frame f32", &|size| {
        measured::<f32>(size, budget).flow.median
    });
}

fn unequal_parts(budget: f64) {
    println!("\nunequal parts, 256x256 (20 % mismatch of every part), settled to 1e-15:");
    let size = Size::new(256, 256);
    let signal = scene(size, 3);
    for lambda in [1.0, 10.0, 100.0] {
        let mismatch = Mismatch {
            lateral: 0.2,
            transverse: 0.2,
            capacitance: 0.2,
        };
        let network = Network::uniform(Sheet::new(lambda).unwrap(), size).unwrap();
        let network = network.with_mismatch(mismatch, 1);
        let mut steps = 0;
        let time = timed(budget, || {
            steps = network.settle(black_box(&signal)).unwrap().iterations;
        });
        println!(
            "  λ {lambda:<5} {:>16} ms, {steps} steps of conjugate gradients",
            ms(time)
        );
    }
}

fn euler(budget: f64) {
    let size = Size::new(256, 256);
    let signal = scene(size, 3);
    println!("\nv2e's Euler, one frame of 1 ms, 256x256:");
    for (lambda, tau) in [(2.0, 5e-3), (10.0, 5e-3), (10.0, 5e-4)] {
        let sheet = Sheet::new(lambda).unwrap();
        let euler = Euler::begin(sheet, tau, &signal).unwrap();
        let later = scene(size, 4);
        let mut steps = 0;
        let time = timed(budget.min(0.3), || {
            let mut euler = euler.clone();
            euler.advance(black_box(&later), 1e-3).unwrap();
            steps = euler.steps();
        });
        println!(
            "  λ {lambda:<5} τ {:>4} ms {:>16} ms, {steps} steps",
            tau * 1e3,
            ms(time)
        );
    }
}

fn silicon() {
    println!(
        "\nwhat silicon does to the surround of a checkerboard (48x48, squares of 8 pixels, one"
    );
    println!("e-fold of contrast): root mean square of the change of H, in e-folds, 8 chips");
    println!(
        "{:<6} {:>5}  {:>9} {:>10}    laterals that saturate at 1, 0.3, 0.1 e-folds",
        "λ", "sigma", "laterals", "transverse"
    );
    for lambda in [1.0, 3.0, 10.0] {
        for sigma in [0.01, 0.05, 0.2] {
            let lateral = change(
                lambda,
                Mismatch {
                    lateral: sigma,
                    ..Mismatch::default()
                },
            );
            let transverse = change(
                lambda,
                Mismatch {
                    transverse: sigma,
                    ..Mismatch::default()
                },
            );
            print!("{lambda:<6} {sigma:>5}  {lateral:>9.5} {transverse:>10.5}");
            if sigma == 0.01 {
                for scale in [1.0, 0.3, 0.1] {
                    print!("  {:>8.5}", bent(lambda, scale));
                }
            }
            println!();
        }
    }
}

fn checkerboard() -> Plane<f64> {
    Plane::from_shape_fn((48, 48), |(y, x)| ((y / 8 + x / 8) % 2) as f64)
}

fn rms(a: &Plane<f64>, b: &Plane<f64>) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b));
    (squares.sum::<f64>() / a.len() as f64).sqrt()
}

fn change(lambda: f64, mismatch: Mismatch) -> f64 {
    let signal = checkerboard();
    let nominal = Network::uniform(Sheet::new(lambda).unwrap(), Size::of(&signal)).unwrap();
    let want = nominal.settle(&signal).unwrap().surround;
    let squares = (0..8).map(|seed| {
        let chip = nominal.clone().with_mismatch(mismatch, seed);
        rms(&chip.settle(&signal).unwrap().surround, &want).powi(2)
    });
    (squares.sum::<f64>() / 8.0).sqrt()
}

fn bent(lambda: f64, scale: f64) -> f64 {
    let signal = checkerboard();
    let nominal = Network::uniform(Sheet::new(lambda).unwrap(), Size::of(&signal)).unwrap();
    let want = nominal.settle(&signal).unwrap().surround;
    let bent = nominal
        .with_laterals(Laterals::Saturating { scale })
        .unwrap();
    rms(&bent.settle(&signal).unwrap().surround, &want)
}
