//! A resistive grid as silicon has it: parts that differ, and laterals that may be transistors.
//!
//! ```text
//! C(i) dH(i)/dt = g(i) (P(i) - H(i)) + sum over neighbours j of G(ij) f(H(j) - H(i))
//!
//! f(v) = v                 polysilicon
//! f(v) = V tanh(v / V)     a resistor that saturates (Mead's horizontal resistor)
//! f(v) = V sinh(v / V)     a pseudo-resistor, which opens up
//! ```
//!
//! The settled state of a linear network is found by preconditioned conjugate gradients. The
//! preconditioner is the exact solver of the nearest sheet of equal parts ([`Steady`]), so that the
//! number of steps depends on the spread of the parts, not on size or space constant. With
//! nonlinear laterals the settled state minimises the co-content `sum g (P - H)² / 2 + sum G F(v)`,
//! `F' = f` (Millar 1951), which is convex; damped Newton steps find the minimum. Both estimate
//! their error, and refuse to answer where it is too large.

use super::{
    MeshError, Sheet, Steady,
    reason::{Reason, normal},
    signal::checked_range,
};
use crate::{
    elementary,
    plane::{Plane, Size},
};

/// A grid of parts that differ. Conductances and capacitances are in any consistent units: siemens,
/// farads and seconds, or relative to the nominal ones and to τ.
#[derive(Clone, Debug, PartialEq)]
pub struct Network {
    pub(super) size: Size,
    /// Transverse conductances, from each node to its signal.
    pub(super) transverse: Vec<f64>,
    /// Conductances from each node to the one below; 0 in the last row.
    pub(super) down: Vec<f64>,
    /// Conductances from each node to the one on the right; 0 in the last column.
    pub(super) across: Vec<f64>,
    /// Capacitances from each node to ground.
    pub(super) capacitance: Vec<f64>,
    laterals: Laterals,
}

/// The current law of the lateral resistors, in the signal's unit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Laterals {
    /// A resistor.
    #[default]
    Linear,
    /// `V tanh(v / V)`: the current stops growing at differences beyond `V`.
    Saturating {
        /// The difference `V` at which it saturates, in the signal's unit.
        scale: f64,
    },
    /// `V sinh(v / V)`: the current runs away at differences beyond `V`.
    Opening {
        /// The difference `V` beyond which it opens, in the signal's unit.
        scale: f64,
    },
}

/// Mismatch of the parts: the standard deviation of the logarithm of each kind of part. The nominal
/// value is the median.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Mismatch {
    /// Lateral resistors.
    pub lateral: f64,
    /// Transverse conductances.
    pub transverse: f64,
    /// Capacitors.
    pub capacitance: f64,
}

/// A settled state.
#[derive(Clone, Debug, PartialEq)]
pub struct Settled {
    /// The surround `H`, `[y, x]`, in the signal's unit.
    pub surround: Plane<f64>,
    /// Steps of conjugate gradients in all.
    pub iterations: usize,
    /// Newton steps; 0 with linear laterals.
    pub newton: usize,
    /// Bound on a node's error, estimated from the residual currents, in the signal's unit.
    pub error: f64,
}

/// A state whose error is a larger part of the signal's range is refused.
const MOST_ERROR: f64 = 1e-10;
const MOST_NEWTON: usize = 300;
const MOST_STEPS: usize = 4000;

impl Network {
    /// A network from its parts: conductances to the signals `(H, W)`, to the neighbours below
    /// `(H-1, W)` and on the right `(H, W-1)`, and capacitances `(H, W)`.
    ///
    /// # Errors
    /// When the shapes do not fit, a lateral is below 0 (0 is an open resistor), another part
    /// is not above 0, or one is no number.
    pub fn new(
        transverse: &Plane<f64>,
        down: &Plane<f64>,
        across: &Plane<f64>,
        capacitance: &Plane<f64>,
    ) -> Result<Self, MeshError> {
        let size = Size::of(transverse);
        if size.pixels() == 0 {
            return Err(MeshError::Empty { size });
        }
        let Size { height, width } = size;
        for (got, want) in [
            (Size::of(down), Size::new(height - 1, width)),
            (Size::of(across), Size::new(height, width - 1)),
            (Size::of(capacitance), size),
        ] {
            // An empty side has no shape of its own.
            if got != want && got.pixels() + want.pixels() > 0 {
                return Err(MeshError::Size { got, want });
            }
        }
        let kinds = [
            ("transverse conductance", transverse, f64::MIN_POSITIVE),
            ("lateral conductance downwards", down, 0.0),
            ("lateral conductance to the right", across, 0.0),
            ("capacitance", capacitance, f64::MIN_POSITIVE),
        ];
        for (what, plane, least) in kinds {
            let mut parts = plane.indexed_iter();
            let wrong = parts.find(|(_, value)| !(**value >= least && **value < f64::INFINITY));
            if let Some(((y, x), &value)) = wrong {
                return Err(MeshError::Part { what, y, x, value });
            }
        }
        let padded = |plane: &Plane<f64>| {
            let mut padded = Plane::zeros(size.shape());
            for (at, value) in plane.indexed_iter() {
                padded[at] = *value;
            }
            padded.into_raw_vec_and_offset().0
        };
        Ok(Self {
            size,
            transverse: padded(transverse),
            down: padded(down),
            across: padded(across),
            capacitance: padded(capacitance),
            laterals: Laterals::Linear,
        })
    }

    /// A sheet of equal parts: conductances relative to the transverse one, times to τ.
    ///
    /// # Errors
    /// When the size is empty.
    pub fn uniform(sheet: Sheet, size: Size) -> Result<Self, MeshError> {
        let (lambda_y, lambda_x) = sheet.lambdas();
        let Size { height, width } = size;
        let one = Plane::ones(size.shape());
        let down = Plane::from_elem((height.saturating_sub(1), width), lambda_y * lambda_y);
        let across = Plane::from_elem((height, width.saturating_sub(1)), lambda_x * lambda_x);
        Self::new(&one, &down, &across, &one)
    }

    /// The same network with log-normal mismatch drawn from `seed`, which stands for the chip.
    #[must_use]
    pub fn with_mismatch(mut self, mismatch: Mismatch, seed: u64) -> Self {
        let kinds = [
            (
                &mut self.transverse,
                Reason::Transverse,
                mismatch.transverse,
            ),
            (&mut self.down, Reason::LateralDown, mismatch.lateral),
            (&mut self.across, Reason::LateralAcross, mismatch.lateral),
            (
                &mut self.capacitance,
                Reason::Capacitor,
                mismatch.capacitance,
            ),
        ];
        for (parts, reason, sigma) in kinds {
            for (place, part) in parts.iter_mut().enumerate() {
                *part *= elementary::exp(sigma * normal(seed, reason, place, 0));
            }
        }
        self
    }

    /// The same network with other laterals.
    ///
    /// # Errors
    /// When the scale is not a number above 0.
    pub fn with_laterals(mut self, laterals: Laterals) -> Result<Self, MeshError> {
        if let Laterals::Saturating { scale } | Laterals::Opening { scale } = laterals
            && !(scale > 0.0 && scale.is_finite())
        {
            return Err(MeshError::Scale { value: scale });
        }
        self.laterals = laterals;
        Ok(self)
    }

    /// Conductances from each node to its signal, `[y, x]`.
    #[must_use]
    pub fn transverse(&self) -> Plane<f64> {
        self.plane(&self.transverse)
    }

    /// Conductances from each node to the one below (0 in the last row) and to the one on the
    /// right (0 in the last column), `[y, x]`.
    #[must_use]
    pub fn lateral(&self) -> (Plane<f64>, Plane<f64>) {
        (self.plane(&self.down), self.plane(&self.across))
    }

    /// Capacitances, `[y, x]`.
    #[must_use]
    pub fn capacitance(&self) -> Plane<f64> {
        self.plane(&self.capacitance)
    }

    /// Whether all laterals are linear.
    pub(super) fn is_linear(&self) -> bool {
        self.laterals == Laterals::Linear
    }

    pub(super) fn plane(&self, values: &[f64]) -> Plane<f64> {
        let Size { width, .. } = self.size;
        Plane::from_shape_fn(self.size.shape(), |(y, x)| values[y * width + x])
    }

    /// The current into each node, `[y, x]`: 0 where the network has settled.
    ///
    /// # Errors
    /// When a plane has another size, or a pixel that is no number.
    pub fn currents(
        &self,
        signal: &Plane<f64>,
        surround: &Plane<f64>,
    ) -> Result<Plane<f64>, MeshError> {
        let (signal, surround) = (self.values(signal)?, self.values(surround)?);
        Ok(self.plane(&self.at_nodes(&signal, &surround)))
    }

    /// The values of a plane of this size, row after row.
    pub(super) fn values(&self, plane: &Plane<f64>) -> Result<Vec<f64>, MeshError> {
        let (got, want) = (Size::of(plane), self.size);
        if got != want {
            return Err(MeshError::Size { got, want });
        }
        checked_range(plane)?;
        Ok(plane.iter().copied().collect())
    }

    fn at_nodes(&self, signal: &[f64], surround: &[f64]) -> Vec<f64> {
        let own = signal.iter().zip(surround).zip(&self.transverse);
        let mut currents: Vec<f64> = own.map(|((p, h), g)| g * (p - h)).collect();
        each_lateral(self.size, |i, j, way| {
            let conductance = self.conductances(way)[i];
            let current = conductance * self.laterals.current(surround[j] - surround[i]);
            currents[i] += current;
            currents[j] -= current;
        });
        currents
    }

    fn conductances(&self, way: Way) -> &[f64] {
        match way {
            Way::Down => &self.down,
            Way::Across => &self.across,
        }
    }

    /// The settled state for `signal`, `[y, x]`.
    ///
    /// # Errors
    /// When the signal has another size, a pixel is no number, or no answer is found that is
    /// right to 1e-10 of the signal's range.
    pub fn settle(&self, signal: &Plane<f64>) -> Result<Settled, MeshError> {
        let values = self.values(signal)?;
        let (low, high) = checked_range(signal)?;
        let mut settled = if self.is_linear() {
            self.linear(&values, high - low)?
        } else {
            self.newton(&values, (low, high))?
        };
        if settled.error.is_nan() || settled.error > MOST_ERROR * (high - low) {
            return Err(MeshError::Unsettled {
                error: settled.error,
            });
        }
        // The exact solution lies within the signal's range, so clamping only removes rounding
        // error.
        settled.surround.mapv_inplace(|h| h.clamp(low, high));
        Ok(settled)
    }

    fn linear(&self, signal: &[f64], span: f64) -> Result<Settled, MeshError> {
        let mut nearest = Nearest::new(self.size, &self.transverse, &self.down, &self.across)?;
        let weighed: Vec<f64> = signal
            .iter()
            .zip(&self.transverse)
            .map(|(p, g)| p * g)
            .collect();
        let mut surround = nearest.solve(&weighed)?;
        let mut iterations = 0;
        let mut error = f64::INFINITY;
        // A second solve for the residual (iterative refinement) recovers what the first lost to
        // rounding.
        for _ in 0..6 {
            let left = self.at_nodes(signal, &surround);
            error = largest(&nearest.solve(&left)?);
            if error <= 1e-16 * span {
                break;
            }
            let (change, steps) = self.gradients(&mut nearest, None, &left, 1e-13)?;
            iterations += steps;
            for (h, change) in surround.iter_mut().zip(&change) {
                *h += change;
            }
            if largest(&change) <= 4e-15 * span {
                break;
            }
        }
        Ok(Settled {
            surround: self.plane(&surround),
            iterations,
            newton: 0,
            error,
        })
    }

    fn newton(&self, signal: &[f64], (low, high): (f64, f64)) -> Result<Settled, MeshError> {
        // Start from a uniform surround: no lateral carries a current.
        let mut surround = vec![low + (high - low) * 0.5; signal.len()];
        let (mut iterations, mut error) = (0, f64::INFINITY);
        let mut content = self.content(signal, &surround);
        for newton in 1..=MOST_NEWTON {
            let slopes = self.slopes(&surround);
            let (down, across) = &slopes;
            let mut nearest = Nearest::new(self.size, &self.transverse, down, across)?;
            let left = self.at_nodes(signal, &surround);
            let (change, steps) = self.gradients(&mut nearest, Some(&slopes), &left, 1e-12)?;
            iterations += steps;
            error = largest(&change);
            let done = error <= 1e-13 * (high - low);
            let fall = dot(&left, &change);
            let (mut part, mut next, mut lower) = (1.0, Vec::new(), 0.0);
            for _ in 0..60 {
                let moved = surround.iter().zip(&change).map(|(h, d)| h + part * d);
                next = moved.collect();
                lower = self.content(signal, &next);
                // Near the minimum the decrease is below the last digits of the co-content.
                let enough = lower <= content - 1e-4 * part * fall;
                if done || enough || fall <= 1e-12 * content {
                    break;
                }
                part *= 0.5;
            }
            (surround, content) = (next, lower);
            if done {
                return Ok(Settled {
                    surround: self.plane(&surround),
                    iterations,
                    newton,
                    error,
                });
            }
        }
        Err(MeshError::Unsettled { error })
    }

    /// The co-content, which the settled state minimises.
    fn content(&self, signal: &[f64], surround: &[f64]) -> f64 {
        let own = signal.iter().zip(surround).zip(&self.transverse);
        let mut content: f64 = own.map(|((p, h), g)| 0.5 * g * (p - h) * (p - h)).sum();
        each_lateral(self.size, |i, j, way| {
            let conductance = self.conductances(way)[i];
            if conductance > 0.0 {
                content += conductance * self.laterals.content(surround[j] - surround[i]);
            }
        });
        content
    }

    /// The differential conductances `G f'(v)` at a state, vertical and horizontal.
    fn slopes(&self, surround: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let zero = vec![0.0; surround.len()];
        let (mut down, mut across) = (zero.clone(), zero);
        each_lateral(self.size, |i, j, way| {
            let slope = self.conductances(way)[i] * self.laterals.slope(surround[j] - surround[i]);
            match way {
                Way::Down => down[i] = slope,
                Way::Across => across[i] = slope,
            }
        });
        (down, across)
    }

    /// Solves `K x = currents` by preconditioned conjugate gradients, until the energy of the
    /// residual is `part²` of that at the beginning.
    fn gradients(
        &self,
        nearest: &mut Nearest,
        slopes: Option<&(Vec<f64>, Vec<f64>)>,
        currents: &[f64],
        part: f64,
    ) -> Result<(Vec<f64>, usize), MeshError> {
        let (down, across) = slopes.map_or((&self.down, &self.across), |(d, a)| (d, a));
        let mut change = vec![0.0; currents.len()];
        let mut left = currents.to_vec();
        let mut ready = nearest.solve(&left)?;
        let mut way = ready.clone();
        let mut energy = dot(&left, &ready);
        let enough = energy * part * part;
        for step in 0..MOST_STEPS {
            if energy.is_nan() || energy <= enough || energy <= 0.0 {
                return Ok((change, step));
            }
            let pushed = self.pushed(down, across, &way);
            let length = energy / dot(&way, &pushed);
            for i in 0..change.len() {
                change[i] += length * way[i];
                left[i] -= length * pushed[i];
            }
            ready = nearest.solve(&left)?;
            let next = dot(&left, &ready);
            let kept = next / energy;
            energy = next;
            for (way, ready) in way.iter_mut().zip(&ready) {
                *way = ready + kept * *way;
            }
        }
        Ok((change, MOST_STEPS))
    }

    /// `K` times `voltages`: the currents that leave the nodes.
    pub(super) fn pushed(&self, down: &[f64], across: &[f64], voltages: &[f64]) -> Vec<f64> {
        let own = voltages.iter().zip(&self.transverse);
        let mut currents: Vec<f64> = own.map(|(v, g)| v * g).collect();
        each_lateral(self.size, |i, j, way| {
            let conductance = match way {
                Way::Down => down[i],
                Way::Across => across[i],
            };
            let current = conductance * (voltages[i] - voltages[j]);
            currents[i] += current;
            currents[j] -= current;
        });
        currents
    }

    /// Solves `K x = currents` for a linear network to rounding accuracy.
    pub(super) fn taken_up(&self, currents: &[f64]) -> Result<Vec<f64>, MeshError> {
        let mut nearest = Nearest::new(self.size, &self.transverse, &self.down, &self.across)?;
        let mut sum = vec![0.0; currents.len()];
        for _ in 0..3 {
            let pushed = self.pushed(&self.down, &self.across, &sum);
            let left: Vec<f64> = currents.iter().zip(&pushed).map(|(a, b)| a - b).collect();
            let (change, _) = self.gradients(&mut nearest, None, &left, 1e-13)?;
            for (sum, change) in sum.iter_mut().zip(&change) {
                *sum += change;
            }
        }
        Ok(sum)
    }

    /// Thermal noise of the resistors at one moment: independent at each node with variance
    /// `kt / C`. `kt` is in the unit of capacitance times signal squared.
    #[must_use]
    pub fn noise(&self, kt: f64, seed: u64, moment: u64) -> Plane<f64> {
        let parts = self.capacitance.iter().enumerate();
        let drawn: Vec<f64> = parts
            .map(|(i, c)| (kt / c).sqrt() * normal(seed, Reason::Thermal, i, moment))
            .collect();
        self.plane(&drawn)
    }
}

impl Laterals {
    fn current(self, v: f64) -> f64 {
        match self {
            Self::Linear => v,
            Self::Saturating { scale } => scale * elementary::tanh(v / scale),
            Self::Opening { scale } => scale * elementary::sinh(v / scale),
        }
    }

    fn slope(self, v: f64) -> f64 {
        match self {
            Self::Linear => 1.0,
            Self::Saturating { scale } => elementary::cosh(v / scale).powi(-2),
            Self::Opening { scale } => elementary::cosh(v / scale),
        }
    }

    /// The integral `F` of the current law, the co-content of a lateral.
    fn content(self, v: f64) -> f64 {
        match self {
            Self::Linear => 0.5 * v * v,
            Self::Saturating { scale } => {
                let u = (v / scale).abs();
                // ln cosh u; for small u by its series, since the closed form would cancel.
                let log = if u < 1e-3 {
                    u * u * (0.5 - u * u / 12.0)
                } else {
                    u + elementary::ln_1p(elementary::exp(-2.0 * u)) - std::f64::consts::LN_2
                };
                scale * scale * log
            }
            Self::Opening { scale } => {
                let half = elementary::sinh(0.5 * v / scale);
                2.0 * scale * scale * half * half
            }
        }
    }
}

/// The direction of a lateral from its node.
#[derive(Clone, Copy)]
enum Way {
    Down,
    Across,
}

/// Calls `of(i, j, way)` once for every lateral, from node `i` to node `j`.
fn each_lateral(size: Size, mut of: impl FnMut(usize, usize, Way)) {
    let Size { height, width } = size;
    for y in 0..height {
        for i in y * width..(y + 1) * width {
            if i + 1 < (y + 1) * width {
                of(i, i + 1, Way::Across);
            }
            if y + 1 < height {
                of(i, i + width, Way::Down);
            }
        }
    }
}

/// The preconditioner: the sheet of equal parts nearest to a network.
struct Nearest {
    steady: Steady,
    transverse: f64,
    size: Size,
}

impl Nearest {
    fn new(size: Size, own: &[f64], down: &[f64], across: &[f64]) -> Result<Self, MeshError> {
        let middle = |values: &[f64]| {
            let logs = values
                .iter()
                .filter(|v| **v > 0.0)
                .map(|v| elementary::ln(*v));
            let (count, sum) = logs.fold((0u32, 0.0), |(n, s), log| (n + 1, s + log));
            if count == 0 {
                0.0
            } else {
                elementary::exp(sum / f64::from(count))
            }
        };
        let transverse = middle(own);
        let lambda = |values: &[f64]| (middle(values) / transverse).sqrt();
        let sheet = Sheet::anisotropic(lambda(down), lambda(across));
        let sheet = sheet.map_err(|_| MeshError::Unsettled {
            error: f64::INFINITY,
        })?;
        Ok(Self {
            steady: Steady::new(sheet, size)?,
            transverse,
            size,
        })
    }

    /// The solution of the nearest sheet for `currents`.
    fn solve(&mut self, currents: &[f64]) -> Result<Vec<f64>, MeshError> {
        let Size { width, .. } = self.size;
        let plane = Plane::from_shape_fn(self.size.shape(), |(y, x)| {
            currents[y * width + x] / self.transverse
        });
        let solved = self
            .steady
            .solve(&plane)
            .map_err(|_| MeshError::Unsettled {
                error: f64::INFINITY,
            })?;
        Ok(solved.into_raw_vec_and_offset().0)
    }
}

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, v| {
        if v.is_nan() {
            f64::NAN
        } else {
            most.max(v.abs())
        }
    })
}
