//! The constants of a sensor, which its bands share, and their input in an interval.

use crate::{
    number::Number,
    plane::Size,
    reference::{
        description::Description,
        drive::Weights,
        sheets::Sheets,
        signal::{Light, Padded},
        thresholds::Thresholds,
        train::Interval,
    },
};

/// The constants of a sensor, which all of its bands share.
#[derive(Clone, Debug)]
pub(in crate::reference) struct Plan<N: Number> {
    pub(in crate::reference) number: N,
    pub(in crate::reference) description: Description,
    pub(in crate::reference) seed: u64,
    /// For each channel.
    pub(in crate::reference) weights: Vec<Weights<N::Held>>,
    pub(in crate::reference) memory_weights: Vec<Option<Weights<N::Held>>>,
    pub(in crate::reference) thresholds: Vec<Thresholds<N::Real>>,
}

impl<N: Number> Plan<N> {
    pub(in crate::reference) fn new(
        number: N,
        description: Description,
        size: Size,
        seed: u64,
    ) -> Self {
        let channels = &description.channels;
        let weights = channels
            .iter()
            .map(|c| Weights::new(&number, &c.kernels))
            .collect();
        let memory_weights = channels
            .iter()
            .map(|c| {
                c.memory_kernel
                    .as_ref()
                    .map(|k| Weights::new(&number, std::slice::from_ref(k)))
            })
            .collect();
        let thresholds = channels
            .iter()
            .enumerate()
            .map(|(number, channel)| Thresholds::new(&channel.thresholds, size, seed, number))
            .collect();
        Self {
            number,
            description,
            seed,
            weights,
            memory_weights,
            thresholds,
        }
    }

    pub(super) fn refractory(&self) -> f64 {
        self.description.refractory.us * 1e-6
    }
}

/// The input of all bands in an interval.
#[derive(Debug)]
pub(in crate::reference) struct IntervalInput<'a, N: Number> {
    /// The frame; `None` if the bands have its signal already.
    pub(in crate::reference) light: Option<Light<'a, N>>,
    /// For each channel, where the memory holds pixels: the memory if it steps, the signal's
    /// distance from it if it snaps.
    pub(in crate::reference) pixels: &'a [Padded<N::Held>],
    /// The resistive grids, for channels that see through one.
    pub(in crate::reference) sheets: Option<&'a Sheets>,
    pub(in crate::reference) interval: Interval,
    /// Seconds since the first frame.
    pub(in crate::reference) elapsed: f64,
    /// Whether the times of the events are wanted.
    pub(in crate::reference) times: bool,
}

/// Implemented by hand: derived, it would require `N: Copy`.
impl<N: Number> Copy for IntervalInput<'_, N> {}

#[expect(clippy::expl_impl_clone_on_copy, reason = "as above")]
impl<N: Number> Clone for IntervalInput<'_, N> {
    fn clone(&self) -> Self {
        *self
    }
}
