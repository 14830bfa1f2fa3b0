//! What comes out of the silicon: the predicted correlation of a filter's result with the exact
//! one, and the noise in it.
//!
//! The chip stores `cell := clip(-(1 - loss + m_g) · share · sum + Δ + m_o + noise)`
//! (`isa/errors.rs`). For an input that is independent from pixel to pixel and uniform in
//! `mean ± amplitude`, two passes over the straight-line words give what that does to a result:
//!
//! - **forwards**, every register as `constant + Σ coefficient · input(p + d)`: the constant piles
//!   up transfer errors, the coefficients lose `loss` a store;
//! - **backwards** (the adjoint), what a deviation of each store becomes in the result: a field of
//!   weights `G` over places. Temporal noise of a store adds `noise² · |G|²`. Fixed-pattern
//!   mismatch belongs to a cell, so the stores of one register are added before they are squared.
//!
//! **Clipping** is linearised after Bussgang: of a normally distributed sum the limited value is
//! `α` times the sum and a remainder that does not correlate with it; `α` is the probability of not
//! being limited, the remainder a noise source like the others. Where the largest possible sum
//! fits, nothing is limited.
//!
//! Left out: decay (a filter takes microseconds), the border, and products of deviations.

use crate::{
    compile::codegen::{
        bus_word::{Extent, Wired, wired},
        filter::Filter,
    },
    elementary::{exp, hypot},
    isa::{self, Analog, Device, Errors, Primitive, StoreTerms},
    kernel::Kernel,
    plane::Plane,
};

/// Inputs that a forecast is made for: independent and uniform in `mean ± amplitude`, LSB.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Signal {
    /// The middle, LSB.
    pub mean: f64,
    /// The farthest from it, LSB.
    pub amplitude: f64,
}

impl Signal {
    /// The amplitudes tried where no range of the input is given, LSB.
    pub const AMPLITUDES: [f64; 5] = [60.0, 20.0, 8.0, 3.0, 1.0];

    /// Around zero, as one amplitude.
    #[must_use]
    pub const fn around_zero(amplitude: f64) -> Self {
        Self {
            mean: 0.0,
            amplitude,
        }
    }

    /// From `low` to `high`, LSB.
    #[must_use]
    pub const fn from_range((low, high): (f64, f64)) -> Self {
        Self {
            mean: low / 2.0 + high / 2.0,
            amplitude: high / 2.0 - low / 2.0,
        }
    }
}

/// What is predicted of one result.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Forecast {
    /// The amplitude of the input that it is predicted for, LSB.
    pub amplitude: f64,
    /// Correlation with the exact filter over all pixels of a frame, its constant left out: 0 to 1.
    pub correlation: f64,
    /// Standard deviation of what belongs to the exact filter, LSB of the result.
    pub signal: f64,
    /// Standard deviation of what does not: noise, mismatch, what clipping adds, LSB.
    pub noise: f64,
    /// The part of `noise` that is drawn anew in every frame, LSB.
    pub temporal: f64,
    /// The mean of the result for an input around `mean`, less the exact filter's, LSB.
    pub offset: f64,
}

impl Forecast {
    /// Below this correlation nothing comes out.
    pub const NOTHING: f64 = 0.02;

    /// Below this correlation more noise comes out than signal.
    pub const NOISE: f64 = std::f64::consts::FRAC_1_SQRT_2;

    /// Takes the constant for noise: the correlation becomes that of values round zero.
    pub(super) fn count_offset(&mut self) {
        let all = hypot(hypot(self.signal, self.noise), self.offset);
        if all > 0.0 {
            self.correlation = self.correlation.signum() * self.signal / all;
        }
    }

    /// Signal over noise, in decibels.
    #[must_use]
    pub fn snr_db(&self) -> f64 {
        self.snr_db_without(0.0)
    }

    /// The same where in a part of the cells nothing of the signal is right.
    pub(super) fn snr_db_without(&self, lost: f64) -> f64 {
        let squared = self.correlation * self.correlation * (1.0 - lost);
        10.0 * crate::elementary::log10(squared.max(1e-12) / (1.0 - squared).max(1e-12))
    }
}

/// Weights over the places round a pixel: a square of odd side, row by row, of which only the places
/// from the first weight to the last are held.
#[derive(Clone, Debug)]
struct Field {
    reach: i32,
    /// The place of the first of `weights`.
    first: usize,
    weights: Vec<f64>,
}

impl Field {
    const fn new(reach: i32) -> Self {
        Self {
            reach,
            first: 0,
            weights: Vec::new(),
        }
    }

    /// One at the pixel itself.
    fn one(reach: i32) -> Self {
        let mut field = Self::new(reach);
        let middle = field.at((0, 0));
        field.hold(middle, 1)[0] = 1.0;
        field
    }

    fn at(&self, (y, x): (i32, i32)) -> usize {
        ((y + self.reach) * (2 * self.reach + 1) + x + self.reach) as usize
    }

    /// So many places from one on, held from now on.
    fn hold(&mut self, from: usize, count: usize) -> &mut [f64] {
        if self.weights.is_empty() {
            self.first = from;
        }
        if let Some(before) = self.first.checked_sub(from) {
            self.weights.splice(0..0, std::iter::repeat_n(0.0, before));
            self.first = from;
        }
        let at = from - self.first;
        if self.weights.len() < at + count {
            self.weights.resize(at + count, 0.0);
        }
        &mut self.weights[at..at + count]
    }

    /// Adds `times` the other, moved by one place or none. Nothing lies at the rim: the square is
    /// wider than the words reach.
    fn add(&mut self, other: &Self, place: (i32, i32), times: f64) {
        if times == 0.0 || other.weights.is_empty() {
            return;
        }
        let by = place.0 * (2 * self.reach + 1) + place.1;
        let from = other.first.saturating_add_signed(by as isize);
        let cells = self.hold(from, other.weights.len()).iter_mut();
        for (cell, weight) in cells.zip(&other.weights) {
            *cell += times * weight;
        }
    }

    /// The sum of the products with another.
    fn dot(&self, other: &Self) -> f64 {
        let from = self.first.max(other.first);
        let of = |field: &Self| from - field.first;
        let (own, other) = (
            self.weights.iter().skip(of(self)),
            other.weights.iter().skip(of(other)),
        );
        own.zip(other).map(|(a, b)| a * b).sum()
    }

    fn power(&self) -> f64 {
        self.weights.iter().map(|w| w * w).sum()
    }

    fn magnitude(&self) -> f64 {
        self.weights.iter().map(|w| w.abs()).sum()
    }
}

/// What one target of a word stored.
#[derive(Clone, Copy, Debug)]
struct Stored {
    cell: usize,
    place: (i32, i32),
    /// The constant on the bus, as this target gets it.
    current: f64,
    /// Variance of the signal on the bus, likewise.
    variance: f64,
    /// The share of the sum that is not limited (Bussgang's gain).
    kept: f64,
    /// Variance of what limiting adds.
    distortion: f64,
}

/// How far from its pixel the inputs lie that a register may hold. The fields hold twice that,
/// since a value may first be moved away and then back.
fn reach(words: &[Wired], cells: usize) -> i32 {
    // A constant counts as an input.
    let mut held = vec![Extent::default(); cells];
    let mut most = 0;
    for word in words {
        let own = { word.sources.iter() }.map(|(cell, at)| held[*cell].moved(*at));
        let own = own.reduce(Extent::joined).unwrap_or_default();
        for (cell, at) in &word.targets {
            held[*cell] = own.moved((-at.0, -at.1));
            most = most.max(held[*cell].farthest());
        }
    }
    most
}

/// The forecasts of the results of straight bus words.
pub(super) fn forecasts(
    words: &[Primitive],
    device: &Device,
    (input, results): (Analog, &[Analog]),
    kernels: &[Kernel],
    signal: Signal,
) -> Vec<Forecast> {
    let errors = Errors::from_device(device);
    let slope = -errors.gain(0.0);
    let cells = device.registers().analog.len();
    let words = wired(words, device);
    let kernel_reach = kernels.iter().map(|k| k.reach().0.max(k.reach().1));
    let half = reach(&words, cells).max(kernel_reach.max().unwrap_or(0) as i32);
    let wide = 2 * half + 1;
    let variance = signal.amplitude * signal.amplitude / 3.0;
    // Forwards.
    let mut forms = vec![Field::new(wide); cells];
    let mut levels = vec![0.0; cells];
    let start = usize::from(input.0);
    forms[start] = Field::one(wide);
    levels[start] = signal.mean;
    let mut stores: Vec<Vec<Stored>> = Vec::with_capacity(words.len());
    for word in &words {
        let mut bus = Field::new(wide);
        let mut level = 0.0;
        for (cell, place) in &word.sources {
            bus.add(&forms[*cell], *place, 1.0);
            level += levels[*cell];
        }
        let count = word.targets.len() as f64;
        let spread = (bus.power() * variance).sqrt() / count;
        let most = bus.magnitude() * signal.amplitude / count;
        let splits = word.targets.len() > 1;
        let current = level / count;
        let added = isa::added(errors.transfer, errors.division, splits);
        let mean = isa::stored(current, -slope, added);
        let clipped = limited(mean, slope * spread, slope * most, errors.range);
        let mut own = Vec::with_capacity(word.targets.len());
        for (cell, place) in &word.targets {
            let mut form = Field::new(wide);
            let opposite = (-place.0, -place.1);
            form.add(&bus, opposite, -slope * clipped.kept / count);
            forms[*cell] = form;
            levels[*cell] = clipped.mean;
            own.push(Stored {
                cell: *cell,
                place: *place,
                current,
                variance: spread * spread,
                kept: clipped.kept,
                distortion: clipped.distortion,
            });
        }
        stores.push(own);
    }
    let backwards = Backwards {
        errors,
        words: &words,
        stores: &stores,
        wide,
        cells,
    };
    let one = |(result, kernel): (&Analog, &Kernel)| {
        let cell = usize::from(result.0);
        let (temporal, other) = backwards.variances(cell);
        let exact = exact(kernel, wide);
        let form = &forms[cell];
        let own = form.power() * variance;
        let both = exact.dot(form);
        let size = exact.power();
        let aligned = if size > 0.0 {
            both * both / size * variance
        } else {
            0.0
        };
        let all = own + temporal + other;
        Forecast {
            amplitude: signal.amplitude,
            correlation: if all > 0.0 {
                (aligned / all).sqrt() * both.signum().max(0.0)
            } else {
                0.0
            },
            signal: aligned.sqrt(),
            noise: (all - aligned).max(0.0).sqrt(),
            temporal: temporal.sqrt(),
            offset: levels[cell] - signal.mean * form.weights.iter().sum::<f64>(),
        }
    };
    results.iter().zip(kernels).map(one).collect()
}

/// A kernel as a field.
fn exact(kernel: &Kernel, wide: i32) -> Field {
    let mut field = Field::new(wide);
    let (rows, columns) = kernel.reach();
    let weights: &Plane<f64> = kernel.weights();
    for ((y, x), weight) in weights.indexed_iter() {
        let at = field.at((y as i32 - rows as i32, x as i32 - columns as i32));
        field.hold(at, 1)[0] = *weight;
    }
    field
}

/// The pass from a result back to the input.
struct Backwards<'a> {
    errors: Errors,
    words: &'a [Wired],
    stores: &'a [Vec<Stored>],
    /// The reach of its fields.
    wide: i32,
    cells: usize,
}

impl Backwards<'_> {
    /// The variance of the temporal noise in a result, and of all else that is no signal.
    fn variances(&self, result: usize) -> (f64, f64) {
        let errors = self.errors;
        let StoreTerms {
            gain_mismatch,
            offset_mismatch,
            division_mismatch,
            noise,
            // In `Errors::of_gain` and `Errors::apart`.
            mismatch_correlation: _,
            // In the slope and in the forward pass.
            loss: _,
            transfer: _,
            division: _,
        } = errors.of_a_store();
        let mut adjoint: Vec<Option<Field>> = vec![None; self.cells];
        adjoint[result] = Some(Field::one(self.wide));
        let (mut temporal, mut other) = (0.0, 0.0);
        let mut gains = vec![Field::new(self.wide); self.cells];
        let mut offsets = vec![Field::new(self.wide); self.cells];
        let targets = self.stores.iter().map(Vec::len).max();
        let mut splits = vec![Field::new(self.wide); targets.unwrap_or(0).saturating_sub(1)];
        let (slope, apart) = (-errors.gain(0.0), errors.apart());
        for (word, stores) in self.words.iter().zip(self.stores).rev() {
            let mut bus = Field::new(self.wide);
            let count = stores.len() as f64;
            let mut moving = 0.0;
            let mut uneven = vec![Field::new(self.wide); stores.len().saturating_sub(1)];
            let taken: Vec<_> = stores.iter().map(|s| adjoint[s.cell].take()).collect();
            let mut read = false;
            for (part, (stored, field)) in stores.iter().zip(taken).enumerate() {
                let Some(field) = field else { continue };
                read = true;
                let power = field.power();
                let kept = stored.kept;
                temporal += kept * kept * noise * noise * power;
                let gain = gain_mismatch;
                other += (kept * kept * gain * gain * stored.variance + stored.distortion) * power;
                let own = errors.of_gain(stored.current);
                gains[stored.cell].add(&field, (0, 0), kept * own);
                offsets[stored.cell].add(&field, (0, 0), kept * offset_mismatch * apart);
                // The target's cell lies a step from the pixel whose bus it stored.
                let back = (-stored.place.0, -stored.place.1);
                bus.add(&field, back, -slope * kept / count);
                moving = stored.variance;
                for (k, uneven) in uneven.iter_mut().enumerate() {
                    let more = f64::from(isa::uneven(part, stores.len(), k));
                    uneven.add(&field, back, -slope * kept * division_mismatch * more);
                }
            }
            if !read {
                continue;
            }
            for (k, uneven) in uneven.iter().enumerate() {
                other += moving * uneven.power();
                if let (Some(sum), Some(stored)) = (splits.get_mut(k), stores.first()) {
                    sum.add(uneven, (0, 0), stored.current);
                }
            }
            for (cell, place) in &word.sources {
                adjoint[*cell]
                    .get_or_insert_with(|| Field::new(self.wide))
                    .add(&bus, *place, 1.0);
            }
        }
        for field in gains.iter().chain(&offsets).chain(&splits) {
            other += field.power();
        }
        (temporal, other)
    }
}

/// What is left of a sum that is limited.
struct Limited {
    mean: f64,
    kept: f64,
    distortion: f64,
}

/// Of a normal distribution, limited to a range; `most`: how far from the mean it comes at all.
fn limited(mean: f64, spread: f64, most: f64, (low, high): (f64, f64)) -> Limited {
    if mean - most >= low && mean + most <= high || spread <= 0.0 {
        return Limited {
            mean: mean.clamp(low, high),
            // What lies beyond the range by itself does not move.
            kept: f64::from(u8::from(mean >= low && mean <= high)),
            distortion: 0.0,
        };
    }
    let (from, to) = ((low - mean) / spread, (high - mean) / spread);
    let below = |z: f64| 0.5 * libm::erfc(-z / std::f64::consts::SQRT_2);
    let density = |z: f64| exp(-z * z / 2.0) / (2.0 * std::f64::consts::PI).sqrt();
    let (under, over) = (below(from), below(-to));
    let kept = (1.0 - under - over).max(0.0);
    let inner = spread * (density(from) - density(to));
    let shift = (low - mean) * under + (high - mean) * over + inner;
    let squares = (low - mean) * (low - mean) * under
        + (high - mean) * (high - mean) * over
        + spread * spread * (kept + from * density(from) - to * density(to));
    let variance = (squares - shift * shift).max(0.0);
    Limited {
        mean: mean + shift,
        kept,
        distortion: (variance - kept * kept * spread * spread).max(0.0),
    }
}

impl Filter {
    /// What is predicted to come out of the chip, for each result.
    #[must_use]
    pub fn forecast(&self, device: &Device, kernels: &[Kernel], signal: Signal) -> Vec<Forecast> {
        let registers = (self.input, &self.results[..]);
        forecasts(&self.words, device, registers, kernels, signal)
    }

    /// The same at the amplitude of [`Signal::AMPLITUDES`] at which the worst result is best.
    #[must_use]
    pub fn best_forecast(&self, device: &Device, kernels: &[Kernel]) -> Vec<Forecast> {
        best(|signal| self.forecast(device, kernels, signal))
    }

    /// The signal of [`best_forecast`](Self::best_forecast).
    #[must_use]
    pub fn best_signal(&self, device: &Device, kernels: &[Kernel]) -> Signal {
        let best = self.best_forecast(device, kernels);
        Signal::around_zero(best.first().map_or(1.0, |it| it.amplitude))
    }
}

/// The forecasts at the amplitude of [`Signal::AMPLITUDES`] at which the worst of them is best.
pub(super) fn best(at: impl Fn(Signal) -> Vec<Forecast>) -> Vec<Forecast> {
    let tried = Signal::AMPLITUDES.map(|amplitude| at(Signal::around_zero(amplitude)));
    let best = { tried.into_iter() }.max_by(|a, b| worst(a).total_cmp(&worst(b)));
    best.unwrap_or_default()
}

/// The least correlation of several results; 1 without any.
pub(super) fn worst(forecasts: &[Forecast]) -> f64 {
    forecasts.iter().map(|f| f.correlation).fold(1.0, f64::min)
}
