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
    layer::{Layer, SAMPLES, View},
    motion::{Draw, Motion, Reason},
    outline::Outline,
    photographs::{Photograph, Photographs},
    video::Video,
};

/// The layers of a clip, as words of its hash.
const BEHIND: u64 = 1 << 32;
const FRONT: u64 = 2 << 32;

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

    /// One clip.
    #[must_use]
    pub fn clip(&self, index: u64) -> Clip {
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
        for (n, mut frame) in light.outer_iter_mut().enumerate() {
            let t = n as f64 - middle(self.frames) as f64;
            let views = layers
                .each_ref()
                .map(|layer| layer.as_ref().map(|l| l.at(t, self.size)));
            for ((y, x), pixel) in frame.indexed_iter_mut() {
                *pixel = tone.of(mean(&views, x, y));
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

/// The mean light of a pixel.
fn mean(views: &[Option<View<'_>>; 2], x: usize, y: usize) -> f32 {
    let mut sum = 0.0;
    for j in 0..SAMPLES {
        for i in 0..SAMPLES {
            let place = |at: usize, n: usize| at as f32 + (n as f32 + 0.5) / SAMPLES as f32 - 0.5;
            let (x, y) = (place(x, i), place(y, j));
            let [behind, front] = views.each_ref().map(Option::as_ref);
            let cover = front.map_or(0.0, |view| view.cover(x, y));
            if cover < 1.0 {
                sum += behind.map_or(0.0, |view| view.light(x, y)) * (1.0 - cover);
            }
            if cover > 0.0 {
                sum += front.map_or(0.0, |view| view.light(x, y)) * cover;
            }
        }
    }
    sum / (SAMPLES * SAMPLES) as f32
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
    let front = layers[1].as_ref();
    let hidden = |place: [f64; 2], t: f64| {
        front.is_some_and(|layer| {
            let [x, y] = layer.path.back(t).at(place);
            let [a, b] = layer.path.centre;
            layer
                .outline
                .is_some_and(|outline| outline.holds([x - a, y - b]))
        })
    };
    for y in 0..size.height {
        for x in 0..size.width {
            let place = [x as f64, y as f64];
            let own = usize::from(hidden(place, 0.0));
            let Some(step) = &steps[own] else { continue };
            let to = step.at(place);
            flow.u[(y, x)] = (to[0] - place[0]) as f32;
            flow.v[(y, x)] = (to[1] - place[1]) as f32;
            let within = |v: f64, length: usize| v >= 0.0 && v <= (length - 1) as f64;
            let inside = within(to[0], size.width) && within(to[1], size.height);
            flow.seen[(y, x)] = inside && (own == 1 || !hidden(to, 1.0));
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
        value.round().clamp(0.0, 255.0)
    }
}
