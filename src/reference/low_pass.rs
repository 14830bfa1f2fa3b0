//! Photoreceptors of finite bandwidth; [`super::noise`] has the equation.

use ndarray::ArrayView1;

use crate::{
    plane::{Plane, Size},
    scene::Frame,
    sensor::SensorError,
};

use super::description::Description;

/// A first-order low-pass filter for each pixel, settled at the first frame.
#[derive(Clone, Debug)]
pub(super) struct LowPass {
    state: Plane<f64>,
    /// In the frame before.
    pixels: Plane<Pixel>,
}

/// A pixel's light, and the response to it.
#[derive(Clone, Copy, Debug, Default)]
struct Pixel {
    light: f64,
    signal: f64,
}

impl LowPass {
    pub(super) fn new(size: Size) -> Self {
        Self {
            state: Plane::zeros(size.shape()),
            pixels: Plane::default(size.shape()),
        }
    }

    /// Filters the response to `frame`, `passed` seconds after the last; none at first.
    pub(super) fn see(
        &mut self,
        description: &Description,
        frame: &Frame,
        passed: Option<f64>,
    ) -> Result<(), SensorError> {
        let light: &Plane<f64> = &frame.light;
        let pixels = self.pixels.iter_mut().zip(self.state.iter_mut());
        for (((y, x), &now), (before, state)) in light.indexed_iter().zip(pixels) {
            let index = frame.index;
            let signal = description.response.apply(now);
            let signal = signal.map_err(|cause| SensorError::Light { index, y, x, cause })?;
            if let Some(dt) = passed {
                let (nears, joins) = description.noise.low_pass((before.light, now), dt);
                *state += nears * (before.signal - *state) + joins * (signal - before.signal);
            } else {
                *state = signal;
            }
            *before = Pixel { light: now, signal };
        }
        Ok(())
    }

    /// Row `y` of the filtered signal.
    pub(super) fn row(&self, y: usize) -> ArrayView1<'_, f64> {
        self.state.row(y)
    }
}
