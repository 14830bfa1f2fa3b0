//! What the machine can do: small loops that do nothing but compute, or nothing but move bytes.

use std::{collections::BTreeMap, hint::black_box};

use multiversion::multiversion;

use crate::timing::Timing;

/// Multiplications and additions a second on one thread, from registers, without fusing them
/// (the reference does not, so that every machine gives the same bits).
fn operations(bytes: usize, timing: Timing) -> f64 {
    const ROUNDS: usize = 10_000;
    let (seconds, lanes) = if bytes == 8 {
        let mut sums = [1f64; 48];
        (timing.time(|| double(black_box(&mut sums), ROUNDS)), 48)
    } else {
        let mut sums = [1f32; 96];
        (timing.time(|| single(black_box(&mut sums), ROUNDS)), 96)
    };
    (2 * lanes * ROUNDS) as f64 / seconds.median
}

#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn single(sums: &mut [f32; 96], rounds: usize) {
    let mut own = *sums;
    for _ in 0..rounds {
        for sum in &mut own {
            *sum = *sum * 0.999 + 0.001;
        }
    }
    *sums = own;
}

#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn double(sums: &mut [f64; 48], rounds: usize) {
    let mut own = *sums;
    for _ in 0..rounds {
        for sum in &mut own {
            *sum = *sum * 0.999 + 0.001;
        }
    }
    *sums = own;
}

/// Bytes a second that one thread reads and writes again, over and over the same `bytes`.
fn bandwidth(bytes: usize, timing: Timing) -> f64 {
    let mut data = vec![1u64; (bytes / 8).max(1)];
    let seconds = timing.time(|| touch(black_box(&mut data)));
    (2 * 8 * data.len()) as f64 / seconds.median
}

#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn touch(data: &mut [u64]) {
    for value in data {
        *value = value.wrapping_add(1);
    }
}

/// The limits of this machine, measured when they are first asked for.
pub struct Machine {
    timing: Timing,
    single: f64,
    double: f64,
    bandwidths: BTreeMap<usize, f64>,
}

impl Machine {
    pub fn new(timing: Timing) -> Self {
        Self {
            timing,
            single: operations(4, timing),
            double: operations(8, timing),
            bandwidths: BTreeMap::new(),
        }
    }

    pub fn operations(&self, bytes: usize) -> f64 {
        if bytes == 8 { self.double } else { self.single }
    }

    /// For a working set of about so many bytes.
    pub fn bandwidth(&mut self, bytes: usize) -> f64 {
        let about = bytes.next_power_of_two();
        let measure = || bandwidth(about, self.timing);
        *self.bandwidths.entry(about).or_insert_with(measure)
    }

    pub fn show(&mut self) {
        println!(
            "one thread: {:.1} G multiplications and additions a second in f32, {:.1} in f64",
            self.single * 1e-9,
            self.double * 1e-9
        );
        for (name, bytes) in [("256 KB", 1 << 18), ("2 MB", 1 << 21), ("64 MB", 1 << 26)] {
            let rate = self.bandwidth(bytes) * 1e-9;
            println!("one thread, {name} of memory: {rate:.1} GB/s read and written");
        }
    }
}
