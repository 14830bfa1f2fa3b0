//! What a step is trained on: some clips, as tensors.

use amacrine::{gradient::Forward, plane::Size, rng::Hash};
use rayon::prelude::*;

use crate::{
    network::{Maps, Shape},
    scene::{Clip, Clips},
    task::{Goal, Task},
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

    /// What the network gets of a clip when it is trained.
    #[must_use]
    pub fn input(
        &self,
        given: (&Task, &Shape<f32>),
        n: usize,
        seen: Option<&Forward<f32>>,
    ) -> Maps<f32> {
        let (frames, kinds) = seen.map_or((0, 0), |seen| (seen.shape()[1], seen.shape()[2]));
        let each = frames * kinds * self.size.pixels();
        let voxels = seen.map(|seen| &seen.voxels()[n * each..][..each]);
        self.given(given, n, kinds, voxels)
    }

    /// What the network gets of a clip: the first and the last frame where the task shows them, from
    /// -1/2 to 1/2, then the voxels of each kind, frame after frame.
    #[must_use]
    pub fn given(
        &self,
        (task, shape): (&Task, &Shape<f32>),
        n: usize,
        kinds: usize,
        voxels: Option<&[f32]>,
    ) -> Maps<f32> {
        let clip = &self.clips[n];
        let (pictures, frames) = (task.pictures(), clip.light.dim().0);
        let mut maps = Maps::zeros(shape, pictures + frames * kinds);
        let Size { height, width } = self.size;
        for (map, frame) in [0, frames - 1].into_iter().enumerate().take(pictures) {
            for y in 0..height {
                let light = clip.light.slice(ndarray::s![frame, y, ..]);
                for (value, light) in maps.row_mut(shape, map, y).iter_mut().zip(light) {
                    *value = light / 255.0 - 0.5;
                }
            }
        }
        for (n, row) in voxels.unwrap_or_default().chunks(width).enumerate() {
            let to = maps.row_mut(shape, pictures + n / height, n % height);
            to.copy_from_slice(row);
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
    /// For each clip.
    pub asked: Vec<Maps<f32>>,
}

/// What a loss is rounded off by, of 1: `sqrt(e² + EDGE²)` (Charbonnier et al. 1994).
const EDGE: f32 = 1e-3;

impl Loss {
    /// Charbonnier's loss of the middle frame that answers add to the mean of the two others; or
    /// the mean distance, coordinate by coordinate, of the flow where it is seen at both ends.
    #[must_use]
    pub fn new(task: &Task, shape: &Shape<f32>, batch: &Batch, answers: &[Maps<f32>]) -> Self {
        let each = |(clip, answer): (&Clip, &Maps<f32>)| match task.goal {
            Goal::Interpolation => interpolation(clip, shape, answer),
            Goal::Flow => flow(clip, shape, answer),
        };
        let pairs: Vec<_> = batch.clips.par_iter().zip(answers).map(each).collect();
        let count = pairs.len() as f64;
        let mean = pairs.iter().map(|(loss, _)| loss).sum::<f64>() / count;
        let scaled = |(_, mut maps): (f64, Maps<f32>)| {
            for c in 0..maps.channels() {
                for y in 0..shape.size().height {
                    for value in maps.row_mut(shape, c, y) {
                        *value /= count as f32;
                    }
                }
            }
            maps
        };
        Self {
            mean,
            asked: pairs.into_iter().map(scaled).collect(),
        }
    }
}

/// The mean of the first and the last frame, of 1.
pub(super) fn blend(clip: &Clip, y: usize, x: usize) -> f32 {
    let last = clip.light.dim().0 - 1;
    (clip.light[[0, y, x]] + clip.light[[last, y, x]]) / 510.0
}

fn interpolation(clip: &Clip, shape: &Shape<f32>, answer: &Maps<f32>) -> (f64, Maps<f32>) {
    let mut asked = Maps::zeros(shape, 1);
    let mut sum = 0.0;
    let Size { height, width } = shape.size();
    let count = (height * width) as f32;
    for y in 0..height {
        let said = answer.row(shape, 0, y);
        for (x, asked) in asked.row_mut(shape, 0, y).iter_mut().enumerate() {
            let truth = clip.light[[clip.middle(), y, x]] / 255.0;
            let error = blend(clip, y, x) + said[x] - truth;
            let size = (error * error + EDGE * EDGE).sqrt();
            sum += f64::from(size);
            *asked = error / size / count;
        }
    }
    (sum / f64::from(count), asked)
}

fn flow(clip: &Clip, shape: &Shape<f32>, answer: &Maps<f32>) -> (f64, Maps<f32>) {
    let mut asked = Maps::zeros(shape, 2);
    let Some(truth) = &clip.flow else {
        return (0.0, asked);
    };
    let count = truth.seen.iter().filter(|seen| **seen).count().max(1) as f32;
    let mut sum = 0.0;
    let Size { height, width } = shape.size();
    for (c, truth_of) in [&truth.u, &truth.v].into_iter().enumerate() {
        for y in 0..height {
            let said = answer.row(shape, c, y);
            let asked = asked.row_mut(shape, c, y);
            for x in 0..width {
                if truth.seen[[y, x]] {
                    let error = said[x] - truth_of[[y, x]];
                    sum += f64::from(error.abs());
                    asked[x] = if error == 0.0 {
                        0.0
                    } else {
                        error.signum() / count
                    };
                }
            }
        }
    }
    (sum / f64::from(count), asked)
}
