//! From light to the signal that the kernels read, and its derivative.

use multiversion::multiversion;

use crate::{
    number::{Number, Real},
    photoreceptor::{Curve, LightError, Response},
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

    /// Leaves the signal of a frame, and the rim that kernels reach; the error is where light is that
    /// the response is not defined for.
    pub(super) fn see(
        &self,
        light: &[R],
        border: Border,
        out: &mut Padded<R>,
    ) -> Result<(), (usize, usize, LightError)> {
        for (y, light) in light.chunks(out.size().width).enumerate() {
            out.fill(y, border, R::ZERO, |row| self.row(y, light, row))?;
        }
        Ok(())
    }

    fn row(&self, y: usize, light: &[R], out: &mut [R]) -> Result<(), (usize, usize, LightError)> {
        let number = R::NUMBER;
        let (white, least) = match self.response.curve {
            Curve::Identity => (Some(1.0), f64::MIN),
            Curve::Linear { white } => (Some(white), 0.0),
            Curve::Log { .. } | Curve::LinLog { .. } => (None, 0.0),
        };
        if let (Some(white), false) = (white, self.response.round_f32) {
            let own = R::from_f64(white);
            let within = if own.to_f64() == white {
                divide(light, own, R::from_f64(least), out)
            } else {
                let mut within = true;
                for (out, light) in out.iter_mut().zip(light) {
                    let light = light.to_f64();
                    within &= light >= least && light <= f64::MAX;
                    *out = number.hold(light / white);
                }
                within
            };
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

/// Light over white, and whether all of it is finite and at least `least`. A quotient of two f32 that
/// is first rounded to f64 is the same: 53 bits are at least twice 24 and two (Figueroa, "When is
/// double rounding innocuous?", SIGNUM 1995).
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn divide<R: Real>(light: &[R], white: R, least: R, out: &mut [R]) -> bool {
    let mut within = true;
    for (out, &light) in out.iter_mut().zip(light) {
        within &= light >= least;
        within &= light * R::ZERO == R::ZERO;
        *out = light / white;
    }
    within
}
