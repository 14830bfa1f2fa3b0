//! From a frame to the signal that the kernels see: light, response, number format, rim.

use rayon::prelude::*;

use crate::{
    number::Number, photoreceptor::Response, plane::Size, scene::Frame, sensor::SensorError,
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

/// Pixels that are filtered at a time.
pub(super) const BLOCK: usize = 64;

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

    /// The `2 reach + 1` rows around row `y`, each from `reach` columns left of the first.
    pub(super) fn around(&self, y: usize, reach: (usize, usize)) -> impl Iterator<Item = &[H]> {
        (0..=2 * reach.0).map(move |k| {
            let start = (y + self.rim.0 - reach.0 + k) * self.stride + self.rim.1 - reach.1;
            &self.values[start..start + self.stride - self.rim.1 + reach.1]
        })
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
        if self.size.pixels() < super::SMALL {
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
    table: Vec<N::Held>,
}

impl<N: Number> Photoreceptors<N> {
    pub(super) fn new(number: N, response: Response) -> Self {
        let signal = |light: u8| response.apply(light.into()).unwrap_or(0.0);
        let table = (0..=u8::MAX)
            .map(|light| number.hold(signal(light)))
            .collect();
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
        let light = row.as_slice();
        if let Some(light) = light.filter(|light| whole_bytes(light)) {
            for (out, light) in out.iter_mut().zip(light) {
                *out = self.table[*light as usize & 0xff];
            }
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
}

/// Whether all of these are 0, 1, … 255, as they are in 8-bit video.
fn whole_bytes(light: &[f64]) -> bool {
    light.iter().all(|light| f64::from(*light as u8) == *light)
}
