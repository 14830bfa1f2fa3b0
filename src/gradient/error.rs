//! Why a gradient cannot be computed.

use std::fmt;

use crate::{photoreceptor::LightError, plane::Size, sensor::SensorError};

/// A tensor that the gradient takes or gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tensor {
    /// Light, (clips, frames, rows, columns).
    Light,
    /// The loss's gradient of the voxels, (clips, frames, channels, rows, columns).
    Voxels,
    /// The loss's gradient of the counts, (clips, pairs, channels, rows, columns).
    Counts,
    /// The loss's gradient of the number of events.
    Events,
    /// The gradient of a channel's kernels.
    Kernel {
        /// Which channel.
        channel: usize,
    },
    /// The gradient of a channel's thresholds.
    Thresholds {
        /// Which channel.
        channel: usize,
    },
}

impl fmt::Display for Tensor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Light => write!(f, "the light (clips, frames, rows, columns)"),
            Self::Voxels => write!(
                f,
                "the gradient of the voxels (clips, frames, channels, rows, columns)"
            ),
            Self::Counts => write!(
                f,
                "the gradient of the counts (clips, pairs, channels, rows, columns)"
            ),
            Self::Events => write!(f, "the gradient of the number of events"),
            Self::Kernel { channel } => {
                write!(f, "the gradient of the kernel of channel {channel}")
            }
            Self::Thresholds { channel } => {
                write!(f, "the gradient of the thresholds of channel {channel}")
            }
        }
    }
}

/// Why a gradient cannot be computed.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum GradientError {
    /// A rule of the sensor that has no gradient here.
    #[error("the sensor `{name}` cannot be differentiated: {what}")]
    #[diagnostic(help("{help}"))]
    Rule {
        /// The sensor.
        name: String,
        /// What stands in the way.
        what: &'static str,
        /// What to use instead.
        help: &'static str,
    },
    /// A sensor without pixels, or with more than addresses.
    #[error("a sensor of {size} pixels cannot be addressed")]
    #[diagnostic(help("width and height must be from 1 to 65536"))]
    Size {
        /// The size.
        size: Size,
    },
    /// A sensor that cannot be.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Sensor(#[from] SensorError),
    /// What [`Model::forward`](super::Model::forward) made is not of such a model.
    #[error("what goes back was made by a model of {got}, and this one is of {want}")]
    #[diagnostic(help("go back through the model that went forward"))]
    Forward {
        /// The model that made it.
        got: String,
        /// This model.
        want: String,
    },
    /// A tensor of another number of values.
    #[error("{tensor} has {}, and {want} were expected", crate::unit::counted(*got, "value"))]
    #[diagnostic(help("give it in this order of axes, the last one without gaps"))]
    Shape {
        /// Which tensor.
        tensor: Tensor,
        /// How many values it has.
        got: usize,
        /// How many it should have, in words.
        want: String,
    },
    /// Frames that are not in order of time.
    #[error("frame {frame} is at {seconds} s, not after the frame before it")]
    #[diagnostic(help("give the times of at least two frames in seconds, in order"))]
    Time {
        /// Which frame.
        frame: usize,
        /// Its time.
        seconds: f64,
    },
    /// Light that the response is not defined for.
    #[error(
        "{}: clip {clip}, frame {frame}, y = {y}, x = {x}: {cause}",
        Tensor::Light
    )]
    #[diagnostic(help(
        "give finite light, not below zero; a signal that may be negative needs response = \"identity\""
    ))]
    Light {
        /// Which clip.
        clip: usize,
        /// Which frame.
        frame: usize,
        /// Row.
        y: usize,
        /// Column.
        x: usize,
        /// What is wrong with it.
        #[source]
        cause: LightError,
    },
    /// A cell whose events cannot be counted.
    #[error(
        "clip {clip}, pair {pair}, channel {channel}, y = {y}: a cell is 2^30 thresholds or more from where it began, or what it sees is not a number"
    )]
    #[diagnostic(help("raise the thresholds, or make the kernel smaller"))]
    Cell {
        /// Which clip.
        clip: usize,
        /// Which pair of frames.
        pair: usize,
        /// Kind of cell.
        channel: usize,
        /// Row.
        y: usize,
    },
    /// A rate that no thresholds make.
    #[error(
        "no thresholds make {target} events a pixel and pair of these clips; the nearest were {rate}"
    )]
    #[diagnostic(help(
        "ask for a rate above 0 that the scene's movement can make, or shorten the refractory period"
    ))]
    Rate {
        /// What was asked for.
        target: f64,
        /// What came nearest.
        rate: f64,
    },
    /// NaN or infinity in a tensor.
    #[error("{tensor} {}", found(at, *value))]
    #[diagnostic(help("{}", match tensor {
        Tensor::Kernel { .. } | Tensor::Thresholds { .. } =>
            "what goes in is finite, so a sum has left the format: use f64, or a smaller loss",
        _ => "look at what made it: a loss that divides by zero, or a network that has diverged",
    }))]
    NotFinite {
        /// Which tensor.
        tensor: Tensor,
        /// The index of the first such value; of one number empty.
        at: Vec<usize>,
        /// The value.
        value: f64,
    },
}

/// What a tensor has, and where.
fn found(at: &[usize], value: f64) -> String {
    if at.is_empty() {
        format!("is {value}")
    } else {
        format!("has {value} at {at:?}")
    }
}
