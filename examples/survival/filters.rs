//! Kernels that programs of the chip are tried on, and a run of a filter as silicon.

use amacrine::{
    array::{Arithmetic, Settings},
    compile::{Filter, Request},
    event::Packet,
    kernel::{
        Kernel,
        quantise::{Quantiser, Sum},
    },
    plane::{Plane, Size},
    program::{Overrides, Program},
    rng::Hash,
    unit::Micros,
};

type Rows = Vec<Vec<f64>>;

fn outer(down: &[f64], across: &[f64], scale: f64) -> Rows {
    let row = |y: &f64| across.iter().map(|x| x * y * scale).collect();
    down.iter().map(row).collect()
}

/// A square of weights, of numbers from 0 to 1.
fn random(seed: u64, side: usize, weight: impl Fn(f64) -> f64) -> Rows {
    let key = Hash::raw(seed);
    let mut draws = (1..).map(|n| key.nth(n).bits());
    let mut next = || weight((draws.next().unwrap_or_default() >> 40) as f64 / f64::from(1 << 24));
    (0..side)
        .map(|_| (0..side).map(|_| next()).collect())
        .collect()
}

/// The filters, by name.
pub fn filters() -> Vec<(String, Vec<Kernel>)> {
    let binomial = [1.0, 2.0, 1.0];
    let five = [1.0, 4.0, 6.0, 4.0, 1.0];
    let slope = [-1.0, 0.0, 1.0];
    let sobel = outer(&binomial, &slope, 1.0);
    let other = outer(&slope, &binomial, 1.0);
    let gauss = outer(&binomial, &binomial, 1.0 / 16.0);
    let box3 = outer(&[1.0; 3], &[1.0; 3], 1.0);
    let cross: Rows = [[0.0, 1.0, 0.0], [1.0, -4.0, 1.0], [0.0, 1.0, 0.0]]
        .map(Vec::from)
        .into();
    let mut all: Vec<(String, Vec<Rows>)> = vec![
        ("Sobel x".into(), vec![sobel.clone()]),
        ("Sobel y".into(), vec![other.clone()]),
        ("Sobel pair".into(), vec![sobel.clone(), other.clone()]),
        ("Prewitt".into(), vec![outer(&[1.0; 3], &slope, 1.0)]),
        ("Gauss 3x3 / 16".into(), vec![gauss.clone()]),
        ("Gauss 3x3".into(), vec![outer(&binomial, &binomial, 1.0)]),
        (
            "Gauss 5x5 / 256".into(),
            vec![outer(&five, &five, 1.0 / 256.0)],
        ),
        ("Gauss 5x5".into(), vec![outer(&five, &five, 1.0)]),
        ("box 3x3".into(), vec![box3.clone()]),
        ("box 5x5".into(), vec![outer(&[1.0; 5], &[1.0; 5], 1.0)]),
        ("Laplacian".into(), vec![cross.clone()]),
        (
            "Gauss pair".into(),
            vec![gauss, outer(&five, &five, 1.0 / 256.0)],
        ),
        (
            "box and Laplacian".into(),
            vec![box3.clone(), cross.clone()],
        ),
        ("quad".into(), vec![sobel, other, box3, cross]),
    ];
    for (side, count) in [(3, 5), (5, 6), (7, 5)] {
        for i in 0..count {
            let rows = random(side * 100 + i, side as usize, |u| (3.0 * u).floor() - 1.0);
            all.push((format!("ternary {side}x{side}, {i}"), vec![rows]));
        }
    }
    for (bits, side, count) in [(4, 3, 4), (6, 3, 4), (4, 5, 3), (6, 5, 3)] {
        let most = f64::from(1 << (bits - 1));
        for i in 0..count {
            let seed = bits * 10_000 + side * 100 + i;
            let rows = random(seed, side as usize, |u| {
                ((2.0 * u - 1.0) * (most - 1.0)).round() / most
            });
            all.push((format!("{bits} bits {side}x{side}, {i}"), vec![rows]));
        }
    }
    let mut all: Vec<(String, Vec<Kernel>)> = all
        .into_iter()
        .map(|(name, kernels)| {
            let kernels = kernels.iter().map(|rows| Kernel::from_rows(rows));
            (name, kernels.collect::<Result<_, _>>().unwrap_or_default())
        })
        .collect();
    // Learned centre-surrounds in five bits and in one digit.
    for name in ["rgc-5x5", "csdvs-5", "dog"] {
        for to in ["int-5", "ternary"] {
            let (Some(kernel), Ok(to)) = (Kernel::builtin(name), to.parse::<Quantiser>()) else {
                continue;
            };
            if let Ok(quantised) = to.quantise(&kernel, Sum::Kept, 0) {
                let levels = quantised.within_one().levels;
                all.push((format!("{name} {to}"), vec![levels]));
            }
        }
    }
    all
}

/// Pixels of a side.
const SIDE: usize = 64;

/// Correlation of each result with the exact filter on a chip of this seed, away from the border,
/// for inputs that are uniform in ±`amplitude`.
///
/// # Panics
/// When the filter does not run.
pub fn correlations(filter: &Filter, request: &Request<'_>, amplitude: f64, seed: u64) -> Vec<f64> {
    let device = request.device;
    let program = Program::parse("filter", &filter.text(device, 0)).unwrap();
    let code = program.expand(device, &Overrides::default()).unwrap().code;
    let size = Size::new(SIDE, SIDE);
    let settings = Settings::from_device(device);
    let silicon = Arithmetic::Silicon { seed };
    let mut chip = silicon
        .chip("filter", &code, device, size, settings)
        .unwrap();
    let key = Hash::raw(seed ^ 0x5EED);
    let input = Plane::from_shape_fn(size.shape(), |(y, x)| {
        let draw = key.nth((y * SIDE + x) as u64 + 1).bits() >> 40;
        (draw as f64 / f64::from(1 << 23) - 1.0) * amplitude
    });
    chip.set_analog(request.input, &input).unwrap();
    chip.run_frame(Micros(0), &mut Packet::new(size, 1))
        .unwrap();
    let one = |(kernel, register): (&Kernel, &_)| {
        let got = chip.analog(*register);
        let (rows, columns) = kernel.reach();
        let mut pairs = Vec::new();
        for y in 10..SIDE - 10 {
            for x in 10..SIDE - 10 {
                let taps = kernel.weights().indexed_iter();
                let exact: f64 = taps
                    .map(|((i, j), w)| w * input[(y + i - rows, x + j - columns)])
                    .sum();
                pairs.push((exact, got[(y, x)]));
            }
        }
        correlation(&pairs)
    };
    request.kernels.iter().zip(&request.into).map(one).collect()
}

/// Correlation; 0 where one side is constant.
fn correlation(pairs: &[(f64, f64)]) -> f64 {
    let count = pairs.len() as f64;
    let (a, b) = pairs
        .iter()
        .fold((0.0, 0.0), |(a, b), pair| (a + pair.0, b + pair.1));
    let (a, b) = (a / count, b / count);
    let sums = pairs.iter().fold([0.0; 3], |[aa, bb, ab], (x, y)| {
        let (x, y) = (x - a, y - b);
        [aa + x * x, bb + y * y, ab + x * y]
    });
    let [aa, bb, ab] = sums;
    if aa * bb > 1e-12 {
        ab / (aa * bb).sqrt()
    } else {
        0.0
    }
}
