//! From a frame to the signal that the kernels see: light, response, number format, rim.

use multiversion::multiversion;
use rayon::prelude::*;

use crate::{
    number::Number,
    photoreceptor::{Curve, Response},
    plane::Size,
    scene::Frame,
    sensor::SensorError,
};

use super::description::Border;

/// A plane with a rim, so that a kernel can be laid on every pixel; row after row.
#[derive(Clone, Debug)]
pub(super) struct Padded<H> {
    values: Vec<H>,
    size: Size,
    /// Rows above and below, columns left and right.
    rim: (usize, usize),
    /// From one row to the next: the columns, both rims, and room for a whole block at the end.
    stride: usize,
}

/// Pixels that are worked on at a time, at most.
const BLOCK: usize = 64;

impl<H: Copy + Send + Sync> Padded<H> {
    /// Room for planes of `size` under kernels that reach `rim` (rows, columns).
    pub(super) fn new(size: Size, rim: (usize, usize), zero: H) -> Self {
        let stride = size.width.next_multiple_of(BLOCK) + 2 * rim.1;
        let values = vec![zero; (size.height + 2 * rim.0) * stride];
        Self {
            values,
            size,
            rim,
            stride,
        }
    }

    /// Row `y` of the plane without its rim.
    pub(super) fn inner(&self, y: usize) -> &[H] {
        let start = (y + self.rim.0) * self.stride + self.rim.1;
        &self.values[start..start + self.size.width]
    }

    /// The plane from `reach` above and left of the first pixel of row `y` on, and how far it is
    /// from one row to the next. Each row of a kernel of that reach finds whole blocks there.
    pub(super) fn from(&self, y: usize, reach: (usize, usize)) -> (&[H], usize) {
        let start = (y + self.rim.0 - reach.0) * self.stride + self.rim.1 - reach.1;
        (&self.values[start..], self.stride)
    }

    /// Fills every row of the plane through `fill(y, row)`, then the rim.
    pub(super) fn fill<E: Send>(
        &mut self,
        border: Border,
        zero: H,
        fill: impl Fn(usize, &mut [H]) -> Result<(), E> + Sync,
    ) -> Result<(), E> {
        let (above, left) = self.rim;
        let Size { height, width } = self.size;
        let rows = &mut self.values[above * self.stride..(above + height) * self.stride];
        let one = |(y, row): (usize, &mut [H])| {
            fill(y, &mut row[left..left + width])?;
            let (west, east) = match border {
                Border::Replicate => (row[left], row[left + width - 1]),
                Border::Zero => (zero, zero),
            };
            row[..left].fill(west);
            row[left + width..].fill(east);
            Ok(())
        };
        if self.size.pixels() < super::SMALL || super::alone() {
            rows.chunks_exact_mut(self.stride)
                .enumerate()
                .try_for_each(one)?;
        } else {
            rows.par_chunks_exact_mut(self.stride)
                .enumerate()
                .with_min_len(16)
                .try_for_each(one)?;
        }
        let first = above * self.stride..(above + 1) * self.stride;
        let last = (above + height - 1) * self.stride..(above + height) * self.stride;
        for k in 0..above {
            let (top, bottom) = (k * self.stride, (above + height + k) * self.stride);
            match border {
                Border::Replicate => {
                    self.values.copy_within(first.clone(), top);
                    self.values.copy_within(last.clone(), bottom);
                }
                Border::Zero => {
                    self.values[top..top + self.stride].fill(zero);
                    self.values[bottom..bottom + self.stride].fill(zero);
                }
            }
        }
        Ok(())
    }
}

/// The photoreceptors: light in, signal out.
#[derive(Clone, Debug)]
pub(super) struct Photoreceptors<N: Number> {
    number: N,
    response: Response,
    /// The signal of each 8-bit light.
    table: [N::Held; 256],
}

impl<N: Number> Photoreceptors<N> {
    pub(super) fn new(number: N, response: Response) -> Self {
        let signal = |light: usize| response.apply(light as f64).unwrap_or(0.0);
        let table = std::array::from_fn(|light| number.hold(signal(light)));
        Self {
            number,
            response,
            table,
        }
    }

    /// `u = R(I)` for row `y` of a frame.
    pub(super) fn row(
        &self,
        frame: &Frame,
        y: usize,
        out: &mut [N::Held],
    ) -> Result<(), SensorError> {
        let row = frame.light.row(y);
        if let Some(light) = row.as_slice()
            && (from_table(&self.table, light, out) || self.straight(light, out))
        {
            return Ok(());
        }
        for (x, (out, light)) in out.iter_mut().zip(&row).enumerate() {
            let signal = self.response.apply(*light);
            let index = frame.index;
            *out = self.number.hold(signal.map_err(|cause| SensorError::Light {
                index,
                y,
                x,
                cause,
            })?);
        }
        Ok(())
    }

    /// The responses that are a straight line, for a row at once; whether this is one, and all
    /// the light is within what it is defined for.
    fn straight(&self, light: &[f64], out: &mut [N::Held]) -> bool {
        let Response { curve, round_f32 } = self.response;
        let (least, white) = match curve {
            Curve::Identity => (f64::MIN, 1.0),
            Curve::Linear { white } => (0.0, white),
            Curve::Log { .. } | Curve::LinLog { .. } => return false,
        };
        divide(&self.number, (least, white, round_f32), light, out)
    }
}

/// Looks up light that is 0, 1, … 255, as it is in 8-bit video; whether all of it was.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn from_table<H: Copy>(table: &[H; 256], light: &[f64], out: &mut [H]) -> bool {
    for (light, out) in light.chunks(BLOCK).zip(out.chunks_mut(BLOCK)) {
        let mut places = [0; BLOCK];
        let mut wrong = 0;
        for (place, &light) in places.iter_mut().zip(light) {
            // Added to 2^52, a whole number stands in the lowest bits, and comes back whole.
            let sum = light + MAGIC;
            *place = sum.to_bits();
            wrong |= (*place ^ MAGIC.to_bits()) & !0xff;
            wrong |= (sum - MAGIC).to_bits() ^ light.to_bits();
        }
        if wrong != 0 {
            return false;
        }
        for (out, place) in out.iter_mut().zip(&places) {
            *out = table[*place as usize & 0xff];
        }
    }
    true
}

/// 2^52: the first double after which there are no fractions.
const MAGIC: f64 = 4_503_599_627_370_496.0;

/// `light / white`; whether all the light is finite and at least `least`.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn divide<N: Number>(
    number: &N,
    (least, white, round_f32): (f64, f64, bool),
    light: &[f64],
    out: &mut [N::Held],
) -> bool {
    let mut within = true;
    for (out, &light) in out.iter_mut().zip(light) {
        within &= light >= least && light <= f64::MAX;
        let signal = light / white;
        *out = number.hold(if round_f32 {
            f64::from(signal as f32)
        } else {
            signal
        });
    }
    within
}
