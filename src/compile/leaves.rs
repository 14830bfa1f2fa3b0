//! Moving leaves: what a filter is tried on where no scene is given.
//!
//! Opaque discs that lie on each other, of radii drawn from 1/r³ and of any brightness, have the
//! edges, the flat parts and the correlations of photographs (A. B. Lee, D. Mumford, J. Huang,
//! *Occlusion models for natural images*, IJCV 41, 2001). The picture is moved by part of a pixel
//! or a few, and wraps round, so that it has no border.

use crate::{elementary, plane::Plane, rng::Hash};

/// Rows and columns.
pub const SIDE: usize = 40;

/// How far the picture moves in each pair, in pixels: from not at all to what a filter of few
/// pixels no longer follows.
pub const MOVES: [f64; 6] = [0.0, 0.5, 1.0, 2.0, 4.0, 8.0];

/// The radii of discs, in pixels.
const RADII: (f64, f64) = (2.0, 20.0);

/// Discs: so many that nothing is bare.
const DISCS: u64 = 400;

/// Samples of a pixel, along each side.
const SAMPLES: usize = 3;

struct Disc {
    y: f64,
    x: f64,
    radius: f64,
    light: f64,
}

/// A picture before and after it moved by that number of [`MOVES`], in parts of the full light.
#[must_use]
pub fn pair(number: usize) -> [Plane<f64>; 2] {
    let place = Hash::new(0x1EAF).with(number as u64);
    let side = SIDE as f64;
    let discs: Vec<Disc> = (0..DISCS)
        .map(|i| {
            let draw = |n| place.with(i).nth(n).uniform();
            // The radius of which a share has a smaller one, of a density of 1/r³.
            let (least, most) = (RADII.0.powi(-2), RADII.1.powi(-2));
            Disc {
                y: draw(1) * side,
                x: draw(2) * side,
                radius: 1.0 / (least - draw(3) * (least - most)).sqrt(),
                light: draw(4),
            }
        })
        .collect();
    let (sin, cos) = elementary::sin_cos(std::f64::consts::TAU * place.nth(1).uniform());
    let way = MOVES[number % MOVES.len()];
    [
        picture(&discs, (0.0, 0.0)),
        picture(&discs, (way * sin, way * cos)),
    ]
}

fn picture(discs: &[Disc], by: (f64, f64)) -> Plane<f64> {
    let side = SIDE as f64;
    // On a torus.
    let apart = |a: f64, b: f64| {
        let way = (a - b).rem_euclid(side);
        way.min(side - way)
    };
    let sample = |y: f64, x: f64| {
        let over = discs.iter().find(|disc| {
            let (dy, dx) = (apart(y, disc.y + by.0), apart(x, disc.x + by.1));
            dy * dy + dx * dx < disc.radius * disc.radius
        });
        over.map_or(0.5, |disc| disc.light)
    };
    let middle = |at: usize, part: usize| at as f64 + (part as f64 + 0.5) / SAMPLES as f64;
    Plane::from_shape_fn((SIDE, SIDE), |(y, x)| {
        let parts = 0..SAMPLES * SAMPLES;
        let sum: f64 = parts
            .map(|part| sample(middle(y, part / SAMPLES), middle(x, part % SAMPLES)))
            .sum();
        sum / (SAMPLES * SAMPLES) as f64
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_moves_farther_changes_more() {
        let change = |number| {
            let [before, after] = pair(number);
            let both = before.iter().zip(&after);
            both.map(|(a, b)| (a - b).abs()).sum::<f64>() / (SIDE * SIDE) as f64
        };
        assert_eq!(change(0), 0.0);
        let all: Vec<f64> = (0..MOVES.len()).map(change).collect();
        assert!(all[5] > 3.0 * all[1] && all[1] > 0.005, "{all:?}");
        let light = pair(3)[0].sum() / (SIDE * SIDE) as f64;
        assert!((0.3..0.7).contains(&light), "{light}");
    }
}
