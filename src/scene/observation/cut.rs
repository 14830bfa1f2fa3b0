//! Cuts: frames that show another picture than the one before, where every pixel may fire.
//!
//! A frame is one where the light of the pixels changes by more than [`RATIO`] times what it
//! usually does there (the median of the changes up to [`NEAR`] frames before and after), and
//! what is seen at a place no longer resembles what was seen there (Pearson's correlation below
//! [`ALIKE`]), with a part of the pixels changed ([`CHANGED`]) at least. A flash changes much and keeps the picture; fast motion loses the picture, but
//! frame after frame, so that of frames within [`APART`] none is a cut. The frames between two cuts
//! are looked at again by themselves. Some thousand pixels of a frame are looked at.

use std::{iter, ops::Range};

use crate::{plane::Size, scene::Image};

/// How many times the usual change a cut is, at least.
const RATIO: f64 = 3.0;

/// Pictures that correlate by less are two.
const ALIKE: f64 = 0.65;

/// A new picture changes at least this part of the pixels.
const CHANGED: f64 = 0.25;

/// Two frames that are nearer each other are no cuts, but something that passes close by.
const APART: u64 = 3;

/// Changes on either side that say what is usual.
const NEAR: usize = 12;

/// Fewer pixels do not make a picture.
const FEWEST: usize = 256;

/// Pixels of a frame that are looked at, about.
const LOOKED_AT: usize = 4096;

/// Frames that are looked at; a clip that is longer is not looked at to its end.
const MOST: usize = 1 << 20;

/// A frame that does not go on from the one before.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Cut {
    /// The first frame of the new picture.
    pub frame: u64,
    /// When it is shown.
    pub seconds: f64,
    /// The mean change of a pixel's light, as a multiple of the usual one; none where usually
    /// nothing changes.
    pub times_usual: Option<f64>,
    /// Correlation with the frame before.
    pub correlation: f64,
}

/// Looks for cuts, frame by frame.
#[derive(Clone, Debug, Default)]
pub(super) struct Cuts {
    before: Vec<f64>,
    /// Of each frame but the first.
    changes: Vec<Change>,
}

#[derive(Clone, Copy, Debug)]
struct Change {
    seconds: f64,
    mean: f64,
    /// The part of the pixels whose light changes.
    part: f64,
    correlation: f64,
}

impl Cuts {
    /// The next frame.
    pub fn see(&mut self, light: &Image, seconds: f64) {
        let Size { height, width } = light.size();
        let pixels = height * width;
        if pixels < FEWEST || self.changes.len() == MOST {
            return;
        }
        let step = (pixels as f64 / LOOKED_AT as f64).sqrt().ceil().max(1.0) as usize;
        let row = |y: usize| (0..width).step_by(step).map(move |x| y * width + x);
        let places = (0..height).step_by(step).flat_map(row);
        let looked: Vec<f64> = places.map(|pixel| light.at(pixel)).collect();
        if self.before.len() == looked.len() {
            self.changes.push(Change {
                seconds,
                mean: mean_change(&self.before, &looked),
                part: changed(&self.before, &looked),
                correlation: correlation(&self.before, &looked),
            });
        }
        self.before = looked;
    }

    /// The cuts among the frames that were seen, and those among the frames between two of them:
    /// whoever splits the clip there shows these frames alone, which are the usual ones then.
    pub fn found(&self) -> Vec<Cut> {
        let mut cuts = Vec::new();
        let mut parts: Vec<_> = iter::once(0..self.changes.len() + 1).collect();
        while let Some(part) = parts.pop() {
            let own = self.within(&part);
            let inner = || own.iter().map(|cut| cut.frame as usize);
            if !own.is_empty() {
                let starts = iter::once(part.start).chain(inner());
                let ends = inner().chain([part.end]);
                parts.extend(starts.zip(ends).map(|(start, end)| start..end));
            }
            cuts.extend(own);
        }
        cuts.sort_by_key(|cut| cut.frame);
        cuts
    }

    /// The cuts of these frames, as if there were no others.
    fn within(&self, frames: &Range<usize>) -> Vec<Cut> {
        let changes = &self.changes[frames.start..frames.end - 1];
        let found = changes.iter().enumerate().filter_map(|(at, change)| {
            let usual = usual(changes, at)?;
            let is_other = change.correlation < ALIKE && change.part >= CHANGED;
            let is_cut = is_other && change.mean > RATIO * usual;
            is_cut.then(|| Cut {
                frame: (frames.start + at + 1) as u64,
                seconds: change.seconds,
                times_usual: (usual > 0.0).then(|| change.mean / usual),
                correlation: change.correlation,
            })
        });
        let found: Vec<Cut> = found.collect();
        let is_alone = |at: usize| {
            let near = |other: usize| {
                { found.get(other) }.is_some_and(|cut| cut.frame.abs_diff(found[at].frame) < APART)
            };
            !near(at + 1) && !near(at.wrapping_sub(1))
        };
        let alone = (0..found.len()).filter(|at| is_alone(*at));
        alone.map(|at| found[at]).collect()
    }
}

/// The median of the changes beside one.
fn usual(changes: &[Change], at: usize) -> Option<f64> {
    let from = at.saturating_sub(NEAR);
    let to = (at + NEAR + 1).min(changes.len());
    let beside = (from..to).filter(|other| *other != at);
    let mut means: Vec<f64> = beside.map(|other| changes[other].mean).collect();
    means.sort_by(f64::total_cmp);
    means.get(means.len() / 2).copied()
}

fn mean_change(a: &[f64], b: &[f64]) -> f64 {
    let sum: f64 = a.iter().zip(b).map(|(a, b)| (b - a).abs()).sum();
    sum / a.len() as f64
}

fn changed(a: &[f64], b: &[f64]) -> f64 {
    let changed = a.iter().zip(b).filter(|(a, b)| a != b);
    changed.count() as f64 / a.len() as f64
}

/// Pearson's; between two even frames 1, between an even one and a picture 0.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len() as f64;
    let mean = |v: &[f64]| v.iter().sum::<f64>() / n;
    let (mean_a, mean_b) = (mean(a), mean(b));
    let (mut aa, mut bb, mut ab) = (0.0, 0.0, 0.0);
    for (a, b) in a.iter().zip(b) {
        let (a, b) = (a - mean_a, b - mean_b);
        aa += a * a;
        bb += b * b;
        ab += a * b;
    }
    if aa > 0.0 && bb > 0.0 {
        ab / (aa.sqrt() * bb.sqrt())
    } else if aa == bb {
        1.0
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::Plane;

    /// A pixel of a picture of random ones, number `picture` of them.
    fn pixel(picture: u64, (y, x): (usize, usize)) -> f64 {
        let place = (picture << 32) | (y * 32 + x) as u64;
        let place = place.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let mixed = (place ^ (place >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (mixed >> 56) as f64
    }

    /// Such a picture, with a line that moves.
    fn frame(picture: u64, at: usize) -> Plane<f64> {
        Plane::from_shape_fn((32, 32), |(y, x)| match x {
            line if line == at % 32 => 255.0,
            _ => pixel(picture, (y, x)),
        })
    }

    fn found(frames: impl IntoIterator<Item = Plane<f64>>) -> Vec<u64> {
        let mut cuts = Cuts::default();
        for (n, frame) in frames.into_iter().enumerate() {
            cuts.see(&frame.into(), n as f64);
        }
        cuts.found().iter().map(|cut| cut.frame).collect()
    }

    #[test]
    fn another_picture_is_a_cut() {
        let clip = (0..20).map(|n| frame(u64::from(n >= 8) + 1, n));
        assert_eq!(found(clip), [8]);
        assert!(found((0..20).map(|n| frame(1, n))).is_empty());
        let clip = (0..40).map(|n| frame(1 + u64::from(n >= 8) + u64::from(n >= 11), n));
        assert_eq!(found(clip), [8, 11]);
        // What covers the picture for a frame or two passes by.
        let clip = (0..40).map(|n| frame(1 + u64::from(n == 8) + 2 * u64::from(n == 9), n));
        assert!(found(clip).is_empty());
        // Slides: each is another picture, and that is usual.
        assert!(found((0..20).map(|n| frame(n as u64 + 1, n))).is_empty());
    }

    /// A picture that stays, a frame of which half is another one, and then a scene in which a quarter
    /// of the pixels changes from frame to frame: beside these the half is nothing unusual, and beside
    /// what stayed it is.
    #[test]
    fn the_frames_between_two_cuts_have_none_by_themselves() {
        let picture = |n: usize, x: usize| match n {
            0..32 => 1,
            32 => 1 + x as u64 % 2,
            _ => 3 + (n + x) as u64 / 4,
        };
        let shown =
            |n: usize| Plane::from_shape_fn((32, 32), |(y, x)| pixel(picture(n, x), (y, x)));
        let clip: Vec<_> = (0..60).map(shown).collect();
        let cuts = found(clip.clone());
        assert_eq!(cuts, [32, 33]);
        let mut rest = clip.as_slice();
        for (at, cut) in cuts.iter().enumerate().rev() {
            let (before, after) = rest.split_at(*cut as usize);
            assert!(found(after.to_vec()).is_empty(), "from {cut} on");
            assert_eq!(found(before.to_vec()), cuts[..at]);
            rest = before;
        }
    }

    #[test]
    fn a_flash_is_none() {
        let dim = |n: usize| frame(1, 0).mapv(|v| if n == 8 { v * 0.3 } else { v });
        assert!(found((0..20).map(dim)).is_empty());
        let even = |n: usize| Plane::from_elem((32, 32), if n < 8 { 10.0 } else { 200.0 });
        assert!(found((0..20).map(even)).is_empty());
        // Nor is a spot in an even picture.
        let spot = |n: usize| {
            Plane::from_shape_fn(
                (32, 32),
                |at| {
                    if n >= 8 && at == (4, 4) { 250.0 } else { 128.0 }
                },
            )
        };
        assert!(found((0..20).map(spot)).is_empty());
    }
}
