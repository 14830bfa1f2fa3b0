//! Everything that a sensor file states.

use crate::{event::kind_names, photoreceptor::Response, reference::noise::Noise};

use super::{
    channel::Channel,
    rules::{Border, MemoryRule, PolarityRule, Refractory},
};

/// Everything that makes one sensor different from another.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// What it is called.
    pub name: String,
    /// From light to signal.
    pub response: Response,
    /// What an event does to the memory.
    pub memory: MemoryRule,
    /// Whether all kinds of a pixel have one memory of it; only with [`MemoryRule::RawSnap`].
    pub shared: bool,
    /// Where an event's sign comes from.
    pub polarity: PolarityRule,
    /// What lies off the array.
    pub border: Border,
    /// How long a cell is silent after an event.
    pub refractory: Refractory,
    /// What disturbs it.
    pub noise: Noise,
    /// The kinds of cells, at least one.
    pub channels: Vec<Channel>,
}

impl Description {
    /// What the kinds of cells are called, for packets and files: of several, of which one has a
    /// name; none otherwise.
    #[must_use]
    pub fn names(&self) -> Vec<String> {
        kind_names(self.channels.iter().map(|kind| kind.name.as_deref()))
    }

    /// Of the kind of cells that comes nearest to firing: its least threshold, and the most by which
    /// what it sees can move in light from 0 to 255. None where other things than kernels and the
    /// response decide that.
    #[must_use]
    pub fn reach(&self) -> Option<[f64; 2]> {
        let [dark, bright] = [0.0, 255.0].map(|light| self.response.apply(light).ok());
        let signal = bright? - dark?;
        let mut nearest: Option<[f64; 2]> = None;
        for kind in &self.channels {
            if kind.surrounds.is_some() || kind.memory_kernel.is_some() || kind.log_temporal {
                return None;
            }
            for (kernel, threshold) in kind.kernels.iter().zip(&kind.thresholds) {
                let least = threshold.on.min(threshold.off);
                let most = kernel.magnitude() * signal;
                if nearest.is_none_or(|[other, moves]| most * other > moves * least) {
                    nearest = Some([least, most]);
                }
            }
        }
        nearest
    }
}
