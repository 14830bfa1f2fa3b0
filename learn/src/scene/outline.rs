//! A smooth closed outline round a middle.

use super::{
    affine::Vector,
    motion::{Draw, Reason},
};

/// Waves round the outline: 2 to `WAVES + 1` in a turn.
const WAVES: usize = 4;

/// How much each wave may change the radius.
const SWING: f64 = 0.14;

/// `radius (1 + sum over k of a_k cos(k φ) + b_k sin(k φ))`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Outline {
    radius: f32,
    /// `a`, `b` for each wave.
    waves: [[f32; 2]; WAVES],
    /// The square of the largest radius and two pixels.
    most: f32,
}

impl Outline {
    pub fn new(draw: Draw, radius: f64) -> Self {
        let wave = |k: u64| {
            let size = SWING * draw.part_of(Reason::Wave, k);
            let angle = std::f64::consts::TAU * draw.part_of(Reason::Phase, k);
            let (sin, cos) = amacrine::elementary::sin_cos(angle);
            [(size * cos) as f32, (size * sin) as f32]
        };
        let most = radius as f32 * (1.0 + SWING as f32 * WAVES as f32) + 2.0;
        Self {
            radius: radius as f32,
            waves: std::array::from_fn(|k| wave(k as u64)),
            most: most * most,
        }
    }

    /// Whether a place `[x, y]` from its middle lies within two pixels of what it can hold.
    #[inline]
    pub fn near(&self, [x, y]: [f32; 2]) -> bool {
        x * x + y * y < self.most
    }

    /// How far within the outline a place `[x, y]` from its middle lies, along its radius, in
    /// pixels; beyond it below 0.
    pub fn depth(&self, [x, y]: [f32; 2]) -> f32 {
        let far = (x * x + y * y).sqrt();
        if far < 1e-6 {
            return self.radius;
        }
        // Powers of the direction as a complex number are its multiples as an angle.
        let (cos, sin) = (x / far, y / far);
        let (mut re, mut im) = (cos, sin);
        let mut radius = 1.0;
        for [a, b] in self.waves {
            (re, im) = (re * cos - im * sin, re * sin + im * cos);
            radius += a * re + b * im;
        }
        self.radius * radius - far
    }

    /// Whether a place `[x, y]` from its middle lies within.
    pub fn holds(&self, place: Vector) -> bool {
        self.depth(place.map(|v| v as f32)) > 0.0
    }
}
