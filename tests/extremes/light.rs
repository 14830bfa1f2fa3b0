//! Numbers by chance, and planes and frames of them.

use amacrine::{
    plane::{Plane, Size},
    rng::{GOLDEN, mix, uniform},
    scene::Frame,
};

/// A number in [-1, 1) that depends on these two alone.
pub fn draw(seed: u64, place: usize) -> f64 {
    2.0 * uniform(mix(
        mix(seed.wrapping_mul(GOLDEN)).wrapping_add(place as u64)
    )) - 1.0
}

/// So many of them.
pub fn draws(seed: u64, count: usize) -> Vec<f64> {
    (0..count).map(|place| draw(seed, place)).collect()
}

/// A plane that repeats itself after `period` pixels both ways.
pub fn tiles(size: Size, period: usize, value: impl Fn(usize, usize) -> f64) -> Plane<f64> {
    let tile: Vec<Vec<f64>> = (0..period)
        .map(|y| (0..period).map(|x| value(y, x)).collect())
        .collect();
    Plane::from_shape_fn(size.shape(), |(y, x)| tile[y % period][x % period])
}

pub fn frame(index: u64, seconds: f64, light: Plane<f64>) -> Frame {
    Frame {
        index,
        seconds,
        light: light.into(),
    }
}

/// A sum of products without rounding, but for the last digits of twice double precision (Ogita,
/// Rump and Oishi, SIAM Journal on Scientific Computing 26:1955, 2005): as a large and a small
/// part.
pub fn exact_dot(terms: impl IntoIterator<Item = (f64, f64)>) -> (f64, f64) {
    let (mut sum, mut rest) = (0.0, 0.0);
    for (weight, value) in terms {
        let product = weight * value;
        let next = sum + product;
        let back = next - sum;
        rest += weight.mul_add(value, -product) + ((sum - (next - back)) + (product - back));
        sum = next;
    }
    (sum, rest)
}
