//! How what is seen moves and looks: the ranges that a clip draws from.

use amacrine::{elementary, rng::Hash};

use super::affine::{Matrix, Path, Vector};

/// The ranges that each clip draws from.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// Speed of a layer's middle, in pixels a frame: from the first to the second, in any direction.
    pub pan: [f64; 2],
    /// The fastest rotation either way, in degrees a frame.
    pub turn: f64,
    /// The fastest change of size either way, as a part a frame.
    pub zoom: f64,
    /// The fastest stretch and shear either way, as a part a frame.
    pub shear: f64,
    /// The part of the clips that have a second layer.
    pub occluder: f64,
    /// What the light is multiplied by, after the gamma.
    pub gain: [f64; 2],
    /// The exponent of light in parts of white.
    pub gamma: [f64; 2],
}

impl Default for Motion {
    fn default() -> Self {
        Self {
            pan: [0.2, 2.5],
            turn: 1.0,
            zoom: 0.01,
            shear: 0.004,
            occluder: 0.6,
            gain: [0.7, 1.2],
            gamma: [0.8, 1.25],
        }
    }
}

/// What is drawn: one number each for a clip's layers.
#[derive(Clone, Copy, Debug)]
pub(super) enum Reason {
    Photograph,
    Occluded,
    Gain,
    Gamma,
    Frame,
    PhotographOf,
    Pan,
    Direction,
    Turn,
    Zoom,
    Stretch,
    Shear,
    Shrink,
    Left,
    Top,
    Orientation,
    CentreX,
    CentreY,
    Radius,
    Wave,
    Phase,
    CropX,
    CropY,
}

/// The hash of a clip, or of one of its layers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Draw(pub Hash);

impl Draw {
    /// From 0 to 1.
    pub fn part(self, reason: Reason) -> f64 {
        self.0.with(reason as u64).uniform()
    }

    /// The `n`-th of several for one reason, from 0 to 1.
    pub fn part_of(self, reason: Reason, n: u64) -> f64 {
        self.0.with(reason as u64).with(n).uniform()
    }

    /// Between two bounds.
    pub fn between(self, reason: Reason, [low, high]: [f64; 2]) -> f64 {
        low + (high - low) * self.part(reason)
    }

    /// Up to `most` either way.
    pub fn either(self, reason: Reason, most: f64) -> f64 {
        self.between(reason, [-most, most])
    }

    /// One of `count`.
    pub fn one_of(self, reason: Reason, count: usize) -> usize {
        ((self.part(reason) * count as f64) as usize).min(count.saturating_sub(1))
    }
}

impl Motion {
    /// The path of a layer whose middle is at `centre` at time 0.
    pub(super) fn path(&self, draw: Draw, centre: Vector) -> Path {
        let speed = draw.between(Reason::Pan, self.pan);
        let (sin, cos) = elementary::sin_cos(std::f64::consts::TAU * draw.part(Reason::Direction));
        let turn = draw.either(Reason::Turn, self.turn.to_radians());
        let zoom = draw.either(Reason::Zoom, self.zoom);
        let stretch = draw.either(Reason::Stretch, self.shear);
        let shear = draw.either(Reason::Shear, self.shear);
        let rate: Matrix = [
            [zoom + stretch, shear - turn],
            [shear + turn, zoom - stretch],
        ];
        Path {
            centre,
            velocity: [speed * cos, speed * sin],
            rate,
        }
    }
}
