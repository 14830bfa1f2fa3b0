//! A frame, and the trait of all sources of frames.

use super::{
    checks,
    error::SceneError,
    light::{coding::Light, image::Image},
    observation::{aliasing::Alias, playback::Unlike},
    time::{frame_rate::Rate, slice::Slice},
};
use crate::plane::Size;

/// One picture of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Number of the frame, from 0.
    pub index: u64,
    /// When it was taken, in seconds.
    pub seconds: f64,
    /// Light, `[y, x]`, held as its samples are: 0 to 255 for video and pictures, as given for `.npy`;
    /// [`Outline::coding`] says what was undone.
    pub light: Image,
}

/// Numbers that are missing among those of pictures in a folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Gap {
    /// The number before the first gap.
    pub before: u64,
    /// The number behind it.
    pub after: u64,
    /// How many pictures are missing in all gaps.
    pub missing: u64,
}

impl Gap {
    /// What is missing among numbers in their order, where most go up by the same step.
    pub(super) fn find(numbers: &[u64]) -> Option<Self> {
        let steps: Vec<u64> = { numbers.windows(2) }
            .map(|two| two[1].saturating_sub(two[0]))
            .collect();
        let mut sorted = steps.clone();
        sorted.sort_unstable();
        let usual = *sorted.get(sorted.len() / 2)?;
        let as_usual = steps.iter().filter(|step| **step == usual).count();
        // Numbers that go up by all kinds of steps may be times.
        if usual == 0 || 4 * as_usual < 3 * steps.len() {
            return None;
        }
        let first = steps.iter().position(|step| *step > usual)?;
        let missing = { steps.iter() }.map(|step| (step / usual).saturating_sub(1));
        Some(Self {
            before: numbers[first],
            after: numbers[first + 1],
            missing: missing.sum(),
        })
    }
}

/// What is known of a scene before its frames are taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outline {
    /// Size of every frame.
    pub size: Size,
    /// Frames of the source per second.
    pub fps: f64,
    /// Whether that is [`ASSUMED_FPS`](super::ASSUMED_FPS), because neither the source nor the caller
    /// said one. Whoever shows results should then say so.
    pub fps_is_assumed: bool,
    /// How many frames there are, where that is known beforehand.
    pub frames: Option<u64>,
    /// How its samples became light, and who said so.
    pub coding: Light,
    /// Numbers that are missing among those of its pictures; none where there are none to miss.
    pub gap: Option<Gap>,
    /// What a pattern draws finer than pixels or faster than frames.
    pub alias: Option<Alias>,
    /// How players show it otherwise.
    pub unlike: Option<Unlike>,
    /// Which frames of its clip it is; none where it is all of it.
    pub slice: Option<Slice>,
    /// The most bytes that the source holds while frames are taken from it, the frame that it gives
    /// included.
    pub bytes: u128,
}

impl Outline {
    /// Of light that is drawn, at a rate that was said, of nobody knows how many frames, of which one
    /// is held at a time.
    #[must_use]
    pub const fn new(size: Size, fps: f64) -> Self {
        Self {
            size,
            fps,
            fps_is_assumed: false,
            frames: None,
            coding: Light::DRAWN,
            gap: None,
            alias: None,
            unlike: None,
            slice: None,
            bytes: checks::PIXEL_BYTES_HELD * size.pixels() as u128,
        }
    }

    /// The same, at a rate that may be assumed.
    pub(super) const fn at(rate: Rate, size: Size) -> Self {
        Self {
            fps_is_assumed: rate.assumed,
            ..Self::new(size, rate.fps)
        }
    }
}

/// A source of frames, all of one size.
pub trait Scene: Send {
    /// What is known of it before its frames are taken.
    fn outline(&self) -> Outline;

    /// The next frame; `None` at the end.
    ///
    /// # Errors
    /// When the source cannot be read, or a frame is damaged, of another size, or not finite.
    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError>;

    /// Size of every frame.
    fn size(&self) -> Size {
        self.outline().size
    }

    /// Frames of the source per second.
    fn fps(&self) -> f64 {
        self.outline().fps
    }

    /// How many frames there are, where that is known beforehand.
    fn frames(&self) -> Option<u64> {
        self.outline().frames
    }
}

impl<S: Scene + ?Sized> Scene for Box<S> {
    fn outline(&self) -> Outline {
        (**self).outline()
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError> {
        (**self).next_frame()
    }
}
