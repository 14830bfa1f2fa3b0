//! The way back: from what a loss asks of voxels and counts to the gradient of what a sensor is made
//! of. `back_pass` takes a piece of a clip back; their sums are added up here, in order.

use rayon::prelude::*;

use crate::plane::Plane;

use super::{
    back_pass::BackPass,
    error::{GradientError, Tensor},
    float::Float,
    forward::Forward,
    light,
    model::{Kind, Model},
    piece::Piece,
    rule::{Rule, Slope},
    sums::ChannelSum,
};

/// What a loss asks: its gradients of what came out.
#[derive(Clone, Copy, Debug)]
pub struct Ask<'a, R> {
    /// Of the voxels, in the shape of [`Forward::voxels`].
    pub voxels: Option<&'a [R]>,
    /// Of the signed counts, in the shape of [`Forward::counts`].
    pub counts: Option<&'a [R]>,
    /// Of the number of events, whatever their sign.
    pub events: f64,
    /// Which cells feel the number of events.
    pub slope: Slope,
    /// Whether the light's gradient is wanted.
    pub light: bool,
}

impl<R> Default for Ask<'_, R> {
    fn default() -> Self {
        Self {
            voxels: None,
            counts: None,
            events: 0.0,
            slope: Slope::All,
            light: false,
        }
    }
}

/// The loss's gradient of what a sensor is made of.
#[derive(Clone, Debug)]
pub struct Gradient<R> {
    /// For each channel.
    pub channels: Vec<ChannelGradient>,
    /// Of the light, (clips, frames, rows, columns); where it was asked for.
    pub light: Option<Vec<R>>,
}

/// The gradient of one channel.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelGradient {
    /// Of its kernel, or of the four of a 2x2 pattern, row 0 north.
    pub kernels: Vec<Plane<f64>>,
    /// Of its ON threshold, or of four, the deviation of the mismatch held: each cell's own threshold
    /// is the nominal one plus its share of that deviation.
    pub on: Vec<f64>,
    /// Of its OFF threshold, a positive magnitude.
    pub off: Vec<f64>,
    /// Of the deviation of the mismatch, which both have.
    pub sigma: Vec<f64>,
    /// With `log-temporal` and [`Rule::Authors`]: of the released code's two multipliers, by which the
    /// logarithm and the memory come into the distance. Otherwise 0.
    pub gains: [f64; 2],
}

impl<R: Float> Model<R> {
    /// The gradient of a loss, from its gradients of what [`Model::forward`] has made.
    ///
    /// # Errors
    /// When `seen` was made by a model of another shape, or holds nothing; when a gradient that is
    /// given has another shape or is not finite, or a sum left the format.
    pub fn backward(
        &self,
        seen: &Forward<R>,
        ask: &Ask<'_, R>,
        rule: Rule,
    ) -> Result<Gradient<R>, GradientError> {
        if rule == Rule::Mean && !matches!(self.kind(), Kind::Step | Kind::Dead) {
            return Err(GradientError::Rule {
                name: self.description.name.clone(),
                what: "the rule `mean` is that of a memory that steps, with a dead time or none",
                help: "use memory = \"filtered-step\" and, with a period, refractory.rule = \"dead-time\"; or another rule of the gradient",
            });
        }
        self.check_made(seen)?;
        shape(seen, Tensor::Voxels, ask.voxels, seen.voxels.len(), 0)?;
        shape(seen, Tensor::Counts, ask.counts, seen.counts.len(), 1)?;
        if !ask.events.is_finite() {
            return Err(GradientError::NotFinite {
                tensor: Tensor::Events,
                at: Vec::new(),
                value: ask.events,
            });
        }
        let pieces = Piece::all(seen.clips, self.size);
        let back = |n: usize| {
            let mut pass = BackPass::new(self, seen, ask, rule, &pieces[n]);
            pass.run(&seen.tapes[n]);
            pass
        };
        let passes = (0..pieces.len()).into_par_iter().map(back);
        let passes: Vec<_> = passes.collect();
        if !passes.iter().all(|pass| pass.finite) {
            numbers(seen, Tensor::Voxels, ask.voxels, 0)?;
            numbers(seen, Tensor::Counts, ask.counts, 1)?;
        }
        let (sums, drives): (Vec<_>, Vec<_>) = passes
            .into_iter()
            .map(|pass| (pass.sums, pass.light))
            .unzip();
        let mut channels = Vec::with_capacity(self.channels());
        for k in 0..self.channels() {
            let mut sum = ChannelSum::new(self, k);
            for piece in &sums {
                sum.add(&piece[k]);
            }
            let gradient = sum.gradient(self, k);
            gradient.check(k)?;
            channels.push(gradient);
        }
        let light = ask
            .light
            .then(|| light::gradient(self, seen, &pieces, &drives));
        Ok(Gradient { channels, light })
    }
}

impl<R: Float> Model<R> {
    /// Whether a model of this shape made it: what it keeps for the way back is laid out so.
    fn check_made(&self, seen: &Forward<R>) -> Result<(), GradientError> {
        let own = self.shape();
        if seen.by == Some(own) {
            return Ok(());
        }
        Err(GradientError::Forward {
            got: seen.by.map_or("nothing".to_owned(), |by| by.to_string()),
            want: own.to_string(),
        })
    }
}

impl ChannelGradient {
    fn check(&self, channel: usize) -> Result<(), GradientError> {
        let fault = |tensor, at, value: f64| GradientError::NotFinite { tensor, at, value };
        for (n, kernel) in self.kernels.iter().enumerate() {
            if let Some(((y, x), value)) = kernel.indexed_iter().find(|(_, v)| !v.is_finite()) {
                return Err(fault(Tensor::Kernel { channel }, vec![n, y, x], *value));
            }
        }
        for (side, values) in [&self.on, &self.off, &self.sigma].into_iter().enumerate() {
            if let Some(n) = values.iter().position(|v| !v.is_finite()) {
                return Err(fault(
                    Tensor::Thresholds { channel },
                    vec![side, n],
                    values[n],
                ));
            }
        }
        Ok(())
    }
}

/// Whether a gradient has the shape of what it is a gradient of, which has `less` planes in time than
/// there are frames.
fn shape<R: Float>(
    seen: &Forward<R>,
    tensor: Tensor,
    values: Option<&[R]>,
    want: usize,
    less: usize,
) -> Result<(), GradientError> {
    let Some(values) = values.filter(|values| values.len() != want) else {
        return Ok(());
    };
    let [clips, frames, channels, height, width] = seen.shape();
    let shape = [clips, frames.saturating_sub(less), channels, height, width];
    Err(GradientError::Shape {
        tensor,
        got: values.len(),
        want: format!("{want}, {shape:?},"),
    })
}

/// Whether a gradient of such a shape is finite; the error names the first value that is not.
fn numbers<R: Float>(
    seen: &Forward<R>,
    tensor: Tensor,
    values: Option<&[R]>,
    less: usize,
) -> Result<(), GradientError> {
    let values = values.unwrap_or_default();
    let Some(n) = values.iter().position(|v| !v.to_f64().is_finite()) else {
        return Ok(());
    };
    let [clips, frames, channels, height, width] = seen.shape();
    let shape = [clips, frames.saturating_sub(less), channels, height, width];
    let mut at = vec![0; shape.len()];
    let mut rest = n;
    for (at, side) in at.iter_mut().zip(shape).rev() {
        (*at, rest) = (rest % side, rest / side);
    }
    let value = values[n].to_f64();
    Err(GradientError::NotFinite { tensor, at, value })
}
