//! Light that filters are tried on where no scene is given: pictures that move.
//!
//! Opaque discs that lie on each other, of radii drawn from 1/r³ and of any brightness, have the
//! edges, the flat parts and the correlations of photographs (A. B. Lee, D. Mumford, J. Huang,
//! *Occlusion models for natural images*, IJCV 41, 2001). Small ones average out in every sum of a
//! filter; large ones, bright ones and bright texture, with amplitudes of 1/f as photographs have
//! them (D. J. Field, JOSA A 4, 1987), are what fills a register in a scene that stands still. The
//! picture is moved by part of a pixel or a few, and wraps round, so that it has no border.

use crate::{elementary, plane::Plane, rng::Hash};

/// Rows and columns.
pub const SIDE: usize = 40;

/// How far the leaves move in each pair, in pixels: from not at all to what a filter of few
/// pixels no longer follows.
pub const MOVES: [f64; 6] = [0.0, 0.5, 1.0, 2.0, 4.0, 8.0];

/// Those of [`MOVES`] that stronger light is moved by.
const FEW: [usize; 2] = [2, 4];

/// Discs: so many that nothing is bare.
const DISCS: u64 = 400;

/// Samples of a pixel, along each side.
const SAMPLES: usize = 3;

/// What a picture is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Light {
    /// Small discs of any brightness.
    Leaves,
    /// Discs that are larger than filters, of any brightness: flat parts up to the full light.
    Large,
    /// The same, of the brighter part of the light alone.
    Bright,
    /// Texture of amplitudes 1/f round a bright mean.
    Texture,
}

impl Light {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Leaves, Self::Large, Self::Bright, Self::Texture];

    /// The pairs of pictures, by number; each has the move of that number.
    pub(super) const fn numbers(self) -> &'static [usize] {
        match self {
            Self::Leaves => &[0, 1, 2, 3, 4, 5],
            Self::Large | Self::Bright | Self::Texture => &FEW,
        }
    }

    /// A picture before and after it moved by that number of [`MOVES`], in parts of the full light.
    pub(super) fn pair(self, number: usize) -> [Plane<f64>; 2] {
        let place = Hash::new(0x1EAF).with(number as u64);
        let (sin, cos) = elementary::sin_cos(std::f64::consts::TAU * place.nth(1).uniform());
        let way = MOVES[number % MOVES.len()];
        let moves = [(0.0, 0.0), (way * sin, way * cos)];
        let discs = match self {
            Self::Leaves => discs(place, (2.0, 20.0), (0.0, 1.0)),
            Self::Large => discs(place, (6.0, 40.0), (0.0, 1.0)),
            Self::Bright => discs(place, (6.0, 40.0), (0.6, 1.0)),
            Self::Texture => {
                let waves = waves(place);
                return moves.map(|by| texture(&waves, by));
            }
        };
        moves.map(|by| picture(&discs, by))
    }
}

/// Small discs before and after they moved by that number of [`MOVES`], in parts of the full light.
#[must_use]
pub fn pair(number: usize) -> [Plane<f64>; 2] {
    Light::Leaves.pair(number)
}

struct Disc {
    y: f64,
    x: f64,
    radius: f64,
    light: f64,
}

/// Discs with radii between these, in pixels, and light between those.
fn discs(place: Hash, radii: (f64, f64), light: (f64, f64)) -> Vec<Disc> {
    let side = SIDE as f64;
    (0..DISCS)
        .map(|i| {
            let draw = |n| place.with(i).nth(n).uniform();
            // The radius of which a share has a smaller one, of a density of 1/r³.
            let (least, most) = (radii.0.powi(-2), radii.1.powi(-2));
            Disc {
                y: draw(1) * side,
                x: draw(2) * side,
                radius: 1.0 / (least - draw(3) * (least - most)).sqrt(),
                light: light.0 + draw(4) * (light.1 - light.0),
            }
        })
        .collect()
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

/// Mean of the texture and its spread, in parts of the full light.
const TEXTURE: (f64, f64) = (0.8, 0.15);

/// So many periods down and across, of this amplitude and phase.
struct Wave {
    down: i32,
    across: i32,
    amplitude: f64,
    phase: f64,
}

/// All waves of a picture, which together have a spread of 1.
fn waves(place: Hash) -> Vec<Wave> {
    let half = SIDE as i32 / 2;
    let one = |(down, across): (i32, i32)| {
        let draw = place.with(((down + half) * SIDE as i32 + across) as u64);
        Wave {
            down,
            across,
            amplitude: 1.0 / f64::from(down * down + across * across).sqrt(),
            phase: std::f64::consts::TAU * draw.nth(1).uniform(),
        }
    };
    let all = (1 - half..half).flat_map(|down| (0..half).map(move |across| (down, across)));
    let mut waves: Vec<Wave> = { all }
        .filter(|(down, across)| *across > 0 || *down > 0)
        .map(one)
        .collect();
    let power: f64 = waves.iter().map(|wave| wave.amplitude.powi(2) / 2.0).sum();
    for wave in &mut waves {
        wave.amplitude /= power.sqrt();
    }
    waves
}

fn texture(waves: &[Wave], (down, across): (f64, f64)) -> Plane<f64> {
    let turn = std::f64::consts::TAU / SIDE as f64;
    let table: Vec<(f64, f64)> = (0..SIDE)
        .map(|i| elementary::sin_cos(turn * i as f64))
        .collect();
    let (mean, spread) = TEXTURE;
    let mut sum = Plane::from_elem((SIDE, SIDE), 0.0);
    for wave in waves {
        let way = f64::from(wave.down) * down + f64::from(wave.across) * across;
        let (sin, cos) = elementary::sin_cos(wave.phase - turn * way);
        for ((y, x), sum) in sum.indexed_iter_mut() {
            let at = wave.down * y as i32 + wave.across * x as i32;
            let own = table[at.rem_euclid(SIDE as i32) as usize];
            *sum += wave.amplitude * (own.1 * cos - own.0 * sin);
        }
    }
    sum.mapv(|it: f64| (mean + spread * it).clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    const CELLS: f64 = (SIDE * SIDE) as f64;

    #[test]
    fn what_moves_farther_changes_more() {
        let change = |number| {
            let [before, after] = pair(number);
            let both = before.iter().zip(&after);
            both.map(|(a, b)| (a - b).abs()).sum::<f64>() / CELLS
        };
        assert_eq!(change(0), 0.0);
        let all: Vec<f64> = (0..MOVES.len()).map(change).collect();
        assert!(all[5] > 3.0 * all[1] && all[1] > 0.005, "{all:?}");
        let light = pair(3)[0].sum() / CELLS;
        assert!((0.3..0.7).contains(&light), "{light}");
    }

    #[test]
    fn strong_light_is_strong_and_flat_parts_are_flat() {
        // The share of squares of 5x5 pixels that are brighter than this throughout.
        let bright = |light: Light, than: f64| {
            let [picture, _] = light.pair(2);
            let dark = |corner: usize| {
                let mut square = (0..25).map(|i| {
                    let (y, x) = (corner / SIDE + i / 5, corner % SIDE + i % 5);
                    picture[(y % SIDE, x % SIDE)]
                });
                square.any(|it| it <= than)
            };
            (0..SIDE * SIDE).filter(|corner| !dark(*corner)).count() as f64 / CELLS
        };
        // In the order of the list.
        let [leaves, large, all, texture] = Light::ALL.map(|light| bright(light, 0.599));
        assert!(leaves < large / 2.0 && large > 0.05, "{leaves} {large}");
        assert!(all == 1.0 && texture > 0.3, "{all} {texture}");
    }

    #[test]
    fn texture_moves_by_whole_pixels_as_a_picture_does() {
        let waves = waves(Hash::new(1));
        let (still, moved) = (texture(&waves, (0.0, 0.0)), texture(&waves, (2.0, -1.0)));
        for ((y, x), it) in moved.indexed_iter() {
            let from = still[((y + SIDE - 2) % SIDE, (x + 1) % SIDE)];
            assert!((it - from).abs() < 1e-9);
        }
    }
}
