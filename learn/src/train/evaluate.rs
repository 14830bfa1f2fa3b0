//! How good an arm is on held-out photographs.

use std::ops::Range;

use amacrine::{
    event::address::AddressWord,
    gradient::{Forward, Model},
    plane::{Plane, Size},
    reference::Description,
};
use rayon::prelude::*;

use crate::{
    arm::Sight,
    network::{Maps, Network, Shape},
    record::{Decoder, Form, Row},
    scene::{Clip, Clips},
    task::Goal,
};

use super::{
    batch::{Batch, blend},
    error::TrainError,
    trainee::{Reason, Trainee},
};

/// Clips that are worked on together.
const TOGETHER: u64 = 32;

/// What the network is given of the events of some clips, and how many they are.
#[derive(PartialEq)]
pub(super) struct Told {
    /// Voxels, (frames, kinds, rows, columns), clip after clip.
    pub voxels: Vec<Vec<f32>>,
    /// Events of each clip.
    pub events: Vec<u64>,
}

impl Trainee<'_> {
    /// A row for each held-out clip.
    ///
    /// # Errors
    /// When the sensor cannot see them.
    pub fn judged(
        &self,
        sensor: Option<&Description>,
        clips: &Clips,
    ) -> Result<Vec<Row>, TrainError> {
        let mut rows = Vec::new();
        let all = self.task.test.0;
        // The noise is that of the whole batch which the thresholds were set on.
        let batch = Batch::new(clips, 0..all);
        let light = batch.light(self.task.sensor.light_noise, self.draw(Reason::Test, 1));
        let each = light.len() / batch.clips.len().max(1);
        let model =
            sensor.map(|sensor| Model::<f32>::new(sensor.clone(), clips.size(), self.mismatch()));
        let wrong = |cause| TrainError::Gradient {
            arm: self.arm.name.clone(),
            step: self.state.step,
            cause,
        };
        let model = model.transpose().map_err(wrong)?;
        for first in (0..all).step_by(TOGETHER as usize) {
            let count = TOGETHER.min(all - first);
            let part = Batch::new(clips, first..first + count);
            let light = &light[first as usize * each..][..count as usize * each];
            let told = match &model {
                None => None,
                Some(model) => {
                    let seen = model.forward(self.light(light, &part)?).map_err(wrong)?;
                    Some(told(&seen))
                }
            };
            rows.extend(self.rows((&part, first), told.as_ref(), (Form::Trained, Decoder::Own)));
        }
        Ok(rows)
    }

    /// The rows of some clips, by what the network is told of them.
    pub(super) fn rows(
        &self,
        (batch, first): (&Batch, u64),
        told: Option<&Told>,
        (form, decoder): (Form, Decoder),
    ) -> Vec<Row> {
        let network =
            Network::<f32>::new(self.task.plan(self.arm), batch.size(), batch.clips.len());
        let weights = &self.state.network.0;
        let packed = network.packed(weights);
        let kinds = self.arm.kinds();
        let word = AddressWord::new(batch.size(), u8::try_from(kinds.max(1)).unwrap_or(u8::MAX));
        let pairs = self.task.scenes.frames - 1;
        let one = |n: usize, (place, answer): (usize, Option<&Maps<f32>>)| {
            let clip = &batch.clips[n];
            let events = told.map_or(0, |told| told.events[n]);
            let mut row = Row {
                arm: self.arm.name.clone(),
                target: self.target,
                seed: self.seed,
                form,
                decoder,
                photograph: clip.name.to_string(),
                clip: first + n as u64,
                events,
                bits: events * u64::from(word.bits()),
                cells: (batch.size().pixels() * pairs) as u64,
                psnr: None,
                ssim: None,
                epe: None,
                off_by_1: None,
                off_by_3: None,
            };
            match self.task.goal {
                Goal::Interpolation => drawn(&mut row, clip, (network.shape(), place), answer),
                Goal::Flow => moved(&mut row, clip, (network.shape(), place), answer),
            }
            row
        };
        let group = |clips: Range<usize>| {
            let answer = (self.arm.sight != Sight::Blend).then(|| {
                let voxels = |n: usize| told.map(|told| &told.voxels[n][..]);
                let given = (self.task, network.shape());
                let input = batch.given(given, clips.clone(), kinds, voxels);
                network.forward(weights, &packed, input).0
            });
            let rows = clips.enumerate();
            rows.map(|(place, n)| one(n, (place, answer.as_ref())))
                .collect::<Vec<_>>()
        };
        let groups: Vec<_> = batch
            .groups(network.shape())
            .into_par_iter()
            .map(group)
            .collect();
        groups.concat()
    }
}

fn told(seen: &Forward<f32>) -> Told {
    let [clips, frames, kinds, height, width] = seen.shape();
    let pixels = height * width;
    let events = |counts: &[i32]| counts.iter().map(|n| u64::from(n.unsigned_abs())).sum();
    Told {
        voxels: { seen.voxels().chunks(frames * kinds * pixels) }
            .map(<[f32]>::to_vec)
            .collect(),
        events: if clips == 0 {
            Vec::new()
        } else {
            let each = (frames - 1) * kinds * pixels;
            seen.counts().chunks(each).map(events).collect()
        },
    }
}

fn drawn(
    row: &mut Row,
    clip: &Clip,
    (shape, place): (&Shape<f32>, usize),
    answer: Option<&Maps<f32>>,
) {
    let Size { height, width } = shape.size();
    let picture = Plane::from_shape_fn((height, width), |(y, x)| {
        let added = answer.map_or(0.0, |maps| maps.row(shape, (place, 0), y)[x]);
        f64::from(
            ((blend(clip, y, x) + added) * 255.0)
                .round()
                .clamp(0.0, 255.0),
        )
    });
    let truth = clip
        .light
        .index_axis(ndarray::Axis(0), clip.middle())
        .mapv(f64::from);
    let square = (&picture - &truth).mapv(|e| e * e).mean().unwrap_or(0.0);
    // Of two equal pictures, that of an error of one step in one pixel of 2^16.
    let least = 1.0 / 65536.0;
    let ln = amacrine::elementary::ln;
    row.psnr = Some(10.0 * ln(255.0 * 255.0 / square.max(least)) / std::f64::consts::LN_10);
    row.ssim = ssim(&picture, &truth);
}

/// Structural similarity (Wang et al. 2004, doi:10.1109/TIP.2003.819861): Gaussian windows of 11x11,
/// sigma 1.5, that lie within the picture; light from 0 to 255. `None` where no window does.
fn ssim(a: &Plane<f64>, b: &Plane<f64>) -> Option<f64> {
    const REACH: usize = 5;
    let line: Vec<f64> = (0..=2 * REACH)
        .map(|i| amacrine::elementary::exp(-(i as f64 - REACH as f64).powi(2) / 4.5))
        .collect();
    let total: f64 = line.iter().sum();
    let (height, width) = a.dim();
    if height <= 2 * REACH || width <= 2 * REACH {
        return None;
    }
    let mean = |value: &dyn Fn(usize, usize) -> f64| {
        let rows = Plane::from_shape_fn((height, width - 2 * REACH), |(y, x)| {
            let sum: f64 = line
                .iter()
                .enumerate()
                .map(|(i, l)| l * value(y, x + i))
                .sum();
            sum / total
        });
        Plane::from_shape_fn((height - 2 * REACH, width - 2 * REACH), |(y, x)| {
            let sum: f64 = line
                .iter()
                .enumerate()
                .map(|(i, l)| l * rows[[y + i, x]])
                .sum();
            sum / total
        })
    };
    let (m, n) = (mean(&|y, x| a[[y, x]]), mean(&|y, x| b[[y, x]]));
    let square = |p: &Plane<f64>, q: &Plane<f64>| mean(&|y, x| p[[y, x]] * q[[y, x]]);
    let (aa, bb, ab) = (square(a, a), square(b, b), square(a, b));
    let (c, d) = ((0.01f64 * 255.0).powi(2), (0.03f64 * 255.0).powi(2));
    let mut sum = 0.0;
    for (at, m) in m.indexed_iter() {
        let n = n[at];
        let (va, vb, cov) = (aa[at] - m * m, bb[at] - n * n, ab[at] - m * n);
        sum += (2.0 * m * n + c) * (2.0 * cov + d) / ((m * m + n * n + c) * (va + vb + d));
    }
    Some(sum / m.len() as f64)
}

fn moved(
    row: &mut Row,
    clip: &Clip,
    (shape, place): (&Shape<f32>, usize),
    answer: Option<&Maps<f32>>,
) {
    let (Some(flow), Some(answer)) = (&clip.flow, answer) else {
        return;
    };
    let pairs = (clip.light.dim().0 - 1) as f64;
    let mut count = 0.0;
    let mut sums = [0.0; 3];
    for ((y, x), _) in flow.seen.indexed_iter().filter(|(_, seen)| **seen) {
        let off = |c: usize, truth: f32| f64::from(answer.row(shape, (place, c), y)[x] - truth);
        let (u, v) = (off(0, flow.u[[y, x]]), off(1, flow.v[[y, x]]));
        let error = (u * u + v * v).sqrt();
        count += 1.0;
        sums[0] += error;
        sums[1] += f64::from(u8::from(error * pairs > 1.0));
        sums[2] += f64::from(u8::from(error * pairs > 3.0));
    }
    if count > 0.0 {
        let [epe, one, three] = sums.map(|sum| sum / count);
        (row.epe, row.off_by_1, row.off_by_3) = (Some(epe), Some(one), Some(three));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn alike_is_one_and_noise_is_less() {
        let picture = Plane::from_shape_fn((24, 20), |(y, x)| ((67 * y + 45 * x) % 200) as f64);
        let ssim = |a: &Plane<f64>, b: &Plane<f64>| super::ssim(a, b).unwrap();
        assert!((ssim(&picture, &picture) - 1.0).abs() < 1e-12);
        let flat = Plane::from_elem((24, 20), 100.0);
        assert!(ssim(&picture, &flat) < 0.1);
        // Two even pictures: only the means count.
        let darker = Plane::from_elem((24, 20), 50.0);
        let c = (0.01f64 * 255.0).powi(2);
        let want = (2.0 * 100.0 * 50.0 + c) / (100.0 * 100.0 + 50.0 * 50.0 + c);
        assert!((ssim(&flat, &darker) - want).abs() < 1e-9);
        let small = Plane::from_elem((10, 24), 100.0);
        assert_eq!(super::ssim(&small, &small), None);
    }
}
