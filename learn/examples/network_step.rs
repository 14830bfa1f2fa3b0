//! How long a step of a network takes: forward, backward, Adam.
//!
//! `cargo run --release -p amacrine-learn --example network_step` prints milliseconds of one thread,
//! the median of some steps, for the network that `learn/frameworks` measures in other frameworks and
//! for that of the bundled tasks.

use std::{fs, time::Instant};

use amacrine::plane::Size;
use amacrine_learn::network::{Adam, Maps, Network, PICTURES, Plan};
use rayon::prelude::*;

fn main() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1);
    let pool = pool.build().expect("threads can be started");
    pool.install(|| {
        measure(&[16, 32, 48, 64], 2, 64);
        measure(&[16, 24, 32], 2, 32);
        measure(&[16, 24, 32], 1, 32);
    });
}

fn measure(widths: &[usize], convolutions: usize, side: usize) {
    const BATCH: usize = 8;
    let plan = Plan {
        widths: widths.to_vec(),
        convolutions,
        inputs: 11,
        outputs: 1,
    };
    let network = Network::<f32>::new(plan, Size::new(side, side), BATCH);
    let mut parameters = network.start(1, 11);
    let mut adam = Adam::new(parameters.len());
    let mut inputs = vec![Maps::zeros(network.shape(), 11); BATCH / PICTURES];
    for n in 0..BATCH {
        for c in 0..11 {
            for y in 0..side {
                let row = inputs[n / PICTURES].row_mut(network.shape(), (n % PICTURES, c), y);
                for (x, value) in row.iter_mut().enumerate() {
                    *value = ((n * 31 + c * 17 + y * 7 + x * 3) % 11) as f32 * 0.1;
                }
            }
        }
    }
    let mut times = Vec::new();
    for _ in 0..25 {
        let start = now();
        let packed = network.packed(&parameters);
        let each: Vec<_> = inputs
            .par_iter()
            .map(|input| {
                let (answer, seen) = network.forward(&parameters, &packed, input.clone());
                let mut gradient = vec![0.0; parameters.len()];
                let back = network.backward(&packed, &seen, answer, (&mut gradient, true));
                (gradient, back.map_or(0, |maps| maps.channels()))
            })
            .collect();
        let mut sum = vec![0.0; parameters.len()];
        for (gradient, _) in &each {
            for (sum, g) in sum.iter_mut().zip(gradient) {
                *sum += g;
            }
        }
        adam.step(&mut parameters, &sum, 1e-4);
        times.push((now() - start) * 1e3);
    }
    times.sort_by(f64::total_cmp);
    let products = 3.0 * (BATCH * network.products()) as f64;
    println!(
        "{widths:?} x {convolutions}, {side}x{side}, {} weights: median {:.1} ms, least {:.1} ms, {:.1} G products/s",
        network.parameters(),
        times[times.len() / 2],
        times[0],
        products / times[0] * 1e-6
    );
}

/// Seconds of this thread on a processor where the system tells, else of the clock.
fn now() -> f64 {
    let told = fs::read_to_string("/proc/thread-self/schedstat").ok();
    let spent = told.and_then(|told| told.split_whitespace().next()?.parse::<f64>().ok());
    spent.map_or_else(
        || START.with(|start| start.elapsed().as_secs_f64()),
        |nanoseconds| nanoseconds * 1e-9,
    )
}

thread_local! {
    static START: Instant = Instant::now();
}
