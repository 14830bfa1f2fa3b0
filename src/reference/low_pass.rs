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
}

impl LowPass {
    pub(super) fn new(size: Size) -> Self {
        Self {
            state: Plane::zeros(size.shape()),
        }
    }

    /// Filters the response to `frame`, `dt` seconds after the last (infinite at first).
    pub(super) fn see(
        &mut self,
        description: &Description,
        frame: &Frame,
        dt: f64,
    ) -> Result<(), SensorError> {
        let light: &Plane<f64> = &frame.light;
        for ((y, x), state) in self.state.indexed_iter_mut() {
            let light = light[[y, x]];
            let index = frame.index;
            let signal = description.response.apply(light);
            let signal = signal.map_err(|cause| SensorError::Light { index, y, x, cause })?;
            *state += description.noise.low_pass(light, dt) * (signal - *state);
        }
        Ok(())
    }

    /// Row `y` of the filtered signal.
    pub(super) fn row(&self, y: usize) -> ArrayView1<'_, f64> {
        self.state.row(y)
    }
}
