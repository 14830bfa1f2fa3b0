//! From the gradient of the drive back to that of the light.
//!
//! `dL/du(q) = sum over channels and k of W(k) h(q - k)`: each cell gives back to the pixels that it
//! reads. What it read off the array was the nearest pixel, which gets that share, or nothing.

use rayon::prelude::*;

use crate::reference::Border;

use super::{float::Float, forward::Forward, model::Model, piece::Piece};

/// The gradient of the light of all frames; `drives` has `dL/dS` of each piece.
pub(super) fn gradient<R: Float>(
    model: &Model<R>,
    seen: &Forward<R>,
    pieces: &[Piece],
    drives: &[Vec<R>],
) -> Vec<R> {
    let (frames, pixels) = (seen.times.len(), model.size.pixels());
    let mut light = vec![R::ZERO; seen.clips * frames * pixels];
    light
        .par_chunks_mut(pixels)
        .enumerate()
        .for_each(|(n, out)| {
            let (clip, frame) = (n / frames, n % frames);
            let own = pieces.iter().zip(drives);
            let own = own.filter(|(piece, _)| piece.clip == clip);
            let mut sheet = Sheet::new(model);
            for (piece, drive) in own {
                sheet.add(piece, frame, drive);
            }
            sheet.fold(out);
            for (y, out) in out.chunks_mut(model.size.width).enumerate() {
                for (out, u) in out.iter_mut().zip(seen.signal[n].inner(y)) {
                    *out = *out * model.photoreceptors.slope(*u);
                }
            }
        });
    light
}

/// A frame with a rim, into which cells give.
struct Sheet<'a, R: Float> {
    model: &'a Model<R>,
    stride: usize,
    values: Vec<R>,
    half: Vec<R>,
}

impl<'a, R: Float> Sheet<'a, R> {
    fn new(model: &'a Model<R>) -> Self {
        let (size, (rows, columns)) = (model.size, model.reach);
        let stride = size.width + 2 * columns;
        Self {
            model,
            stride,
            values: vec![R::ZERO; (size.height + 2 * rows) * stride],
            half: vec![R::ZERO; size.width],
        }
    }

    fn add(&mut self, piece: &Piece, frame: usize, drive: &[R]) {
        let width = self.half.len();
        let cells = piece.rows.len() * width;
        for (k, kernels) in self.model.kernels.iter().enumerate() {
            let start = (frame * self.model.kernels.len() + k) * cells;
            for (y, h) in piece
                .rows
                .clone()
                .zip(drive[start..start + cells].chunks(width))
            {
                let (several, first) = (kernels.len() > 1, 2 * (y % 2));
                for parity in 0..if several { 2 } else { 1 } {
                    let kernel = if several { first + parity } else { 0 };
                    for (x, (half, h)) in self.half.iter_mut().zip(h).enumerate() {
                        *half = if !several || x % 2 == parity {
                            *h
                        } else {
                            R::ZERO
                        };
                    }
                    self.give(k, kernel, y);
                }
            }
        }
    }

    /// Gives a row of cells back through a kernel.
    fn give(&mut self, channel: usize, kernel: usize, y: usize) {
        let kernel = &self.model.kernels[channel][kernel];
        let (reach, width) = (self.model.reach, self.half.len());
        let (rows, columns) = (kernel.nrows() / 2, kernel.ncols() / 2);
        for ((row, column), &weight) in kernel.indexed_iter() {
            let start = (y + reach.0 - rows + row) * self.stride + reach.1 - columns + column;
            let to = &mut self.values[start..start + width];
            for (to, h) in to.iter_mut().zip(&self.half) {
                *to = *to + weight * *h;
            }
        }
    }

    /// Adds the rim to the pixels that stood for it, and goes back through the response.
    fn fold(self, out: &mut [R]) {
        let (size, reach) = (self.model.size, self.model.reach);
        let zero = self.model.description.border == Border::Zero;
        for (y, row) in self.values.chunks(self.stride).enumerate() {
            let inside = y >= reach.0 && y < reach.0 + size.height;
            let y = y.saturating_sub(reach.0).min(size.height - 1);
            for (x, value) in row.iter().enumerate() {
                let inside = inside && x >= reach.1 && x < reach.1 + size.width;
                let x = x.saturating_sub(reach.1).min(size.width - 1);
                if inside || !zero {
                    let to = &mut out[y * size.width + x];
                    *to = *to + *value;
                }
            }
        }
    }
}
