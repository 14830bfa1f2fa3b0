//! What of a program survives on silicon: its registers in the model of the real chip, beside the
//! same program in exact arithmetic, on random inputs.
//!
//! The difference of a register is parted by least squares:
//!
//! ```text
//! silicon = offset + gain · exact + noise
//! ```
//!
//! A constant offset does not count, since programs that look at changes do not see it. The noise
//! is what is left: differences between pixels, noise of stores, saturation. The correlation is
//! that of both pictures, `sign(gain) · sqrt(1 - noise² / var(silicon))`.

use super::{
    Arithmetic, CodeError, Register, RunError, Settings, ShapeError,
    range::{Inputs, Interval},
    symbolic::reach,
};
use crate::{
    event::Packet,
    isa::{Cell, Device},
    number::Format,
    plane::{Plane, Size},
    program::{CellEffect, Code},
    rng::{mix, uniform},
    unit::Micros,
};

/// Pixels along a side that are compared.
pub const SIDE: usize = 64;

/// How often.
pub const RUNS: u64 = 4;

/// The most columns and rows around them whose neighbours lie off the array.
const MARGIN: usize = 32;

/// A register on silicon beside its exact self.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Analogue {
    /// Of silicon and exact; none where one of them is the same everywhere.
    pub correlation: Option<f64>,
    /// What becomes of one LSB; none where the exact register is the same everywhere.
    pub gain: Option<f64>,
    /// What silicon holds where the exact register is 0, in LSB; with no gain, the mean difference.
    pub offset: f64,
    /// What of silicon follows the exact register, in LSB (standard deviation).
    pub signal: f64,
    /// What is left, in LSB (standard deviation).
    pub noise: f64,
}

/// What of a register survives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Survival {
    /// A register in LSB.
    Analogue(Analogue),
    /// A register of bits: the share of pixels in which it is the same.
    Bits(f64),
}

/// A program that does not run.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error(transparent)]
#[diagnostic(transparent)]
pub enum SurvivalError {
    /// It does not fit on the array.
    Code(#[from] CodeError),
    /// A domain has no answer.
    Run(#[from] RunError),
    /// A plane of another size than the array.
    Shape(#[from] ShapeError),
}

/// Runs a program on `silicon` with this seed and in exact arithmetic, on inputs that are uniform
/// within their intervals and other in every pixel, and compares `cells` after each of
/// [`RUNS`] frames.
///
/// Light is an input, and so is each register that a frame reads and nothing has written before:
/// all that bare statements read. The pixels that are compared are [`SIDE`] by [`SIDE`]; around
/// them lie as many as the program reaches, 32 at most.
///
/// # Errors
/// When the program does not run.
pub fn survival(
    code: &Code,
    bare: bool,
    device: &Device,
    settings: Settings,
    inputs: Inputs,
    seed: u64,
    cells: &[Cell],
) -> Result<Vec<Survival>, SurvivalError> {
    let (rows, columns) = reach(&code.frame, device);
    let margin = rows.max(columns).min(MARGIN);
    let size = Size::new(SIDE + 2 * margin, SIDE + 2 * margin);
    let chip = |arithmetic: Arithmetic| arithmetic.chip("survival", code, device, size, settings);
    let mut exact = chip(Arithmetic::Number(Format::F64))?;
    let mut silicon = chip(Arithmetic::Silicon { seed })?;
    let mut set: Vec<Cell> = CellEffect::of(&code.frame, device)
        .reads
        .into_iter()
        .collect();
    if !bare {
        let mut written = CellEffect::of(&code.init, device).writes;
        written.extend(CellEffect::of(&code.frame, device).writes);
        set.retain(|cell| !written.contains(cell));
    }
    let mut sums = vec![Sums::default(); cells.len()];
    for run in 0..=RUNS {
        // The first light is that of `init`, which a program without it does not need.
        let is_init = run == 0;
        if is_init && bare {
            continue;
        }
        for chip in [&mut *exact, &mut *silicon] {
            let mut packet = Packet::new(size, chip.channels());
            chip.begin_frame();
            let light = random(inputs.light, (seed, run, u64::MAX), size);
            chip.expose(&light)?;
            for cell in &set {
                if let Cell::Analog(register) = cell {
                    let draw = (seed, run, u64::from(register.0));
                    chip.set_analog(*register, &random(inputs.registers, draw, size))?;
                }
            }
            if is_init {
                chip.run_init(Micros(0), &mut packet)?;
            } else {
                chip.run_frame(Micros(run), &mut packet)?;
            }
        }
        if is_init {
            continue;
        }
        for (sums, cell) in sums.iter_mut().zip(cells) {
            let register = Register::from(*cell);
            let (a, b) = (register.values(&*exact), register.values(&*silicon));
            for y in margin..margin + SIDE {
                for x in margin..margin + SIDE {
                    sums.add(a[(y, x)], b[(y, x)]);
                }
            }
        }
    }
    let of = |(sums, cell): (&Sums, &Cell)| match cell {
        Cell::Analog(_) => Survival::Analogue(sums.analogue()),
        Cell::Digital(_) | Cell::Flag => Survival::Bits(sums.same / sums.n),
    };
    Ok(sums.iter().zip(cells).map(of).collect())
}

fn random(within: Interval, (seed, run, input): (u64, u64, u64), size: Size) -> Plane<f64> {
    let reason = mix(mix(mix(seed) ^ run) ^ input);
    Plane::from_shape_fn(size.shape(), |(y, x)| {
        let place = (y * size.width + x) as u64;
        within.low + (within.high - within.low) * uniform(mix(reason ^ mix(place)))
    })
}

/// What both pictures are judged by.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    n: f64,
    a: f64,
    b: f64,
    aa: f64,
    bb: f64,
    ab: f64,
    same: f64,
}

impl Sums {
    fn add(&mut self, a: f64, b: f64) {
        self.n += 1.0;
        self.a += a;
        self.b += b;
        self.aa += a * a;
        self.bb += b * b;
        self.ab += a * b;
        self.same += f64::from(u8::from(a == b));
    }

    fn analogue(&self) -> Analogue {
        let Self {
            n,
            a,
            b,
            aa,
            bb,
            ab,
            ..
        } = *self;
        // What cancels in the differences leaves rounding errors of this size.
        let varies = |square: f64, sum: f64| {
            let variance = square / n - (sum / n) * (sum / n);
            (variance > 1e-12 * (square / n)).then_some(variance)
        };
        let (va, vb) = (varies(aa, a), varies(bb, b));
        let covariance = ab / n - (a / n) * (b / n);
        let Some(va) = va else {
            return Analogue {
                correlation: None,
                gain: None,
                offset: (b - a) / n,
                signal: 0.0,
                noise: vb.unwrap_or(0.0).sqrt(),
            };
        };
        let gain = covariance / va;
        let vb = vb.unwrap_or(0.0);
        Analogue {
            correlation: (vb > 0.0).then(|| covariance / (va * vb).sqrt()),
            gain: Some(gain),
            offset: b / n - gain * (a / n),
            signal: gain.abs() * va.sqrt(),
            noise: (vb - gain * covariance).max(0.0).sqrt(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_found_and_the_rest_is_noise() {
        let mut sums = Sums::default();
        for (a, error) in [(0.0, 1.0), (0.0, -1.0), (10.0, 1.0), (10.0, -1.0)] {
            sums.add(a, 3.0 - 2.0 * a + error);
        }
        let found = sums.analogue();
        assert_eq!(
            (found.gain, found.offset, found.signal, found.noise),
            (Some(-2.0), 3.0, 10.0, 1.0)
        );
        let expected = -(100.0f64 / 101.0).sqrt();
        assert!((found.correlation.unwrap() - expected).abs() < 1e-12);
    }

    #[test]
    fn what_never_changes_has_no_correlation() {
        let mut sums = Sums::default();
        for b in [4.0, 6.0] {
            sums.add(1.0, b);
        }
        let found = sums.analogue();
        assert_eq!((found.correlation, found.gain), (None, None));
        assert_eq!((found.offset, found.noise), (4.0, 1.0));
    }
}
