//! Clips by number.

use std::sync::Arc;

use amacrine::{
    elementary,
    plane::{Plane, Size},
    rng::Hash,
};
use ndarray::Array3;

use super::{
    clip::{Clip, Flow, middle},
    error::SceneError,
    kept::Kept,
    layer::{Layer, SAMPLES, View, place},
    motion::{Draw, Motion, Reason},
    outline::Outline,
    photographs::{Photograph, Photographs},
    video::Video,
};

/// The layers of a clip, as words of its hash.
const BEHIND: u64 = 1 << 32;
const FRONT: u64 = 2 << 32;

/// What one of the clips that are kept is drawn by, as a word of its hash.
const ANY: u64 = 3 << 32;

/// What a second layer measures from its middle to its outline, in parts of the crop's shorter side.
const RADIUS: [f64; 2] = [0.15, 0.35];

/// How far from the middle of the crop a second layer's middle is at most, in parts of a side.
const OFF_MIDDLE: f64 = 0.35;

/// Clips by number: each is a pure function of the sources, the seed and its number.
#[derive(Clone, Debug)]
pub struct Clips {
    source: Source,
    size: Size,
    frames: usize,
    seed: u64,
    kept: Option<Arc<Kept>>,
}

#[derive(Clone, Debug)]
enum Source {
    Photographs(Photographs, Motion),
    Video(Video),
}

impl Clips {
    /// Photographs that move: a layer behind, and in most clips one in front.
    ///
    /// # Errors
    /// When a photograph is smaller than a crop, a crop has no pixels, or the frames are fewer than
    /// three.
    pub fn new(
        photographs: &Photographs,
        motion: &Motion,
        size: Size,
        frames: usize,
        seed: u64,
    ) -> Result<Self, SceneError> {
        check(size, frames)?;
        photographs.check_crop(size)?;
        Ok(Self {
            source: Source::Photographs(photographs.clone(), motion.clone()),
            size,
            frames,
            seed,
            kept: None,
        })
    }

    /// Pieces of a video: any place, any time.
    ///
    /// # Errors
    /// As for photographs, and when the video is shorter than a clip.
    pub fn of_video(
        video: &Video,
        size: Size,
        frames: usize,
        seed: u64,
    ) -> Result<Self, SceneError> {
        check(size, frames)?;
        video.check(size, frames)?;
        Ok(Self {
            source: Source::Video(video.clone()),
            size,
            frames,
            seed,
            kept: None,
        })
    }

    /// Rows and columns of each frame.
    #[must_use]
    pub const fn size(&self) -> Size {
        self.size
    }

    /// Frames of each clip.
    #[must_use]
    pub const fn frames(&self) -> usize {
        self.frames
    }

    /// The same with so many different clips, each of which is made once: number `n` is any of them,
    /// drawn by `n`. Their flow is kept where `flow` says so. None are kept for 0.
    #[must_use]
    pub fn kept(self, different: u64, flow: bool) -> Self {
        let kept = (different > 0).then(|| Arc::new(Kept::new(different, flow)));
        Self { kept, ..self }
    }

    /// Bytes of the clips that are kept, at most, once so many were drawn.
    #[must_use]
    pub fn bytes_of(&self, draws: usize) -> usize {
        let pixels = self.size.pixels();
        let each = |kept: &Arc<Kept>| {
            let flow = if kept.flow { 9 * pixels } else { 0 };
            kept.places.len().min(draws) * (self.frames * pixels + flow)
        };
        self.kept.as_ref().map_or(0, each)
    }

    /// The photographs that they are of; none of a video's.
    #[must_use]
    pub const fn photographs(&self) -> Option<&Photographs> {
        match &self.source {
            Source::Photographs(photographs, _) => Some(photographs),
            Source::Video(_) => None,
        }
    }

    /// One clip.
    #[must_use]
    pub fn clip(&self, index: u64) -> Clip {
        let Some(kept) = &self.kept else {
            return self.made(index);
        };
        let shape = (self.frames, self.size.height, self.size.width);
        kept.clip(Hash::new(self.seed).with(ANY).with(index), shape, |index| {
            self.made(index)
        })
    }

    fn made(&self, index: u64) -> Clip {
        let draw = Draw(Hash::new(self.seed).with(index));
        match &self.source {
            Source::Photographs(photographs, motion) => self.moved(photographs, motion, draw),
            Source::Video(video) => video.piece(draw, self.size, self.frames),
        }
    }

    fn moved(&self, photographs: &Photographs, motion: &Motion, draw: Draw) -> Clip {
        let all = photographs.all();
        let first = draw.one_of(Reason::Photograph, all.len());
        let behind = &all[first];
        let layers = self.layers((all, first), motion, draw);
        let tone = Tone::new(motion, draw);
        let mut light = Array3::zeros((self.frames, self.size.height, self.size.width));
        let mut canvas = Canvas::new(self.size.width);
        for (n, mut frame) in light.outer_iter_mut().enumerate() {
            let t = n as f64 - middle(self.frames) as f64;
            let views = layers
                .each_ref()
                .map(|layer| layer.as_ref().map(|l| l.at(t, self.size)));
            for (y, mut row) in frame.outer_iter_mut().enumerate() {
                canvas.row(&views, y, |x, light| row[x] = tone.of(light));
            }
        }
        Clip {
            light,
            flow: Some(flow(&layers, self.size)),
            name: Arc::clone(&behind.name),
        }
    }

    /// The layer behind, and the one in front where there is one.
    fn layers<'a>(
        &self,
        (all, first): (&'a [Photograph], usize),
        motion: &Motion,
        draw: Draw,
    ) -> [Option<Layer<'a>>; 2] {
        let Size { height, width } = self.size;
        let middle = [(width - 1) as f64 / 2.0, (height - 1) as f64 / 2.0];
        let own = Draw(draw.0.with(BEHIND));
        let behind = Layer::new(&all[first].light, (own, motion), (self.size, middle), None);
        if draw.part(Reason::Occluded) >= motion.occluder {
            return [Some(behind), None];
        }
        let own = Draw(draw.0.with(FRONT));
        // Another photograph, where there is another.
        let further = 1 + draw.one_of(Reason::PhotographOf, all.len().saturating_sub(1));
        let second = &all[(first + further) % all.len()].light;
        let radius = own.between(Reason::Radius, RADIUS) * height.min(width) as f64;
        let centre = [
            middle[0] + own.either(Reason::CentreX, OFF_MIDDLE) * width as f64,
            middle[1] + own.either(Reason::CentreY, OFF_MIDDLE) * height as f64,
        ];
        let outline = Outline::new(own, radius);
        let front = Layer::new(second, (own, motion), (self.size, centre), Some(outline));
        [Some(behind), Some(front)]
    }
}

fn check(size: Size, frames: usize) -> Result<(), SceneError> {
    if frames < 3 {
        return Err(SceneError::Frames { frames });
    }
    if size.pixels() == 0 {
        return Err(SceneError::Crop { crop: size });
    }
    Ok(())
}

/// Rows of samples, for a frame at a time.
struct Canvas {
    /// The samples of a row of pixels, added up over its rows of samples.
    sums: Vec<f32>,
    light: Vec<f32>,
    front: Vec<f32>,
    cover: Vec<f32>,
}

impl Canvas {
    fn new(width: usize) -> Self {
        let row = || vec![0.0; SAMPLES * width];
        Self {
            sums: row(),
            light: row(),
            front: row(),
            cover: row(),
        }
    }

    /// The mean light of each pixel of a row, given to `take`.
    fn row(&mut self, views: &[Option<View<'_>>; 2], y: usize, mut take: impl FnMut(usize, f32)) {
        self.sums.fill(0.0);
        let count = self.light.len();
        for y in (0..SAMPLES).map(|n| place(SAMPLES * y + n)) {
            let [behind, front] = views;
            if let Some(view) = behind {
                view.light(y, 0..count, &mut self.light);
            }
            if let Some(view) = front {
                let hides = view.cover(y, &mut self.cover);
                // What it hides is written over what is behind.
                let own = &mut self.front[..hides.len()];
                view.light(y, hides.clone(), own);
                let cover = &self.cover[hides.clone()];
                for ((own, cover), light) in own.iter().zip(cover).zip(&mut self.light[hides]) {
                    *light += (own - *light) * cover;
                }
            }
            for (sum, light) in self.sums.iter_mut().zip(&self.light) {
                *sum += light;
            }
        }
        let all = (SAMPLES * SAMPLES) as f32;
        for (x, pixel) in self.sums.chunks_exact(SAMPLES).enumerate() {
            take(x, pixel.iter().sum::<f32>() / all);
        }
    }
}

/// Where each pixel of the middle frame is in the next one.
fn flow(layers: &[Option<Layer<'_>>; 2], size: Size) -> Flow {
    let mut flow = Flow {
        u: Plane::zeros(size.shape()),
        v: Plane::zeros(size.shape()),
        seen: Plane::from_elem(size.shape(), false),
    };
    let steps = layers
        .each_ref()
        .map(|layer| layer.as_ref().map(|l| l.path.forth(1.0)));
    // The layer in front now, and in the next frame.
    let front = [0.0, 1.0].map(|t| {
        let layer = layers[1].as_ref()?;
        Some((layer.path.back(t), layer.path.centre, layer.outline?))
    });
    let hidden = |place: [f64; 2], at: usize| {
        front[at].is_some_and(|(back, [a, b], outline)| {
            let [x, y] = back.at(place);
            outline.holds([x - a, y - b])
        })
    };
    for y in 0..size.height {
        for x in 0..size.width {
            let place = [x as f64, y as f64];
            let own = usize::from(hidden(place, 0));
            let Some(step) = &steps[own] else { continue };
            let to = step.at(place);
            flow.u[(y, x)] = (to[0] - place[0]) as f32;
            flow.v[(y, x)] = (to[1] - place[1]) as f32;
            let within = |v: f64, length: usize| v >= 0.0 && v <= (length - 1) as f64;
            let inside = within(to[0], size.width) && within(to[1], size.height);
            flow.seen[(y, x)] = inside && (own == 1 || !hidden(to, 1));
        }
    }
    flow
}

/// Gamma, gain and eight bits.
struct Tone([f32; 257]);

impl Tone {
    fn new(motion: &Motion, draw: Draw) -> Self {
        let gain = draw.between(Reason::Gain, motion.gain);
        let gamma = draw.between(Reason::Gamma, motion.gamma);
        let value = |v: usize| 255.0 * gain * elementary::pow(v as f64 / 255.0, gamma);
        Self(std::array::from_fn(|v| value(v) as f32))
    }

    fn of(&self, light: f32) -> f32 {
        let low = (light as usize).min(255);
        let part = light - low as f32;
        let value = self.0[low] + part * (self.0[low + 1] - self.0[low]);
        // Not below 0, so that to cut is to round down.
        f32::from((value.min(255.0) + 0.5) as u8)
    }
}
