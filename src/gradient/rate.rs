//! The surface of constant rate: kernels and thresholds with the same number of events.
//!
//! Events cost bits, and a kernel that only makes more of them has learned nothing: at equal bits,
//! the threshold follows a target `C(W, θ) = C*`, and the kernel moves along that surface. With
//! `g = dL/dW`, `c = dC/dW`, and `g_t`, `c_t` the derivatives by `ln θ` (all thresholds scaled
//! together), a step `δ` of the kernel that keeps `C` scales the thresholds by `-(c δ) / c_t`, and so
//! changes the loss by `(g - (g_t / c_t) c) δ`: the reduced gradient.

use crate::{
    elementary,
    plane::Plane,
    reference::{Description, Threshold},
};

use super::{
    backward::{ChannelGradient, Gradient},
    clips::Clips,
    error::GradientError,
    float::Float,
    forward::Forward,
    model::Model,
};

/// The reduced gradient along the surface of constant rate.
#[derive(Clone, Debug, PartialEq)]
pub struct ConstantRate {
    /// For each channel and each kernel of its pattern.
    pub kernels: Vec<Vec<Plane<f64>>>,
    /// What the loss gains for one event more: `g_t / c_t`.
    pub price: f64,
    /// `c_t`: how many events a scaling of all thresholds by `e` adds, to first order; below 0.
    pub events: f64,
}

impl ConstantRate {
    /// The reduced gradient of a loss, given its gradient and that of the number of events; `None`
    /// where the number of events does not fall with the thresholds, so that nothing can be held.
    #[must_use]
    pub fn new<R>(
        description: &Description,
        loss: &Gradient<R>,
        events: &Gradient<R>,
    ) -> Option<Self> {
        let (g, c) = (by_scale(description, loss), by_scale(description, events));
        let price = g / c;
        if c >= 0.0 || !price.is_finite() {
            return None;
        }
        let reduced = |(loss, events): (&ChannelGradient, &ChannelGradient)| {
            let kernels = loss.kernels.iter().zip(&events.kernels);
            kernels.map(|(g, c)| g - &(c * price)).collect()
        };
        let channels = loss.channels.iter().zip(&events.channels);
        Some(Self {
            kernels: channels.map(reduced).collect(),
            price,
            events: c,
        })
    }
}

/// The derivative by the logarithm of a factor that scales all thresholds and their mismatch.
fn by_scale<R>(description: &Description, gradient: &Gradient<R>) -> f64 {
    let channels = description.channels.iter().zip(&gradient.channels);
    channels
        .map(|(channel, gradient)| {
            let of = |n: usize, theta: &Threshold| {
                theta.on * gradient.on[n]
                    + theta.off * gradient.off[n]
                    + theta.sigma * gradient.sigma[n]
            };
            let sides = channel.thresholds.iter().enumerate();
            sides.map(|(n, theta)| of(n, theta)).sum::<f64>()
        })
        .sum()
}

/// A sensor whose thresholds were scaled to a rate.
#[derive(Clone, Debug, PartialEq)]
pub struct Rated {
    /// The sensor, with its thresholds and their mismatch scaled.
    pub description: Description,
    /// By what they were scaled.
    pub scale: f64,
    /// Events a pixel and pair, all channels together.
    pub rate: f64,
}

/// How near to the target is near enough, as a part of it.
const NEAR: f64 = 1e-3;

/// How many steps the search takes at most.
const STEPS: usize = 60;

/// Scales all thresholds of a sensor, and their mismatch, so that it makes `target` events a pixel
/// and pair of these clips.
///
/// Counts are whole, so the rate jumps: where no scale comes within a thousandth, the nearest that the
/// search has seen is given.
///
/// # Errors
/// As [`Model::forward`], and when no scale from 2^-40 to 2^40 makes that many events, or so few.
pub fn rate_threshold<R: Float>(
    description: &Description,
    clips: Clips<'_, R>,
    seed: u64,
    target: f64,
) -> Result<Rated, GradientError> {
    let mut seen = Forward::default();
    let mut rated = |log: f64| {
        let scale = elementary::exp(log);
        let mut description = description.clone();
        for channel in &mut description.channels {
            for threshold in &mut channel.thresholds {
                threshold.on *= scale;
                threshold.off *= scale;
                threshold.sigma *= scale;
            }
        }
        let model = Model::new(description, clips.size(), seed)?;
        model.forward_into(clips, &mut seen)?;
        let rate = seen.rate();
        let description = model.description;
        Ok::<_, GradientError>((
            log,
            Rated {
                description,
                scale,
                rate,
            },
        ))
    };
    let unreachable = |rate| GradientError::Rate { target, rate };
    if !(target > 0.0 && target.is_finite()) {
        return Err(unreachable(f64::NAN));
    }
    let first = rated(0.0)?;
    // Thresholds that make too many events, and too few.
    let rises = first.1.rate < target;
    let mut low = first.clone();
    let mut high = first;
    let mut stride = std::f64::consts::LN_2;
    while if rises {
        low.1.rate < target
    } else {
        high.1.rate > target
    } {
        let edge = if rises { &mut low } else { &mut high };
        if edge.0.abs() > 40.0 * std::f64::consts::LN_2 {
            return Err(unreachable(edge.1.rate));
        }
        let next = rated(edge.0 + if rises { -stride } else { stride });
        // Thresholds so low that events can no longer be counted.
        let Ok(next) = next else {
            return Err(unreachable(edge.1.rate));
        };
        (low, high) = if rises { (next, low) } else { (high, next) };
        stride *= 1.5;
    }
    let miss = |(_, rated): &(f64, Rated)| (rated.rate / target - 1.0).abs();
    for step in 0..STEPS {
        if miss(&low).min(miss(&high)) <= NEAR || high.0 - low.0 < 1e-12 {
            break;
        }
        // Along the line between the two, or where that stalls, halfway.
        let (l, h) = (
            elementary::ln(low.1.rate / target),
            elementary::ln(high.1.rate.max(1e-12) / target),
        );
        let part = if step % 3 == 2 {
            0.5
        } else {
            (l / (l - h)).clamp(0.05, 0.95)
        };
        let next = rated(low.0 + part * (high.0 - low.0))?;
        if next.1.rate >= target {
            low = next;
        } else {
            high = next;
        }
    }
    let nearest = if miss(&low) <= miss(&high) { low } else { high };
    Ok(nearest.1)
}
