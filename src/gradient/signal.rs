//! From light to the signal that the kernels read, and its derivative.

use crate::{
    number::Number,
    photoreceptor::{Curve, LightError, Response},
    plane::Size,
    reference::{Border, signal::Padded},
};

use super::float::Float;

/// The photoreceptors, with the signal of each 8-bit light level.
#[derive(Clone, Debug)]
pub(super) struct Photoreceptors<R> {
    response: Response,
    table: Vec<R>,
}

impl<R: Float> Photoreceptors<R> {
    pub(super) fn new(response: Response) -> Self {
        let signal = |light: u16| R::NUMBER.hold(response.apply(light.into()).unwrap_or(0.0));
        Self {
            response,
            table: (0..256).map(signal).collect(),
        }
    }

    /// The signal of a frame with the rim that kernels reach; the error is where light is that the
    /// response is not defined for.
    pub(super) fn see(
        &self,
        light: &[R],
        (size, reach, border): (Size, (usize, usize), Border),
    ) -> Result<Padded<R>, (usize, usize, LightError)> {
        let mut padded = Padded::new(size, 0..size.height, reach, R::ZERO);
        for (y, light) in light.chunks(size.width).enumerate() {
            padded.fill(y, border, R::ZERO, |out| self.row(y, light, out))?;
        }
        Ok(padded)
    }

    fn row(&self, y: usize, light: &[R], out: &mut [R]) -> Result<(), (usize, usize, LightError)> {
        let number = R::NUMBER;
        let (white, least) = match self.response.curve {
            Curve::Identity => (Some(1.0), f64::MIN),
            Curve::Linear { white } => (Some(white), 0.0),
            Curve::Log { .. } | Curve::LinLog { .. } => (None, 0.0),
        };
        let mut within = true;
        if let (Some(white), false) = (white, self.response.round_f32) {
            for (out, light) in out.iter_mut().zip(light) {
                let light = light.to_f64();
                within &= light >= least && light <= f64::MAX;
                *out = number.hold(light / white);
            }
            if within {
                return Ok(());
            }
        }
        for (x, (out, light)) in out.iter_mut().zip(light).enumerate() {
            let light = light.to_f64();
            let level = light as u8;
            *out = if f64::from(level) == light {
                self.table[usize::from(level)]
            } else {
                number.hold(self.response.apply(light).map_err(|cause| (y, x, cause))?)
            };
        }
        Ok(())
    }

    /// `dR/dI` where the signal is `u`.
    pub(super) fn slope(&self, u: R) -> R {
        let light = self.response.light(u.to_f64());
        R::from_f64(self.response.slope(light))
    }
}
