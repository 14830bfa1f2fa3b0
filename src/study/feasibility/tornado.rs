//! The tornado: one number of the chip turned from end to end, all others at their values, and what
//! that changes.

use super::{
    FeasibilityError,
    chips::{Run, Trial},
    named::Named,
};
use crate::{
    compare::CompareError, event::Packet, isa::Evidence, order::Order, program::readout::Demand,
    study::equivalent::Ladder,
};

/// One number turned from end to end, all others at their values.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Turn {
    /// As `section.key`.
    pub figure: String,
    /// Its unit.
    pub unit: &'static str,
    /// The low end of its interval.
    pub low: f64,
    /// The high end.
    pub high: f64,
    /// How well the interval is known.
    pub evidence: Evidence,
    /// What is kept at the low end; none where the scene cannot judge it.
    pub kept_at_low: Option<f64>,
    /// What is kept at the high end; none where the scene cannot judge it.
    pub kept_at_high: Option<f64>,
    /// What is kept with all numbers at their values, on the same stretch; none where the scene
    /// cannot judge it.
    pub kept_nominal: Option<f64>,
    /// Frames a second at most, at the low end.
    pub frames_s_at_low: f64,
    /// Frames a second at most, at the high end.
    pub frames_s_at_high: f64,
}

impl Turn {
    /// What is kept at the low end, at the high end, and with all numbers at their values.
    #[must_use]
    pub fn kept(&self) -> Option<[f64; 3]> {
        Some([self.kept_at_low?, self.kept_at_high?, self.kept_nominal?])
    }

    /// How much is kept at one end more than at the other, or than between; 0 where that cannot be
    /// told.
    #[must_use]
    pub fn swing(&self) -> f64 {
        let Some(ends) = self.kept() else { return 0.0 };
        let most = ends.into_iter().fold(f64::NEG_INFINITY, f64::max);
        most - ends.into_iter().fold(f64::INFINITY, f64::min)
    }

    /// The same of the frame rate, as a part of the larger.
    fn swing_of_rate(&self) -> f64 {
        let [low, high] = [self.frames_s_at_low, self.frames_s_at_high];
        (low - high).abs() / low.max(high)
    }
}

/// Below which loss nothing is to be blamed for it.
pub(super) const LITTLE: f64 = 0.05;

/// Which part of the most is nearly as much.
const NEARLY: f64 = 0.8;

/// Of the rows of a tornado the first and those that change nearly as much of what is kept; none
/// where the first changes little.
#[must_use]
pub fn decisive(tornado: &[Turn]) -> &[Turn] {
    let most = tornado.first().map_or(0.0, Turn::swing);
    let is = |turn: &Turn| turn.swing() >= LITTLE.max(NEARLY * most);
    let last = tornado.iter().position(|turn| !is(turn));
    tornado.get(..last.unwrap_or(tornado.len())).unwrap_or(&[])
}

/// One number at one end of its interval, which another run than the chip of the seed has to
/// show.
pub(super) struct End {
    /// Which of the numbers with an interval.
    number: usize,
    is_high: bool,
}

impl Trial<'_> {
    /// Adds a run for each end of each number that differs from its value and of which events
    /// depend.
    pub(super) fn ends(
        &self,
        numbers: &[Named],
        runs: &mut Vec<Run>,
    ) -> Result<Vec<End>, FeasibilityError> {
        let device = self.question.device;
        let mut ends = Vec::new();
        for (number, named) in numbers.iter().enumerate() {
            let Named::Figure(figure) = *named else {
                continue;
            };
            if !named.is_of_events() {
                continue;
            }
            let [low, high] = named.ends(device);
            for (value, is_high) in [(low, false), (high, true)] {
                if (value - named.value(device)).abs() > 0.0 {
                    ends.push(End { number, is_high });
                    runs.push(Run {
                        device: device.clone().what_if(figure, value)?,
                        seed: self.question.seed,
                    });
                }
            }
        }
        Ok(ends)
    }

    /// What each number changes, the one that changes most first.
    pub(super) fn tornado(
        &self,
        numbers: &[Named],
        ends: &[End],
        packets: &[Packet],
        nominal: &Packet,
        ladder: &Ladder,
    ) -> Result<Vec<Turn>, CompareError> {
        let device = self.question.device;
        let kept_of = |packet| {
            let likeness = ladder.judge(packet)?;
            Ok::<_, CompareError>(likeness.kept.filter(|_| likeness.is_judged()))
        };
        let kept_nominal = kept_of(nominal)?;
        let busy = Demand::new(nominal, self.frames);
        let mut turns = Vec::new();
        for (number, named) in numbers.iter().enumerate() {
            let Some(interval) = named.interval(device) else {
                continue;
            };
            let mut kept = [kept_nominal; 2];
            // What there is to read is what the chip of that end says.
            let mut busy = [(); 2].map(|()| busy.clone());
            for (end, packet) in ends.iter().zip(packets) {
                if end.number == number {
                    let side = usize::from(end.is_high);
                    kept[side] = kept_of(packet)?;
                    busy[side] = Demand::new(packet, self.frames);
                }
            }
            let [low, high] = interval.ends();
            let rate = |end: f64, busy: &Demand| {
                let value = |other: Named| {
                    if other == *named {
                        end
                    } else {
                        other.value(device)
                    }
                };
                self.frames_s(&value, busy)
            };
            turns.push(Turn {
                figure: named.name(),
                unit: named.unit(),
                low,
                high,
                evidence: { named.quantity(device) }
                    .map_or(interval.evidence, crate::isa::Quantity::interval_evidence),
                kept_at_low: kept[0],
                kept_at_high: kept[1],
                kept_nominal,
                frames_s_at_low: rate(low, &busy[0]),
                frames_s_at_high: rate(high, &busy[1]),
            });
        }
        let by = |turn: &Turn| (turn.swing(), turn.swing_of_rate());
        turns.order_by(|a, b| {
            let (a, b) = (by(a), by(b));
            b.0.total_cmp(&a.0).then(b.1.total_cmp(&a.1))
        });
        Ok(turns)
    }
}
