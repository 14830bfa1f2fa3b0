//! The way forward: the events of a batch of clips, and what the way back needs of them.

use rayon::prelude::*;

use crate::{plane::Size, reference::signal::Padded};

use super::{
    clips::Clips,
    error::{GradientError, Tensor},
    float::Float,
    forward_pass::ForwardPass,
    model::Model,
    piece::{Piece, split},
};

/// What a sensor made of a batch of clips, and what its gradient needs.
#[derive(Clone, Debug)]
pub struct Forward<R: Float> {
    pub(super) size: Size,
    pub(super) channels: usize,
    pub(super) clips: usize,
    pub(super) times: Vec<f64>,
    pub(super) voxels: Vec<R>,
    pub(super) counts: Vec<i32>,
    /// The signal of each frame, (clips, frames).
    pub(super) signal: Vec<Padded<R>>,
    /// For each piece.
    pub(super) tapes: Vec<Tape<R>>,
}

/// What a piece keeps, (pairs, channels, rows, columns).
#[derive(Clone, Debug)]
pub(super) struct Tape<R> {
    /// `d`, how far the drive is from the memory at the later frame.
    pub(super) distance: Vec<R>,
    /// With a refractory period only. Dead time: the place of the first event, or without an event 1
    /// where the cell is ready at the later frame and 0 where it is silent. Authors' rule: how much of
    /// the period is left at the earlier frame, in seconds.
    pub(super) timing: Vec<R>,
}

impl<R: Float> Forward<R> {
    /// The voxels, (clips, frames, channels, rows, columns): bins are centred on the frames.
    #[must_use]
    pub fn voxels(&self) -> &[R] {
        &self.voxels
    }

    /// The signed number of events in each pair, (clips, pairs, channels, rows, columns).
    #[must_use]
    pub fn counts(&self) -> &[i32] {
        &self.counts
    }

    /// The number of events.
    #[must_use]
    pub fn events(&self) -> u64 {
        self.counts
            .iter()
            .map(|n| u64::from(n.unsigned_abs()))
            .sum()
    }

    /// Events in a pair for each pixel, all channels together.
    #[must_use]
    pub fn rate(&self) -> f64 {
        let cells = self.counts.len() / self.channels.max(1);
        self.events() as f64 / cells.max(1) as f64
    }

    /// Bytes that it holds: voxels, counts, signals, and what the way back needs.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let tape = |tape: &Tape<R>| tape.distance.len() + tape.timing.len();
        let signals = self.signal.iter().map(|signal| signal.all().len());
        let values: usize = self.tapes.iter().map(tape).chain(signals).sum();
        (values + self.voxels.len()) * size_of::<R>() + self.counts.len() * size_of::<i32>()
    }

    /// The shape of the voxels.
    #[must_use]
    pub fn shape(&self) -> [usize; 5] {
        let Size { height, width } = self.size;
        [self.clips, self.times.len(), self.channels, height, width]
    }
}

impl<R: Float> Model<R> {
    /// The events of a batch of clips.
    ///
    /// # Errors
    /// When the clips have another size than the sensor, or hold light that the response is not
    /// defined for, or when a cell's events cannot be counted.
    pub fn forward(&self, clips: Clips<'_, R>) -> Result<Forward<R>, GradientError> {
        let (size, frames, count) = (self.size, clips.times().len(), clips.count());
        if clips.size() != size {
            return Err(GradientError::Shape {
                tensor: Tensor::Light,
                got: clips.size().pixels(),
                want: format!("frames of {size}"),
            });
        }
        let (channels, pairs) = (self.channels(), frames - 1);
        let border = self.description.border;
        let see = |n: usize| {
            let (clip, frame) = (n / frames, n % frames);
            let seen =
                (self.photoreceptors).see(clips.frame(clip, frame), (size, self.reach, border));
            seen.map_err(|(y, x, cause)| GradientError::Light {
                clip,
                frame,
                y,
                x,
                cause,
            })
        };
        let signal: Vec<_> = (0..count * frames).into_par_iter().map(see).collect();
        // The first fault in order, whichever thread finds one first.
        let signal = signal.into_iter().collect::<Result<Vec<_>, _>>()?;
        let cells = count * channels * size.pixels();
        let mut voxels = vec![R::ZERO; frames * cells];
        let mut counts = vec![0; pairs * cells];
        let parts = Piece::all(count, size).into_iter();
        let parts = parts
            .zip(split(&mut voxels, frames * channels, size))
            .zip(split(&mut counts, pairs * channels, size));
        let parts: Vec<_> = parts.collect();
        let tapes: Vec<_> = parts
            .into_par_iter()
            .map(|((piece, voxels), counts)| {
                let signal = &signal[piece.clip * frames..][..frames];
                ForwardPass::new(self, &piece, signal).run(clips.times(), voxels, counts)
            })
            .collect();
        Ok(Forward {
            size,
            channels,
            clips: count,
            times: clips.times().to_vec(),
            tapes: tapes.into_iter().collect::<Result<_, _>>()?,
            voxels,
            counts,
            signal,
        })
    }
}
