//! What a step is trained on: some clips, as tensors.

use std::ops::Range;

use amacrine::{gradient::Forward, plane::Size, rng::Hash};
use rayon::prelude::*;

use crate::{
    network::{Maps, Shape},
    scene::{Clip, Clips},
    task::{Distance, Goal, Task},
};

/// Some clips.
#[derive(Clone, Debug)]
pub struct Batch {
    /// What was seen and what is true.
    pub clips: Vec<Clip>,
    size: Size,
}

impl Batch {
    /// The clips of these numbers.
    #[must_use]
    pub fn new(clips: &Clips, numbers: std::ops::Range<u64>) -> Self {
        Self {
            clips: numbers.into_par_iter().map(|n| clips.clip(n)).collect(),
            size: clips.size(),
        }
    }

    /// Some of these clips, by their places.
    pub(super) fn some(&self, places: &[usize]) -> Self {
        Self {
            clips: places.iter().map(|n| self.clips[*n].clone()).collect(),
            size: self.size,
        }
    }

    /// Rows and columns.
    #[must_use]
    pub const fn size(&self) -> Size {
        self.size
    }

    /// The light that a sensor sees, (clips, frames, rows, columns): with noise of this standard
    /// deviation, not below 0.
    #[must_use]
    pub fn light(&self, noise: f64, draw: Hash) -> Vec<f32> {
        let seen = |(n, clip): (usize, &Clip)| {
            let own = draw.with(n as u64);
            let light = clip.light.iter().enumerate();
            let noisy = light.map(|(i, light)| {
                let draw = own.with(i as u64).bits();
                (light + noise as f32 * bell(draw)).max(0.0)
            });
            noisy.collect::<Vec<f32>>()
        };
        if noise == 0.0 {
            return self
                .clips
                .iter()
                .flat_map(|clip| clip.light.iter().copied())
                .collect();
        }
        let each: Vec<_> = self.clips.par_iter().enumerate().map(seen).collect();
        each.concat()
    }

    /// Numbers of the clips that a network of maps of this shape works on at once.
    #[must_use]
    pub fn groups(&self, shape: &Shape<f32>) -> Vec<Range<usize>> {
        let (count, each) = (self.clips.len(), shape.pictures());
        let starts = (0..count).step_by(each);
        starts.map(|n| n..(n + each).min(count)).collect()
    }

    /// What the network gets of some clips when it is trained.
    #[must_use]
    pub fn input(
        &self,
        given: (&Task, &Shape<f32>),
        clips: Range<usize>,
        seen: Option<&Forward<f32>>,
    ) -> Maps<f32> {
        let (frames, kinds) = seen.map_or((0, 0), |seen| (seen.shape()[1], seen.shape()[2]));
        let each = frames * kinds * self.size.pixels();
        let voxels = |n: usize| seen.map(|seen| &seen.voxels()[n * each..][..each]);
        self.given(given, clips, kinds, voxels)
    }

    /// What the network gets of some clips: the first and the last frame where the task shows them,
    /// from -1/2 to 1/2, then the voxels of each kind, frame after frame.
    pub(super) fn given<'a>(
        &self,
        (task, shape): (&Task, &Shape<f32>),
        clips: Range<usize>,
        kinds: usize,
        voxels: impl Fn(usize) -> Option<&'a [f32]>,
    ) -> Maps<f32> {
        let (pictures, frames) = (task.pictures(), task.scenes.frames);
        let mut maps = Maps::zeros(shape, pictures + frames * kinds);
        let Size { height, width } = self.size;
        for (place, n) in clips.enumerate() {
            let clip = &self.clips[n];
            for (map, frame) in [0, frames - 1].into_iter().enumerate().take(pictures) {
                for y in 0..height {
                    let light = clip.light.slice(ndarray::s![frame, y, ..]);
                    let row = maps.row_mut(shape, (place, map), y);
                    for (value, light) in row.iter_mut().zip(light) {
                        *value = light / 255.0 - 0.5;
                    }
                }
            }
            for (n, row) in voxels(n).unwrap_or_default().chunks(width).enumerate() {
                let to = maps.row_mut(shape, (place, pictures + n / height), n % height);
                to.copy_from_slice(row);
            }
        }
        maps
    }
}

/// About normal, of variance 1, from 64 bits: the sum of four uniform numbers (Irwin and Hall).
fn bell(bits: u64) -> f32 {
    let sum: u32 = (0..4).map(|n| (bits >> (16 * n)) as u32 & 0xffff).sum();
    // Of variance 4/12.
    (sum as f32 / 65536.0 - 2.0) * 1.732_050_8
}

/// The mean of a batch's losses, and its gradient by what the network said.
pub struct Loss {
    /// The mean over clips and pixels.
    pub mean: f64,
    /// For the clips of each of [`Batch::groups`].
    pub asked: Vec<Maps<f32>>,
}

impl Loss {
    /// The mean distance of the middle frame that answers add to the mean of the two others; or that
    /// of the flow, coordinate by coordinate, where it is seen at both ends.
    #[must_use]
    pub fn new(task: &Task, shape: &Shape<f32>, batch: &Batch, answers: &[Maps<f32>]) -> Self {
        let count = batch.clips.len() as f32;
        let each = |(clips, answer): (Range<usize>, &Maps<f32>)| {
            let mut asked = Maps::zeros(shape, answer.channels());
            let own = |(place, clip): (usize, &Clip)| {
                let part = (shape, place, count);
                match task.goal {
                    Goal::Interpolation => interpolation(task.loss, clip, part, answer, &mut asked),
                    Goal::Flow => flow(task.loss, clip, part, answer, &mut asked),
                }
            };
            let losses: Vec<f64> = batch.clips[clips].iter().enumerate().map(own).collect();
            (losses, asked)
        };
        let groups = batch.groups(shape).into_par_iter().zip(answers);
        let (losses, asked): (Vec<_>, Vec<_>) = groups.map(each).unzip();
        Self {
            mean: losses.iter().flatten().sum::<f64>() / f64::from(count),
            asked,
        }
    }
}

/// The mean of the first and the last frame, of 1.
pub(super) fn blend(clip: &Clip, y: usize, x: usize) -> f32 {
    let last = clip.light.dim().0 - 1;
    (clip.light[[0, y, x]] + clip.light[[last, y, x]]) / 510.0
}

fn interpolation(
    loss: Distance,
    clip: &Clip,
    (shape, place, clips): (&Shape<f32>, usize, f32),
    answer: &Maps<f32>,
    asked: &mut Maps<f32>,
) -> f64 {
    let mut sum = 0.0;
    let Size { height, width } = shape.size();
    let count = (height * width) as f32;
    for y in 0..height {
        let said = answer.row(shape, (place, 0), y);
        for (x, asked) in asked.row_mut(shape, (place, 0), y).iter_mut().enumerate() {
            let truth = clip.light[[clip.middle(), y, x]] / 255.0;
            let error = blend(clip, y, x) + said[x] - truth;
            let (size, slope) = loss.of(error);
            sum += f64::from(size);
            *asked = slope / count / clips;
        }
    }
    sum / f64::from(count)
}

fn flow(
    loss: Distance,
    clip: &Clip,
    (shape, place, clips): (&Shape<f32>, usize, f32),
    answer: &Maps<f32>,
    asked: &mut Maps<f32>,
) -> f64 {
    let Some(truth) = &clip.flow else {
        return 0.0;
    };
    let count = truth.seen.iter().filter(|seen| **seen).count().max(1) as f32;
    let mut sum = 0.0;
    let Size { height, width } = shape.size();
    for (c, truth_of) in [&truth.u, &truth.v].into_iter().enumerate() {
        for y in 0..height {
            let said = answer.row(shape, (place, c), y);
            let asked = asked.row_mut(shape, (place, c), y);
            for x in 0..width {
                if truth.seen[[y, x]] {
                    let error = said[x] - truth_of[[y, x]];
                    let (size, slope) = loss.of(error);
                    sum += f64::from(size);
                    asked[x] = slope / count / clips;
                }
            }
        }
    }
    sum / f64::from(count)
}
