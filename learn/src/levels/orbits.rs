//! Weights that a symmetry makes equal.

use amacrine::plane::Plane;

use super::error::LevelsError;

/// Which weights of a kernel are equal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Symmetry {
    /// None has to be.
    #[default]
    None,
    /// Left and right.
    Mirror,
    /// Those that turns by right angles and mirrors lay upon each other.
    Square,
}

/// The places of a kernel that share a weight, in the order of their first places.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Orbits {
    /// Places by number, row after row.
    pub all: Vec<Vec<usize>>,
}

impl Orbits {
    pub fn new(symmetry: Symmetry, (height, width): (usize, usize)) -> Result<Self, LevelsError> {
        if symmetry == Symmetry::Square && height != width {
            return Err(LevelsError::Square { height, width });
        }
        // The first place of those that share a weight stands for them.
        let first = |(y, x): (usize, usize)| {
            let x = x.min(width - 1 - x);
            match symmetry {
                Symmetry::None => None,
                Symmetry::Mirror => Some((y, x)),
                Symmetry::Square => {
                    let y = y.min(height - 1 - y);
                    Some((y.min(x), y.max(x)))
                }
            }
        };
        let mut firsts: Vec<(usize, usize)> = Vec::new();
        let mut all: Vec<Vec<usize>> = Vec::new();
        for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            let own = first((y, x)).unwrap_or((y, x));
            let place = y * width + x;
            if let Some(known) = firsts.iter().position(|one| *one == own) {
                all[known].push(place);
            } else {
                firsts.push(own);
                all.push(vec![place]);
            }
        }
        Ok(Self { all })
    }

    /// The mean of each orbit.
    pub fn means(&self, plane: &Plane<f64>) -> Vec<f64> {
        let (_, width) = plane.dim();
        let mean = |orbit: &Vec<usize>| {
            let sum: f64 = orbit.iter().map(|at| plane[(at / width, at % width)]).sum();
            sum / orbit.len() as f64
        };
        self.all.iter().map(mean).collect()
    }

    /// A plane of one value an orbit.
    pub fn plane(&self, values: &[f64], shape: (usize, usize)) -> Plane<f64> {
        let mut plane = Plane::zeros(shape);
        for (orbit, value) in self.all.iter().zip(values) {
            for at in orbit {
                plane[(at / shape.1, at % shape.1)] = *value;
            }
        }
        plane
    }
}
