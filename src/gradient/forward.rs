//! The way forward: the events of a batch of clips, and what the way back needs of them.

use rayon::prelude::*;

use crate::{plane::Size, reference::signal::Padded};

use super::{
    clips::Clips,
    error::{GradientError, Tensor},
    float::Float,
    forward_pass::ForwardPass,
    model::{Model, Shape},
    piece::{Piece, split},
};

/// What a sensor made of a batch of clips, and what its gradient needs. The default has seen nothing.
#[derive(Clone, Debug)]
pub struct Forward<R: Float> {
    pub(super) size: Size,
    pub(super) channels: usize,
    /// The model that made it.
    pub(super) by: Option<Shape>,
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
#[derive(Clone, Debug, Default)]
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

impl<R: Float> Default for Forward<R> {
    fn default() -> Self {
        Self {
            size: Size::new(0, 0),
            channels: 0,
            by: None,
            clips: 0,
            times: Vec::new(),
            voxels: Vec::new(),
            counts: Vec::new(),
            signal: Vec::new(),
            tapes: Vec::new(),
        }
    }
}

/// As many values, whatever they are: a buffer that is long enough is used again.
pub(super) fn room<T: Clone>(buffer: &mut Vec<T>, count: usize, zero: T) {
    if buffer.capacity() < count {
        *buffer = vec![zero; count];
    } else {
        buffer.resize(count, zero);
    }
}

impl<R: Float> Model<R> {
    /// The events of a batch of clips.
    ///
    /// # Errors
    /// When the clips have another size than the sensor, or hold light that the response is not
    /// defined for, or when a cell's events cannot be counted.
    pub fn forward(&self, clips: Clips<'_, R>) -> Result<Forward<R>, GradientError> {
        let mut seen = Forward::default();
        self.forward_into(clips, &mut seen)?;
        Ok(seen)
    }

    /// The same, in the memory of an earlier result, which need not be of this model: fresh memory
    /// has to be cleared by the system. After an error nothing is in it.
    ///
    /// # Errors
    /// Those of [`forward`](Self::forward).
    pub fn forward_into(
        &self,
        clips: Clips<'_, R>,
        seen: &mut Forward<R>,
    ) -> Result<(), GradientError> {
        let Forward {
            mut voxels,
            mut counts,
            mut signal,
            mut tapes,
            ..
        } = std::mem::take(seen);
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
        let unseen = || Padded::new(size, 0..size.height, self.reach, R::ZERO);
        signal.retain(|padded| padded.is_for(size, &(0..size.height), self.reach));
        signal.resize_with(count * frames, unseen);
        let see = |(n, padded): (usize, &mut Padded<R>)| {
            let (clip, frame) = (n / frames, n % frames);
            let seen = (self.photoreceptors).see(clips.frame(clip, frame), border, padded);
            seen.map_err(|(y, x, cause)| GradientError::Light {
                clip,
                frame,
                y,
                x,
                cause,
            })
        };
        let faults: Vec<_> = signal.par_iter_mut().enumerate().map(see).collect();
        // The first fault in order, whichever thread finds one first.
        faults.into_iter().collect::<Result<(), _>>()?;
        let cells = count * channels * size.pixels();
        room(&mut voxels, frames * cells, R::ZERO);
        room(&mut counts, pairs * cells, 0);
        let pieces = Piece::all(count, size);
        tapes.resize_with(pieces.len(), Tape::default);
        let parts = pieces.into_iter().zip(&mut tapes);
        let parts = parts
            .zip(split(&mut voxels, frames * channels, size))
            .zip(split(&mut counts, pairs * channels, size));
        let parts: Vec<_> = parts.collect();
        let faults: Vec<_> = parts
            .into_par_iter()
            .map(|(((piece, tape), voxels), counts)| {
                let signal = &signal[piece.clip * frames..][..frames];
                ForwardPass::new(self, &piece, signal).run(clips.times(), (voxels, counts), tape)
            })
            .collect();
        faults.into_iter().collect::<Result<(), _>>()?;
        *seen = Forward {
            size,
            channels,
            by: Some(self.shape()),
            clips: count,
            times: clips.times().to_vec(),
            tapes,
            voxels,
            counts,
            signal,
        };
        Ok(())
    }
}
