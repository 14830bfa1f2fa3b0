//! Proves that the intervals of the fitted figures in `isa/scamp5/device.toml` are those that
//! the only public measurement of the chip allows: an identity repeated on uniform planes (B.
//! Guillard, "CNNs on FPSPs", noise accumulation, MIT). `docs/silicon.md` derives what is
//! computed here; `cargo test --test accumulation -- --nocapture` prints it.

use std::ops::RangeInclusive;

use amacrine::isa::{Device, Figure};

/// Turns of the identity at which the data are taken; n = 1 is left out, its analysis wrapped.
const TURNS: [usize; 5] = [2, 4, 8, 16, 32];

/// Input, and the bias after [`TURNS`], in LSB: those of the fit.
const BIASES: [(f64, [f64; 5]); 4] = [
    (0.0, [6.19, 12.21, 22.54, 37.42, 54.98]),
    (10.0, [7.28, 14.59, 26.68, 44.00, 63.78]),
    (60.0, [13.65, 24.23, 43.17, 73.03, 105.49]),
    (120.0, [17.42, 33.29, 61.88, 100.09, 148.94]),
];

/// What is published of the spread over the pixels. Left out is n = 8 of input 120, whose reading passes the codes at which the reading of input
/// 60 spikes too; before the first turn that reading is taken to spread as those of 0 and 10.
const SPREADS: [Spread; 4] = [
    Spread {
        input: 0.0,
        reading: 1.56,
        after: &[(2, 2.20), (8, 4.79), (16, 9.05), (32, 18.14)],
    },
    Spread {
        input: 10.0,
        reading: 1.21,
        after: &[(2, 2.01), (8, 4.82), (16, 8.71), (32, 17.61)],
    },
    Spread {
        input: 60.0,
        reading: 1.38,
        after: &[(2, 2.37), (8, 4.70), (16, 7.97), (32, 14.82)],
    },
    Spread {
        input: 120.0,
        reading: 2.81,
        after: &[(2, 3.49), (16, 8.42), (32, 12.79)],
    },
];

/// Spreads over the pixels, in LSB.
struct Spread {
    input: f64,
    /// Before the first turn.
    reading: f64,
    /// Turns, and the spread after them.
    after: &'static [(usize, f64)],
}

/// The input whose reading spikes: what it reads above itself is fitted.
const SPIKING: f64 = 60.0;

/// A value is within the interval if its log-likelihood is within this of the largest.
const WITHIN: f64 = 2.0;

/// Cells of the identity: A, E, F and NEWS.
const CELLS: usize = 4;

/// Stores of the identity.
const STORES: usize = 11;

/// What a store errs by.
#[derive(Clone, Copy)]
struct Store {
    transfer: f64,
    loss: f64,
    division: f64,
}

/// How the cells differ, and the noise of each store.
#[derive(Clone, Copy, Default)]
struct Drawn {
    gain: [f64; CELLS],
    offset: [f64; CELLS],
    noise: [f64; STORES],
}

impl Store {
    fn of(device: &Device) -> Self {
        Self {
            transfer: device.value(Figure::TransferError),
            loss: device.value(Figure::StoreLoss),
            division: device.value(Figure::DivisionError),
        }
    }

    /// `diva(A, E, F); mov(F, A); add(A, A, F)` of a value, store by store.
    fn identity(self, x: f64, drawn: &Drawn) -> f64 {
        let (mut number, [a, e, f, news]) = (0, [0, 1, 2, 3]);
        let mut store = |cell: usize, bus: f64, splits: bool| {
            let error = self.transfer + if splits { self.division } else { 0.0 };
            let own = drawn.offset[cell] + drawn.noise[number];
            number += 1;
            -(1.0 - self.loss + drawn.gain[cell]) * bus + error + own
        };
        let (half_e, half_f) = (store(e, x / 2.0, true), store(f, x / 2.0, true));
        let t = store(news, half_e + x, false);
        let whole = store(a, t + half_f, false);
        let half_e = store(e, whole / 2.0, true);
        store(f, whole / 2.0, true);
        let half = store(a, half_e, false);
        let t = store(news, half, false);
        let copy = store(f, t, false);
        let t = store(news, half + copy, false);
        store(a, t, false)
    }

    /// Gain and offset of the identity.
    fn map(self, drawn: &Drawn) -> (f64, f64) {
        let offset = self.identity(0.0, drawn);
        (self.identity(1.0, drawn) - offset, offset)
    }

    /// Bias after 1 to 32 turns.
    fn bias(self, input: f64) -> Vec<f64> {
        let (gain, offset) = self.map(&Drawn::default());
        let mut x = input;
        let mut turn = || {
            x = gain * x + offset;
            input - x
        };
        (0..32).map(|_| turn()).collect()
    }
}

fn steps(range: RangeInclusive<f64>, step: f64) -> Vec<f64> {
    let count = ((range.end() - range.start()) / step).round() as usize;
    (0..=count)
        .map(|i| range.start() + i as f64 * step)
        .collect()
}

/// The log-likelihood of a sum of squared residuals, Gaussian of a spread that is itself the
/// likeliest, less that of the least sum.
fn less_likely(sum: f64, least: f64, residuals: usize) -> f64 {
    -0.5 * residuals as f64 * (sum / least).ln()
}

/// Where the profile of one parameter (the least sum of squares at each of its values) is
/// within [`WITHIN`] of the largest likelihood.
fn interval(what: &str, values: &[f64], sums: &[f64], residuals: usize) -> [f64; 2] {
    let least = sums.iter().copied().fold(f64::INFINITY, f64::min);
    println!("{what}: log-likelihood, less that of the likeliest");
    let mut likely = Vec::new();
    for (value, sum) in values.iter().zip(sums) {
        let less = less_likely(*sum, least, residuals);
        if less >= -2.0 * WITHIN {
            println!("  {value:9.5}  {less:7.3}");
        }
        if less >= -WITHIN {
            likely.push(*value);
        }
    }
    let ends = [likely[0], likely[likely.len() - 1]];
    println!("  within {WITHIN} of it: {:.5} to {:.5}", ends[0], ends[1]);
    ends
}

/// The file says what the fit gives, to a step of the grid and the rounding of the file.
#[track_caller]
fn is_stated(figure: Figure, [low, high]: [f64; 2], by: f64) {
    let device = Device::scamp5();
    let stated = device.interval(figure).expect("an interval");
    let off = (stated.low - low).abs().max((stated.high - high).abs());
    assert!(
        off <= 1.01 * by,
        "{figure:?}: {stated:?}, not {low} to {high}"
    );
    assert!(stated.why.contains("log-likelihood"), "{stated:?}");
}

#[test]
fn loss_and_division_are_what_the_bias_allows() {
    let device = Device::scamp5();
    let losses = steps(0.0062..=0.0083, 0.000_05);
    let divisions = steps(1.8..=2.2, 0.01);
    let residuals = BIASES.len() * TURNS.len();
    let mut sums = vec![vec![0.0; divisions.len()]; losses.len()];
    for (loss, row) in losses.iter().zip(&mut sums) {
        for (division, sum) in divisions.iter().zip(row) {
            let store = Store {
                loss: *loss,
                division: *division,
                ..Store::of(&device)
            };
            for (input, measured) in BIASES {
                let bias = store.bias(input);
                let off = |(n, measured): (usize, f64)| bias[n - 1] - measured;
                let off: Vec<f64> = TURNS.into_iter().zip(measured).map(off).collect();
                let above = if input == SPIKING {
                    off.iter().sum::<f64>() / off.len() as f64
                } else {
                    0.0
                };
                *sum += off.iter().map(|off| (off - above).powi(2)).sum::<f64>();
            }
        }
    }
    let least = |sums: &mut dyn Iterator<Item = f64>| sums.fold(f64::INFINITY, f64::min);
    let by_loss: Vec<f64> = { sums.iter() }
        .map(|row| least(&mut row.iter().copied()))
        .collect();
    let by_division: Vec<f64> = (0..divisions.len())
        .map(|i| least(&mut sums.iter().map(|row| row[i])))
        .collect();
    let loss = interval("error.loss", &losses, &by_loss, residuals);
    let division = interval("error.division", &divisions, &by_division, residuals);
    is_stated(Figure::StoreLoss, loss, 0.000_05);
    is_stated(Figure::DivisionError, division, 0.01);
    let best = least(&mut by_loss.iter().copied());
    let rms = (best / residuals as f64).sqrt();
    println!("rms of the likeliest: {rms:.3} LSB");
    assert!(rms < 0.8, "{rms}");
    // The values themselves are the likeliest, to a step of the grid.
    let row = losses
        .iter()
        .position(|l| (l - device.value(Figure::StoreLoss)).abs() < 1e-9);
    let at = divisions
        .iter()
        .position(|d| (d - device.value(Figure::DivisionError)).abs() < 1e-9);
    let stated = sums[row.expect("on the grid")][at.expect("on the grid")];
    let less = less_likely(stated, best, residuals);
    assert!(less > -0.05, "the stated values are less likely by {less}");
}

/// What is known of one spread: its mean square is a sum of these, each with its parameters.
struct Known {
    measured: f64,
    /// Of gain twice, of gain and offset, of offset twice.
    mismatch: [f64; 3],
    noise: f64,
    reading: f64,
}

/// The mean square of each spread, to first order in what the cells differ by.
fn known(store: Store) -> Vec<Known> {
    const STEP: f64 = 1e-5;
    let none = Drawn::default();
    let (gain, offset) = store.map(&none);
    let slope = |drawn: &Drawn| {
        let other = store.map(drawn);
        ((other.0 - gain) / STEP, (other.1 - offset) / STEP)
    };
    let of_gain = [0, 1, 2, 3].map(|cell| {
        let mut drawn = none;
        drawn.gain[cell] = STEP;
        slope(&drawn)
    });
    let of_offset = [0, 1, 2, 3].map(|cell| {
        let mut drawn = none;
        drawn.offset[cell] = STEP;
        slope(&drawn)
    });
    // A turn adds so much of a store's mean square noise.
    let one = |number| {
        let mut drawn = none;
        drawn.noise[number] = STEP;
        slope(&drawn).1.powi(2)
    };
    let fresh: f64 = (0..STORES).map(one).sum();
    let mut all = Vec::new();
    for Spread {
        input,
        reading,
        after,
    } in SPREADS
    {
        let (mut x, mut noise) = (input, 0.0);
        let mut off = [[0.0; CELLS]; 2];
        let mut turns = 0;
        for (n, measured) in after {
            while turns < *n {
                for (off, slopes) in off.iter_mut().zip([of_gain, of_offset]) {
                    for (off, (of_gain, of_offset)) in off.iter_mut().zip(slopes) {
                        *off = gain * *off + of_gain * x + of_offset;
                    }
                }
                noise = gain * gain * noise + fresh;
                x = gain * x + offset;
                turns += 1;
            }
            let product = |a: [f64; CELLS], b: [f64; CELLS]| -> f64 {
                a.iter().zip(b).map(|(a, b)| a * b).sum()
            };
            all.push(Known {
                measured: *measured,
                mismatch: [
                    product(off[0], off[0]),
                    2.0 * product(off[0], off[1]),
                    product(off[1], off[1]),
                ],
                noise,
                reading: reading * reading,
            });
        }
    }
    all
}

/// The sum of squared residuals of the spreads.
fn misfit(known: &[Known], mismatch: [f64; 3], noise: f64, reading: f64) -> f64 {
    let mut sum = 0.0;
    for one in known {
        let of_cells = mismatch[0] * one.mismatch[0]
            + mismatch[1] * one.mismatch[1]
            + mismatch[2] * one.mismatch[2];
        let square = of_cells + noise * noise * one.noise + reading * one.reading;
        sum += (square.max(0.0).sqrt() - one.measured).powi(2);
    }
    sum
}

#[test]
fn mismatch_and_noise_are_what_the_spread_allows() {
    let known = known(Store::of(&Device::scamp5()));
    let gains = steps(0.0022..=0.0042, 0.000_1);
    let offsets = steps(0.05..=0.16, 0.005);
    let correlations = steps(-1.0..=0.4, 0.2);
    let noises = steps(0.0..=0.4, 0.01);
    // Of the mean square of the first reading: how much stays.
    let readings = steps(0.0..=1.0, 0.25);
    let mut sums =
        [&gains, &offsets, &correlations, &noises].map(|values| vec![f64::INFINITY; values.len()]);
    for (i, gain) in gains.iter().enumerate() {
        for (j, offset) in offsets.iter().enumerate() {
            for (k, correlation) in correlations.iter().enumerate() {
                let mismatch = [gain * gain, correlation * gain * offset, offset * offset];
                for (l, noise) in noises.iter().enumerate() {
                    for reading in &readings {
                        let sum = misfit(&known, mismatch, *noise, *reading);
                        for (sums, at) in sums.iter_mut().zip([i, j, k, l]) {
                            sums[at] = sums[at].min(sum);
                        }
                    }
                }
            }
        }
    }
    let of = |what, values: &[f64], sums: &[f64]| interval(what, values, sums, known.len());
    let [by_gain, by_offset, by_correlation, by_noise] = &sums;
    let gain = of("error.gain_mismatch", &gains, by_gain);
    let offset = of("error.offset_mismatch", &offsets, by_offset);
    let correlation = of("error.mismatch_correlation", &correlations, by_correlation);
    let noise = of("error.noise", &noises, by_noise);
    is_stated(Figure::GainMismatch, gain, 0.000_1);
    is_stated(Figure::OffsetMismatch, offset, 0.005);
    is_stated(Figure::MismatchCorrelation, correlation, 0.2);
    is_stated(Figure::StoreNoise, noise, 0.01);
}

/// The closed form against the mean and the spread of cells that are drawn one by one.
#[test]
fn the_first_order_is_what_drawn_cells_do() {
    let (gain, offset, noise) = (0.003, 0.1, 0.2);
    let store = Store::of(&Device::scamp5());
    let known = known(store);
    // A row of the table: input 10, 16 turns.
    let one = &known[6];
    let square = gain * gain * one.mismatch[0] + offset * offset * one.mismatch[2];
    let wanted = (square + noise * noise * one.noise).sqrt();
    let mut state = 7_u64;
    let mut normal = || -> f64 {
        let mut uniform = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..12).map(|_| uniform()).sum::<f64>() - 6.0
    };
    let cell = |normal: &mut dyn FnMut() -> f64| {
        let mut drawn = Drawn {
            gain: [0; CELLS].map(|_| gain * normal()),
            offset: [0; CELLS].map(|_| offset * normal()),
            ..Drawn::default()
        };
        let mut x = 10.0;
        for _ in 0..16 {
            drawn.noise = [0; STORES].map(|_| noise * normal());
            x = store.identity(x, &drawn);
        }
        x
    };
    let cells: Vec<f64> = (0..4000).map(|_| cell(&mut normal)).collect();
    let mean = cells.iter().sum::<f64>() / cells.len() as f64;
    let squares = cells.iter().map(|x| (x - mean).powi(2)).sum::<f64>();
    let spread = (squares / cells.len() as f64).sqrt();
    assert!(
        (spread / wanted - 1.0).abs() < 0.05,
        "{spread}, not {wanted}"
    );
}
