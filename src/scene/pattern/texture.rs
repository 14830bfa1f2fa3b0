//! Textures without figures: a picture, or blobs from a hash.

use crate::{plane::Plane, rng::Hash};

/// Light everywhere on the plane.
#[derive(Debug)]
pub(super) enum Texture {
    /// A picture, its middle at (0, 0).
    Picture { picture: Plane<f64>, border: Border },
    /// Value noise: random values from 0 to 1 on a grid of `grain` pixels, interpolated smoothly;
    /// unbounded.
    Blobs { grain: f64, seed: u64 },
}

/// How a picture is continued beyond its border.
#[derive(Clone, Copy, Debug)]
pub(super) enum Border {
    /// Its border pixels are replicated.
    Replicate,
    /// It is repeated periodically.
    Wrap,
}

impl Texture {
    /// The value at a place, `(x, y)` in pixels from the middle.
    pub fn at(&self, (x, y): (f64, f64)) -> f64 {
        match self {
            Self::Picture { picture, border } => {
                let (height, width) = picture.dim();
                let x = border.place(x + (width - 1) as f64 / 2.0, width);
                let y = border.place(y + (height - 1) as f64 / 2.0, height);
                let value = |j: i64, i: i64| {
                    let at = (border.pixel(j, height), border.pixel(i, width));
                    picture.get(at).copied().unwrap_or(0.0)
                };
                cubic(x, y, value)
            }
            Self::Blobs { grain, seed } => {
                let (x, y) = (x / grain, y / grain);
                let (left, top) = (x.floor(), y.floor());
                let ease = |f: f64| f * f * f * (f * (6.0 * f - 15.0) + 10.0);
                let (fx, fy) = (ease(x - left), ease(y - top));
                let corner = |i: f64, j: f64| hash(*seed, (left + i) as i64, (top + j) as i64);
                let row = |j| corner(0.0, j) * (1.0 - fx) + corner(1.0, j) * fx;
                row(0.0) * (1.0 - fy) + row(1.0) * fy
            }
        }
    }
}

impl Border {
    /// Maps a coordinate near the picture, so that it can be converted to an integer.
    fn place(self, a: f64, length: usize) -> f64 {
        match self {
            Self::Replicate => a.clamp(-2.0, length as f64 + 1.0),
            Self::Wrap => a.rem_euclid(length as f64),
        }
    }

    fn pixel(self, a: i64, length: usize) -> usize {
        let length = length as i64;
        let inside = match self {
            Self::Replicate => a.clamp(0, length - 1),
            Self::Wrap => a.rem_euclid(length),
        };
        inside as usize
    }
}

/// Cubic interpolation (Catmull-Rom), kept between the darkest and the brightest of the four
/// nearest pixels so that it never overshoots.
fn cubic(x: f64, y: f64, value: impl Fn(i64, i64) -> f64) -> f64 {
    let weights = |f: f64| {
        [
            ((-0.5 * f + 1.0) * f - 0.5) * f,
            (1.5 * f - 2.5) * f * f + 1.0,
            ((-1.5 * f + 2.0) * f + 0.5) * f,
            (0.5 * f - 0.5) * f * f,
        ]
    };
    let (left, top) = (x.floor(), y.floor());
    let (wx, wy) = (weights(x - left), weights(y - top));
    let (mut sum, mut least, mut most) = (0.0, f64::INFINITY, f64::NEG_INFINITY);
    for (j, wy) in (-1..).zip(wy) {
        for (i, wx) in (-1..).zip(wx) {
            let value = value(top as i64 + j, left as i64 + i);
            sum += wy * wx * value;
            if matches!((i, j), (0 | 1, 0 | 1)) {
                least = value.min(least);
                most = value.max(most);
            }
        }
    }
    sum.clamp(least, most)
}

/// A random number from 0 to 1 that is a pure function of its arguments.
fn hash(seed: u64, x: i64, y: i64) -> f64 {
    Hash::new(seed).with(x as u64).with(y as u64).uniform()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(border: Border) -> (Plane<f64>, Texture) {
        let picture = Plane::from_shape_fn((5, 7), |(y, x)| ((y * 31 + x * 17) % 23) as f64);
        (picture.clone(), Texture::Picture { picture, border })
    }

    #[test]
    fn at_whole_pixels_a_picture_is_itself() {
        for border in [Border::Replicate, Border::Wrap] {
            let (picture, texture) = picture(border);
            for ((y, x), value) in picture.indexed_iter() {
                assert_eq!(texture.at((x as f64 - 3.0, y as f64 - 2.0)), *value);
            }
        }
    }

    #[test]
    fn outside_is_the_border_or_the_picture_again() {
        let (picture, texture) = picture(Border::Replicate);
        assert_eq!(texture.at((1e300, -1e300)), picture[(0, 6)]);
        let (_, texture) = self::picture(Border::Wrap);
        assert!((texture.at((0.4 + 7.0, 1.2 - 5.0)) - texture.at((0.4, 1.2))).abs() < 1e-9);
    }

    #[test]
    fn blobs_fill_the_range_and_follow_the_seed() {
        let values: Vec<f64> = (0..400).map(|i| hash(1, i % 20, i / 20)).collect();
        let mean = values.iter().sum::<f64>() / 400.0;
        assert!((mean - 0.5).abs() < 0.05, "{mean}");
        assert!(values.iter().any(|v| *v < 0.05) && values.iter().any(|v| *v > 0.95));
        assert_ne!(hash(1, 2, 3), hash(2, 2, 3));
        assert_ne!(hash(1, 2, 3), hash(1, 3, 2));
    }
}
