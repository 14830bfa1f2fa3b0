//! Kernels as what is learned of them, and back.

use amacrine::{
    gradient::gaussian_gradients,
    kernel::{Gaussian, Kernel},
    plane::Plane,
    reference::Surrounds,
    rng::Hash,
};

use crate::levels::{Levels, LevelsError};

use super::{
    Cells, Start,
    resistors::{self, LAMBDAS},
};

/// How far several kernels that begin alike are apart.
const APART: f64 = 0.05;

/// The narrowest and the widest Gaussian, in pixels.
const SIGMAS: [f64; 2] = [0.3, 2.5];

/// What is learned of an arm's kernels.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    form: Form,
    /// What a step moves.
    pub parameters: Vec<f64>,
    levels: Option<Levels>,
}

#[derive(Clone, Debug, PartialEq)]
enum Form {
    /// So many kernels of this side, weight by weight; each of length 1.
    Weights { kernels: usize, side: usize },
    /// The logarithms of two standard deviations, and the gain of the second.
    Gaussians,
    /// The logarithm of a mesh's space constant, and the gain of its surround.
    Mesh,
    /// Nothing.
    Given(Plane<f64>),
}

/// Kernels as they are applied, and what the way back needs.
#[derive(Clone, Debug, PartialEq)]
pub struct Applied {
    /// Each of length 1: thresholds take up the scale.
    pub kernels: Vec<Kernel>,
    /// The same in whole levels, where they have few values.
    pub levels: Option<Vec<Plane<f64>>>,
    /// Before they had few values.
    latent: Vec<Plane<f64>>,
    projected: Vec<crate::levels::Projected>,
}

impl Applied {
    /// The kernels before they had few values.
    #[must_use]
    pub fn latent(&self) -> &[Plane<f64>] {
        &self.latent
    }

    /// The kernels in few values; none where weights are free.
    #[must_use]
    pub fn few(&self) -> &[crate::levels::Projected] {
        &self.projected
    }
}

fn length(plane: &Plane<f64>) -> f64 {
    plane.iter().map(|w| w * w).sum::<f64>().sqrt()
}

/// The gradient of a plane from that of the same plane scaled to length 1.
fn unscaled(plane: &Plane<f64>, asked: &Plane<f64>) -> Plane<f64> {
    let size = length(plane).max(f64::MIN_POSITIVE);
    let along = plane.iter().zip(asked).map(|(w, g)| w * g).sum::<f64>() / (size * size);
    (asked - &(plane * along)) / size
}

impl Shape {
    /// What the cells begin with; the seed tells kernels apart that would be alike.
    #[must_use]
    pub fn new(cells: &Cells, seed: u64) -> Self {
        let (form, parameters) = match &cells.start {
            Start::Builtin(name) => {
                let kernel = Kernel::builtin(name);
                let plane = kernel.map_or_else(|| Plane::ones((1, 1)), |k| k.weights().clone());
                (Form::Given(plane), Vec::new())
            }
            Start::Delta(side) => {
                let kernels = cells.kinds * if cells.pattern { 4 } else { 1 };
                let apart = if kernels == 1 { 0.0 } else { APART };
                let weight = |n: usize| {
                    let place = n % (side * side);
                    let centre = if place == side * side / 2 { 1.0 } else { 0.0 };
                    let own = Hash::new(seed).with(0x6b65_726e).with(n as u64).uniform();
                    centre + apart * (2.0 * own - 1.0)
                };
                let weights = (0..kernels * side * side).map(weight).collect();
                let side = *side;
                (Form::Weights { kernels, side }, weights)
            }
            Start::Gaussians([narrow, wide, gain]) => {
                let ln = amacrine::elementary::ln;
                (Form::Gaussians, vec![ln(*narrow), ln(*wide), *gain])
            }
            Start::Mesh([lambda, gain]) => {
                (Form::Mesh, vec![amacrine::elementary::ln(*lambda), *gain])
            }
        };
        let mut shape = Self {
            form,
            parameters,
            levels: cells.few.as_ref().map(|few| few.levels.clone()),
        };
        shape.settle();
        shape
    }

    /// Leaves parameters where kernels are of length 1, and Gaussians neither too narrow nor too wide.
    pub fn settle(&mut self) {
        match &self.form {
            Form::Weights { side, .. } => {
                for kernel in self.parameters.chunks_mut(side * side) {
                    let size = kernel.iter().map(|w| w * w).sum::<f64>().sqrt();
                    if size > 0.0 {
                        for weight in kernel {
                            *weight /= size;
                        }
                    }
                }
            }
            Form::Gaussians => {
                let [least, most] = SIGMAS.map(amacrine::elementary::ln);
                for log in &mut self.parameters[..2] {
                    *log = log.clamp(least, most);
                }
                self.parameters[2] = self.parameters[2].clamp(-1.0, 1.0);
            }
            Form::Mesh => {
                let [least, most] = LAMBDAS.map(amacrine::elementary::ln);
                self.parameters[0] = self.parameters[0].clamp(least, most);
                self.parameters[1] = self.parameters[1].clamp(-1.0, 1.0);
            }
            Form::Given(_) => {}
        }
    }

    /// Draws each kernel this part of the way to the nearest one in few values, where it has some.
    ///
    /// # Errors
    /// When few values leave nothing of a kernel.
    pub fn draw(&mut self, part: f64) -> Result<(), LevelsError> {
        let (Form::Weights { side, .. }, Some(levels)) = (&self.form, &self.levels) else {
            return Ok(());
        };
        let side = *side;
        for kernel in self.parameters.chunks_mut(side * side) {
            let plane = Plane::from_shape_fn((side, side), |(y, x)| kernel[y * side + x]);
            let near = levels.project(&plane)?;
            for (weight, level) in kernel.iter_mut().zip(&near.levels) {
                *weight += part * (level * near.scale - *weight);
            }
        }
        self.settle();
        Ok(())
    }

    /// The space constant and the gain of a mesh.
    fn mesh(&self) -> (f64, f64) {
        (
            amacrine::elementary::exp(self.parameters[0]),
            self.parameters[1],
        )
    }

    /// The mesh that the kernel stands for, of the same length; `None` where there is none.
    #[must_use]
    pub fn surrounds(&self) -> Option<Surrounds> {
        if self.form != Form::Mesh {
            return None;
        }
        let (lambda, gain) = self.mesh();
        let size = length(&resistors::kernel(lambda, gain)).max(f64::MIN_POSITIVE);
        resistors::surrounds(lambda, gain, 1.0 / size)
    }

    fn gaussians(&self) -> [Gaussian; 2] {
        let part = |n: usize, gain| Gaussian {
            sigma: amacrine::elementary::exp(self.parameters[n]),
            gain,
        };
        [part(0, 1.0), part(1, self.parameters[2])]
    }

    /// The kernels; in few values where the arm has them and `few` says so.
    ///
    /// # Errors
    /// When few values leave nothing of a kernel.
    pub fn apply(&self, few: bool) -> Result<Applied, LevelsError> {
        let latent: Vec<Plane<f64>> = match &self.form {
            Form::Given(plane) => vec![plane.clone()],
            Form::Gaussians => {
                let sum = Kernel::from_gaussians(&self.gaussians());
                vec![sum.map_or_else(|_| Plane::ones((1, 1)), |k| k.weights().clone())]
            }
            Form::Mesh => {
                let (lambda, gain) = self.mesh();
                vec![resistors::kernel(lambda, gain)]
            }
            Form::Weights { side, .. } => {
                let kernels = self.parameters.chunks(side * side);
                let square = |kernel: &[f64]| {
                    Plane::from_shape_fn((*side, *side), |(y, x)| kernel[y * side + x])
                };
                kernels.map(square).collect()
            }
        };
        let mut projected = Vec::new();
        if let (Some(levels), true) = (&self.levels, few) {
            for plane in &latent {
                projected.push(levels.project(plane)?);
            }
        }
        let whole: Vec<_> = projected.iter().map(|p| p.levels.clone()).collect();
        let planes = if projected.is_empty() {
            &latent
        } else {
            &whole
        };
        let unit = |plane: &Plane<f64>| {
            let size = length(plane).max(f64::MIN_POSITIVE);
            Kernel::new(plane / size)
        };
        let kernels: Result<Vec<_>, _> = planes.iter().map(unit).collect();
        Ok(Applied {
            kernels: kernels.map_err(|_| LevelsError::Empty)?,
            levels: (!projected.is_empty()).then_some(whole),
            latent,
            projected,
        })
    }

    /// The gradient of the parameters from that of the kernels, where they are of any weights.
    #[must_use]
    pub fn pull(&self, applied: &Applied, asked: &[Plane<f64>]) -> Vec<f64> {
        let asked: Vec<_> = { applied.latent.iter().zip(asked) }
            .map(|(p, g)| unscaled(p, g))
            .collect();
        match &self.form {
            Form::Given(_) => Vec::new(),
            Form::Weights { .. } => asked.into_iter().flatten().collect(),
            Form::Mesh => {
                let (lambda, gain) = self.mesh();
                let by = |plane: Plane<f64>| asked.iter().map(|g| (g * &plane).sum()).sum::<f64>();
                vec![
                    gain * by(resistors::by_logarithm(lambda)),
                    by(resistors::surround(lambda)),
                ]
            }
            Form::Gaussians => {
                let parts = self.gaussians();
                let of = asked
                    .first()
                    .and_then(|asked| gaussian_gradients(&parts, asked));
                of.map_or_else(
                    || vec![0.0; 3],
                    |g| {
                        vec![
                            g[0].sigma * parts[0].sigma,
                            g[1].sigma * parts[1].sigma,
                            g[1].gain,
                        ]
                    },
                )
            }
        }
    }

    /// Kernels of the form.
    #[must_use]
    pub const fn kernels(&self) -> usize {
        match self.form {
            Form::Weights { kernels, .. } => kernels,
            Form::Gaussians | Form::Mesh | Form::Given(_) => 1,
        }
    }
}
