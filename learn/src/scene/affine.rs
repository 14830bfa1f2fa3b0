//! Affine maps of the plane, and motion along the flow of one.

/// A matrix of two rows.
pub(super) type Matrix = [[f64; 2]; 2];

/// A place or a step, `(x, y)` in pixels.
pub(super) type Vector = [f64; 2];

const ONE: Matrix = [[1.0, 0.0], [0.0, 1.0]];

/// Terms of the exponential: a step is well below 1, so that the rest is below a bit.
const TERMS: u32 = 24;

/// `p -> offset + matrix p`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Affine {
    pub matrix: Matrix,
    pub offset: Vector,
}

impl Affine {
    pub fn at(&self, p: Vector) -> Vector {
        plus(self.offset, times(&self.matrix, p))
    }

    /// First `inner`, then this.
    pub fn after(&self, inner: &Self) -> Self {
        Self {
            matrix: product(&self.matrix, &inner.matrix),
            offset: self.at(inner.offset),
        }
    }
}

/// Steady affine motion: a point at `place` at time 0 is at `centre + velocity t + exp(t rate)
/// (place - centre)` at time `t`, in frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Path {
    pub centre: Vector,
    pub velocity: Vector,
    pub rate: Matrix,
}

impl Path {
    /// From places at time `t` to those at time 0.
    pub fn back(&self, t: f64) -> Affine {
        let matrix = exponential(&self.rate, -t);
        let from = plus(self.centre, [self.velocity[0] * t, self.velocity[1] * t]);
        let turned = times(&matrix, from);
        Affine {
            matrix,
            offset: [self.centre[0] - turned[0], self.centre[1] - turned[1]],
        }
    }

    /// From places at time 0 to those at time `t`.
    pub fn forth(&self, t: f64) -> Affine {
        let matrix = exponential(&self.rate, t);
        let to = plus(self.centre, [self.velocity[0] * t, self.velocity[1] * t]);
        let turned = times(&matrix, self.centre);
        Affine {
            matrix,
            offset: [to[0] - turned[0], to[1] - turned[1]],
        }
    }
}

pub(super) fn plus(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1]]
}

fn times(m: &Matrix, p: Vector) -> Vector {
    m.map(|row| row[0] * p[0] + row[1] * p[1])
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    let entry = |i: usize, j: usize| a[i][0] * b[0][j] + a[i][1] * b[1][j];
    [[entry(0, 0), entry(0, 1)], [entry(1, 0), entry(1, 1)]]
}

/// `exp(t rate)` by its series: the same bits on every machine.
fn exponential(rate: &Matrix, t: f64) -> Matrix {
    let step = rate.map(|row| row.map(|v| v * t));
    let (mut sum, mut term) = (ONE, ONE);
    for n in 1..TERMS {
        term = product(&term, &step).map(|row| row.map(|v| v / f64::from(n)));
        for (sum, term) in sum.iter_mut().flatten().zip(term.iter().flatten()) {
            *sum += term;
        }
    }
    sum
}
