//! Binning: events into voxels and counts, in closed form.
//!
//! Bins are centred on the frames. An event at `u` (0 at the earlier frame of its pair, 1 at
//! the later) gives `1 - u` to the earlier bin and `u` to the later, as in the paper's Eq. 5-8
//! (bilinear binning). A train of `N` events at `u_0 + i s` therefore gives, without a loop,
//!
//! ```text
//! later   = N u_0 + s N (N - 1) / 2
//! earlier = N - later
//! ```
//!
//! with the sign of its events.

use crate::{
    plane::{Plane, Size},
    sensor::SensorError,
};

use super::train::{Cell, Pair, Sink, Train};

/// The two bins that the current pair of frames lies between; `[channel][y, x]`.
#[derive(Clone, Debug)]
pub struct VoxelGrid {
    earlier: Vec<Plane<f64>>,
    later: Vec<Plane<f64>>,
}

impl VoxelGrid {
    /// Empty bins.
    #[must_use]
    pub fn new(size: Size, channels: usize) -> Self {
        let empty = vec![Plane::zeros(size.shape()); channels];
        Self {
            earlier: empty.clone(),
            later: empty,
        }
    }

    /// Takes out the earlier bin, which no later event can reach, and moves on by one frame.
    pub fn advance(&mut self) -> Vec<Plane<f64>> {
        let empty = vec![Plane::zeros(self.later[0].dim()); self.later.len()];
        let next = std::mem::replace(&mut self.later, empty);
        std::mem::replace(&mut self.earlier, next)
    }
}

/// What a train gives to the bins of the earlier and the later frame.
#[must_use]
pub fn bins(train: &Train) -> (f64, f64) {
    let n = train.count as f64;
    let later = n * train.first + train.spacing * (n * (n - 1.0) / 2.0);
    let sign = f64::from(train.polarity.sign());
    (sign * (n - later), sign * later)
}

impl Sink for VoxelGrid {
    fn begin(&mut self, _: Pair) {}

    fn train(&mut self, cell: Cell, train: Train) -> Result<(), SensorError> {
        let (earlier, later) = bins(&train);
        self.earlier[cell.channel][[cell.y, cell.x]] += earlier;
        self.later[cell.channel][[cell.y, cell.x]] += later;
        Ok(())
    }
}

/// Signed events of each cell in the current pair; `[channel][y, x]`.
#[derive(Clone, Debug)]
pub struct Counts {
    planes: Vec<Plane<i32>>,
}

impl Counts {
    /// No events yet.
    #[must_use]
    pub fn new(size: Size, channels: usize) -> Self {
        Self {
            planes: vec![Plane::zeros(size.shape()); channels],
        }
    }

    /// The counts of the current pair, one plane for each channel.
    #[must_use]
    pub fn planes(&self) -> &[Plane<i32>] {
        &self.planes
    }
}

impl Sink for Counts {
    fn begin(&mut self, _: Pair) {
        for plane in &mut self.planes {
            plane.fill(0);
        }
    }

    fn train(&mut self, cell: Cell, train: Train) -> Result<(), SensorError> {
        let to = &mut self.planes[cell.channel][[cell.y, cell.x]];
        let count = i128::from(*to) + train.signed_count();
        *to = i32::try_from(count).map_err(|_| SensorError::CountOverflow {
            channel: cell.channel,
            y: cell.y,
            x: cell.x,
            count,
        })?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::event::Polarity;
    use proptest::prelude::*;

    proptest! {
        /// The slow twin: event by event.
        #[test]
        fn closed_form_is_the_sum_over_events(count in 1u64..500, first in 0.0f64..1.0, room in 0.0f64..1.0, on: bool) {
            let spacing = room * (1.0 - first) / count as f64;
            let polarity = if on { Polarity::On } else { Polarity::Off };
            let train = Train { polarity, count, first, spacing };
            let (mut earlier, mut later) = (0.0, 0.0);
            for i in 0..count {
                let u = first + spacing * i as f64;
                earlier += f64::from(polarity.sign()) * (1.0 - u);
                later += f64::from(polarity.sign()) * u;
            }
            let (e, l) = bins(&train);
            prop_assert!((e - earlier).abs() < 1e-9 * count as f64);
            prop_assert!((l - later).abs() < 1e-9 * count as f64);
        }
    }
}
