//! Half the size by the mean of 2x2, twice the size by repetition: each is the other's transpose,
//! but for a factor of 4.

use amacrine::gradient::Float;

use super::maps::{Maps, Shape};

/// The sums of each 2x2 values, times `factor`.
pub(super) fn halved<R: Float>(
    (from, to): (&Shape<R>, &Shape<R>),
    maps: &Maps<R>,
    factor: R,
) -> Maps<R> {
    let mut out = Maps::unwritten(to, maps.channels());
    for place in places(to, maps) {
        for y in 0..to.size().height {
            let upper = maps.row(from, place, 2 * y).chunks_exact(2);
            let lower = maps.row(from, place, 2 * y + 1).chunks_exact(2);
            let rows = out.row_mut(to, place, y).iter_mut().zip(upper.zip(lower));
            for (out, (upper, lower)) in rows {
                *out = ((upper[0] + upper[1]) + (lower[0] + lower[1])) * factor;
            }
        }
    }
    out
}

/// Each picture of each map.
fn places<R: Float>(shape: &Shape<R>, maps: &Maps<R>) -> impl Iterator<Item = (usize, usize)> {
    let (pictures, channels) = (shape.pictures(), maps.channels());
    (0..channels).flat_map(move |channel| (0..pictures).map(move |picture| (picture, channel)))
}

/// Each value four times, times `factor`.
pub(super) fn doubled<R: Float>(
    (from, to): (&Shape<R>, &Shape<R>),
    maps: &Maps<R>,
    factor: R,
) -> Maps<R> {
    let mut out = Maps::unwritten(to, maps.channels());
    for place in places(to, maps) {
        for y in 0..to.size().height {
            let row = maps.row(from, place, y / 2).iter();
            let row = row.zip(out.row_mut(to, place, y).chunks_exact_mut(2));
            for (value, out) in row {
                out.fill(*value * factor);
            }
        }
    }
    out
}
