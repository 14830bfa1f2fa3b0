//! A uniform resistive grid in time, exactly: each cosine mode relaxes on its own.
//!
//! A mode of eigenvalue `μ` obeys `dH/dt = a (s P - H)` with `s = 1 / (1 + λ² μ)` and
//! `a = 1 / (τ s)`. Over a time `t` in which its `P` is a straight line from `P0` to `P1`,
//! with `z = a t`, `E = exp(-z)` and `φ = (1 - E) / z`,
//!
//! ```text
//! H1 = E H0 + s (φ - E) P0 + s (1 - φ) P1            (a ramp)
//! H1 = E H0 + s (1 - E) P1                           (a step to P1 at the beginning)
//! ```
//!
//! No step is too long, none is too stiff, and two half steps are one whole step. A sheet starts
//! settled, so that a still scene is still from the first frame on.
//!
//! Noise of the resistors is exact too. In equilibrium every node has the variance `kT/C` and
//! knows nothing of its neighbours, whatever the resistors are (equipartition); the modes are
//! orthogonal, so each has that variance as well, and forgets as fast as it relaxes:
//! `n1 = E n0 + sqrt(1 - E²) sqrt(kT/C) ξ`.

use std::fmt;

use multiversion::multiversion;

use super::{
    Float, MeshError, Sheet,
    cosine::{COLUMNS, Cosine},
    reason::{Reason, normal},
    sheet::eigenvalues,
    signal::{check_next, check_time, checked_range},
};
use crate::{
    config::listed,
    elementary,
    plane::{Plane, Size},
};

listed! {
/// What the signal does between two frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Between {
    /// A straight line from the earlier frame to the later.
    #[default]
    Ramp = "ramp",
    /// A step to the later frame, right after the earlier.
    Step = "step",
}
}

impl fmt::Display for Between {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.word())
    }
}

/// A sheet in time: its state as the modes of signal and surround.
#[derive(Clone, Debug)]
pub struct Flow<T: Float = f64> {
    sheet: Sheet,
    tau: f64,
    modes: Modes<T>,
    /// The level subtracted from all signals, so that rounding errors scale with contrast.
    off: T,
    /// Modes of the last signal, and of the surround.
    signal: Vec<T>,
    state: Vec<T>,
    surround: Plane<T>,
    step: Option<Step<T>>,
    noise: Option<Noise>,
}

/// What an interval does to each mode.
#[derive(Clone, Debug)]
struct Step<T> {
    seconds: f64,
    between: Between,
    /// Per mode: the decay factor `E`, and the shares of the earlier and the later signal.
    left: Vec<T>,
    earlier: Vec<T>,
    later: Vec<T>,
}

/// Thermal noise of the resistors.
#[derive(Clone, Copy, Debug)]
struct Noise {
    /// `sqrt(kT/C)`, in the signal's unit.
    sigma: f64,
    seed: u64,
    step: u64,
}

/// Intervals whose lengths differ by less than this part share their exponentials: times that are
/// computed from the number of a frame differ in their last digits.
const SAME: f64 = 1e-9;

impl<T: Float> Flow<T> {
    /// A sheet with time constant `tau` (in seconds; 0 settles at once), settled to `signal`.
    ///
    /// # Errors
    /// When `tau` is not a time, or the signal cannot be solved for.
    pub fn settled(sheet: Sheet, tau: f64, signal: &Plane<T>) -> Result<Self, MeshError> {
        check_time("time constant", tau)?;
        let size = Size::of(signal);
        if size.pixels() == 0 {
            return Err(MeshError::Empty { size });
        }
        let (lambda_y, lambda_x) = sheet.lambdas();
        let value = lambda_y.max(lambda_x);
        if value > T::MOST_LAMBDA {
            let most = T::MOST_LAMBDA;
            return Err(MeshError::Lambda { value, most });
        }
        let (low, high) = checked_range(signal)?;
        let off = low + (high - low) * T::nearest(0.5);
        let mut modes = Modes::new(size);
        let mut of_signal = vec![T::nearest(0.0); size.pixels()];
        modes.forward(signal, off, &mut of_signal);
        let gains = gains(sheet, size);
        let state = of_signal.iter().zip(gains).map(|(p, s)| *p * T::nearest(s));
        let mut flow = Self {
            sheet,
            tau,
            modes,
            off,
            state: state.collect(),
            signal: of_signal,
            surround: Plane::from_elem(size.shape(), off),
            step: None,
            noise: None,
        };
        flow.show();
        Ok(flow)
    }

    /// The same sheet with the noise of its resistors: `sigma` is `sqrt(kT/C)` in the signal's
    /// unit. The noise starts in equilibrium.
    #[must_use]
    pub fn with_noise(mut self, sigma: f64, seed: u64) -> Self {
        let noise = Noise {
            sigma,
            seed,
            step: 0,
        };
        self.noise = Some(noise);
        let size = Size::of(&self.surround);
        for (place, (state, norm)) in self.state.iter_mut().zip(norms(size)).enumerate() {
            let drawn = sigma * norm * normal(seed, Reason::Thermal, place, 0);
            *state = *state + T::nearest(drawn);
        }
        self.show();
        self
    }

    /// The surround `H`, `[y, x]`, in the signal's unit.
    #[must_use]
    pub const fn surround(&self) -> &Plane<T> {
        &self.surround
    }

    /// The time constant, in seconds.
    #[must_use]
    pub const fn tau(&self) -> f64 {
        self.tau
    }

    /// Advances by `seconds`, at the end of which the signal is `signal`.
    ///
    /// # Errors
    /// When the time is none, or the signal has another size or a pixel that is no number; the
    /// sheet is then as it was.
    pub fn advance(
        &mut self,
        signal: &Plane<T>,
        seconds: f64,
        between: Between,
    ) -> Result<(), MeshError> {
        let size = Size::of(&self.surround);
        check_next(signal, size, seconds)?;
        let same = |step: &Step<T>| {
            step.between == between && (step.seconds - seconds).abs() <= SAME * seconds
        };
        let step = match self.step.take() {
            Some(step) if same(&step) => step,
            _ => Step::new(self.sheet, self.tau, size, seconds, between),
        };
        relax(&mut self.state, &self.signal, &step.left, &step.earlier);
        self.modes.forward(signal, self.off, &mut self.signal);
        add(&mut self.state, &self.signal, &step.later);
        if let Some(noise) = &mut self.noise {
            noise.step += 1;
            let each = self.state.iter_mut().zip(&step.left).zip(norms(size));
            for (place, ((state, left), norm)) in each.enumerate() {
                let left = left.to_f64();
                let fresh = ((1.0 - left) * (1.0 + left)).sqrt();
                let drawn = normal(noise.seed, Reason::Thermal, place, noise.step);
                *state = *state + T::nearest(noise.sigma * norm * fresh * drawn);
            }
        }
        self.step = Some(step);
        self.show();
        Ok(())
    }

    /// Computes the surround from its modes.
    fn show(&mut self) {
        self.modes
            .inverse(&self.state, self.off, &mut self.surround);
    }
}

impl<T: Float> Step<T> {
    fn new(sheet: Sheet, tau: f64, size: Size, seconds: f64, between: Between) -> Self {
        let count = size.pixels();
        let mut step = Self {
            seconds,
            between,
            left: Vec::with_capacity(count),
            earlier: Vec::with_capacity(count),
            later: Vec::with_capacity(count),
        };
        for s in gains(sheet, size) {
            let z = if tau > 0.0 {
                seconds / (tau * s)
            } else {
                f64::INFINITY
            };
            let (left, earlier, later) = parts(z, between);
            step.left.push(T::nearest(left));
            step.earlier.push(T::nearest(s * earlier));
            step.later.push(T::nearest(s * later));
        }
        step
    }
}

/// `E`, and the shares of the earlier and the later signal: the module head's equations over `s`.
fn parts(z: f64, between: Between) -> (f64, f64, f64) {
    let left = elementary::exp(-z);
    match between {
        Between::Step => (left, 0.0, -elementary::exp_m1(-z)),
        Between::Ramp if z > 0.5 => {
            let mean = -elementary::exp_m1(-z) / z;
            (left, mean - left, 1.0 - mean)
        }
        // The differences would cancel: their series in z.
        Between::Ramp => {
            let (mut earlier, mut later, mut term) = (0.0, 0.0, 1.0);
            for n in 1..18 {
                let n = f64::from(n);
                // (-1)^(n+1) z^n / (n+1)!
                term *= if n > 1.0 { -z } else { z } / (n + 1.0);
                later += term;
                earlier += n * term;
            }
            (left, earlier, later)
        }
    }
}

/// `1 / (1 + λ² μ)` of each mode, in the order of [`Modes`].
fn gains(sheet: Sheet, size: Size) -> impl Iterator<Item = f64> {
    let (lambda_y, lambda_x) = sheet.lambdas();
    let down: Vec<f64> = eigenvalues(size.height)
        .map(|mu| lambda_y * lambda_y * mu)
        .collect();
    eigenvalues(size.width).flat_map(move |mu| {
        let across = 1.0 + lambda_x * lambda_x * mu;
        down.clone()
            .into_iter()
            .map(move |down| 1.0 / (across + down))
    })
}

/// The standard deviation of each mode when every node has noise of unit variance, in the order of
/// [`Modes`].
fn norms(size: Size) -> impl Iterator<Item = f64> {
    let norm = |k: usize, n: usize| (n as f64 / if k == 0 { 1.0 } else { 2.0 }).sqrt();
    let Size { height, width } = size;
    (0..width).flat_map(move |kx| (0..height).map(move |ky| norm(kx, width) * norm(ky, height)))
}

/// The two-dimensional cosine transform. Modes lie column by column: those of one `kx` together.
#[derive(Clone, Debug)]
struct Modes<T: Float> {
    size: Size,
    across: Cosine<T>,
    down: Cosine<T>,
    plane: Vec<T>,
    spare: Vec<T>,
}

impl<T: Float> Modes<T> {
    fn new(size: Size) -> Self {
        let zero = T::nearest(0.0);
        Self {
            size,
            across: Cosine::new(size.width),
            down: Cosine::new(size.height),
            plane: vec![zero; size.pixels()],
            spare: vec![zero; size.width],
        }
    }

    fn forward(&mut self, plane: &Plane<T>, off: T, modes: &mut [T]) {
        let Size { height, width } = self.size;
        match plane.as_slice() {
            Some(values) => self.plane.copy_from_slice(values),
            None => {
                for (to, from) in self.plane.iter_mut().zip(plane) {
                    *to = *from;
                }
            }
        }
        for rows in self.plane.chunks_mut(2 * width) {
            let (a, b) = rows.split_at_mut(width);
            self.spare.fill(off);
            let b = if b.is_empty() { &mut self.spare } else { b };
            self.across.forward(a, b, off);
        }
        for (block, modes) in modes.chunks_mut(COLUMNS * height).enumerate() {
            let columns = (&self.plane[..], width, COLUMNS * block);
            self.down.forward_columns(columns, T::nearest(0.0), modes);
        }
    }

    fn inverse(&mut self, modes: &[T], off: T, plane: &mut Plane<T>) {
        let Size { height, width } = self.size;
        let Some(values) = plane.as_slice_mut() else {
            return;
        };
        for (block, modes) in modes.chunks(COLUMNS * height).enumerate() {
            let columns = (&mut *values, width, COLUMNS * block);
            self.down.inverse_columns(modes, columns, |value| value);
        }
        for rows in values.chunks_mut(2 * width) {
            let (a, b) = rows.split_at_mut(width);
            self.spare.fill(T::nearest(0.0));
            let b = if b.is_empty() { &mut self.spare } else { b };
            self.across.inverse(a, b);
            for value in rows {
                *value = *value + off;
            }
        }
    }
}

/// `H := E H + c P`.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn relax<T: Float>(state: &mut [T], signal: &[T], left: &[T], share: &[T]) {
    for (((h, p), left), share) in state.iter_mut().zip(signal).zip(left).zip(share) {
        *h = *left * *h + *share * *p;
    }
}

/// `H := H + c P`.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn add<T: Float>(state: &mut [T], signal: &[T], share: &[T]) {
    for ((h, p), share) in state.iter_mut().zip(signal).zip(share) {
        *h = *h + *share * *p;
    }
}
