//! A batch of clips: light over time, as a trainer holds it.

use crate::plane::Size;

use super::{
    error::{GradientError, Tensor},
    float::Float,
};

/// Clips of one size and one set of frame times.
#[derive(Clone, Copy, Debug)]
pub struct Clips<'a, R> {
    light: &'a [R],
    times: &'a [f64],
    size: Size,
}

impl<'a, R: Float> Clips<'a, R> {
    /// Light of shape (clips, frames, rows, columns), and the time of each frame in seconds. The
    /// first frame sets the memory; each later one ends a pair.
    ///
    /// # Errors
    /// When the light has no whole number of clips, or the frames are fewer than two or out of order.
    pub fn new(light: &'a [R], times: &'a [f64], size: Size) -> Result<Self, GradientError> {
        let late = |frame: &usize| match frame {
            0 => !times[0].is_finite(),
            n => !times[*n].is_finite() || times[*n] <= times[n - 1],
        };
        if let Some(frame) = (0..times.len()).find(late) {
            let seconds = times[frame];
            return Err(GradientError::Time { frame, seconds });
        }
        if times.len() < 2 {
            return Err(GradientError::Time {
                frame: times.len(),
                seconds: f64::NAN,
            });
        }
        let clip = times.len() * size.pixels();
        if clip == 0 || !light.len().is_multiple_of(clip) {
            return Err(GradientError::Shape {
                tensor: Tensor::Light,
                got: light.len(),
                want: format!(
                    "a multiple of {} of {size}",
                    crate::unit::counted(times.len(), "frame")
                ),
            });
        }
        Ok(Self { light, times, size })
    }

    /// How many clips.
    #[must_use]
    pub fn count(&self) -> usize {
        self.light.len() / (self.times.len() * self.size.pixels())
    }

    /// The time of each frame, in seconds.
    #[must_use]
    pub const fn times(&self) -> &'a [f64] {
        self.times
    }

    /// Rows and columns.
    #[must_use]
    pub const fn size(&self) -> Size {
        self.size
    }

    /// The light of one frame, row after row.
    pub(super) fn frame(&self, clip: usize, frame: usize) -> &'a [R] {
        let pixels = self.size.pixels();
        let start = (clip * self.times.len() + frame) * pixels;
        &self.light[start..start + pixels]
    }
}
