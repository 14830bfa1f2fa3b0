//! One way to read a frame's events, with its time.

use std::ops::RangeInclusive;

use super::Way;

/// One way to read a frame's events.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The way.
    pub way: Way,
    /// Calls of the host's operation.
    pub calls: u64,
    /// Slots of each call, where it takes any.
    pub slots: Option<u64>,
    /// Rows of each call, from the top, where it reads any.
    pub rows: Option<RangeInclusive<u64>>,
    /// The least and the most time a frame, us: what else the host does included.
    pub us: [f64; 2],
    /// Share of the expected events that do not leave the chip, 1 for a summary; none where nobody
    /// says how many there are.
    pub lost: Option<f64>,
}

impl Plan {
    /// Whether every event that is expected leaves the chip.
    fn loses_nothing(&self) -> bool {
        self.lost == Some(0.0)
    }

    /// Frames a second at most, with so much time on the array beside it: the least and the most.
    #[must_use]
    pub fn frames_s(&self, array_us: [f64; 2]) -> [f64; 2] {
        let ends = [1, 0].map(|end| 1e6 / (array_us[end] + self.us[end]));
        // Nothing to run and nothing to read takes no time; that is no rate.
        ends.map(|rate| if rate.is_finite() { rate } else { 0.0 })
    }
}

/// Index of the cheapest of the plans that lose nothing, by its longest time.
#[must_use]
pub fn choose(plans: &[Plan]) -> Option<usize> {
    let lossless = plans
        .iter()
        .enumerate()
        .filter(|(_, it)| it.loses_nothing());
    lossless
        .min_by(|(_, a), (_, b)| a.us[1].total_cmp(&b.us[1]))
        .map(|(at, _)| at)
}
