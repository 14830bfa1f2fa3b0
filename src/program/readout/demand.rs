//! How many events a frame has, and in which rows.

use std::{collections::BTreeMap, ops::RangeInclusive};

use crate::event::{Packet, Polarity};

/// The events of the frames that a readout has to carry.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Demand {
    /// The largest of the counts of a frame, of every frame, from the busiest on; of several runs the
    /// most of any.
    most: Vec<u64>,
    /// What was counted, run by run.
    runs: Vec<Counted>,
    /// The rows that have events, from the top.
    rows: Option<RangeInclusive<u64>>,
    /// Whether it was counted over frames; else it is one number that was given.
    is_counted: bool,
}

/// The events of one run.
#[derive(Clone, Debug, Default, PartialEq)]
struct Counted {
    /// All events.
    events: u64,
    /// The events of each sign and kind of each frame that has any.
    counts: Vec<u64>,
}

impl Counted {
    /// Share of the events beyond so many slots for each sign and kind.
    fn lost(&self, slots: u64) -> f64 {
        let beyond = self.counts.iter().map(|count| count.saturating_sub(slots));
        beyond.sum::<u64>() as f64 / self.events.max(1) as f64
    }
}

impl Demand {
    /// Of a packet of so many frames.
    #[must_use]
    pub fn new(packet: &Packet, frames: u64) -> Self {
        let mut most = Vec::new();
        let mut all = Vec::new();
        for frame in packet.events.chunk_by(|a, b| a.t == b.t) {
            let mut counts = BTreeMap::new();
            for event in frame {
                let scan = (event.channel, event.polarity == Polarity::On);
                *counts.entry(scan).or_insert(0) += 1;
            }
            most.push(counts.values().copied().max().unwrap_or(0));
            all.extend(counts.into_values());
        }
        most.sort_unstable_by_key(|count| std::cmp::Reverse(*count));
        // Frames without an event are frames too; the first one has nothing to compare with.
        most.resize(most.len().max(frames.saturating_sub(1) as usize), 0);
        let rows = || packet.events.iter().map(|event| u64::from(event.y));
        Self {
            most,
            runs: vec![Counted {
                events: packet.events.len() as u64,
                counts: all,
            }],
            rows: rows().min().zip(rows().max()).map(|(top, end)| top..=end),
            is_counted: true,
        }
    }

    /// At most so many events in a frame, in rows that nobody knows. All of them may be of one
    /// sign and kind.
    #[must_use]
    pub fn expected(events: u64) -> Self {
        Self {
            most: vec![events],
            runs: vec![Counted {
                events,
                counts: vec![events],
            }],
            rows: None,
            is_counted: false,
        }
    }

    /// What serves this run and another of the same frames: the most of either.
    #[must_use]
    pub fn and(mut self, other: Self) -> Self {
        let frames = self.most.len().max(other.most.len());
        self.most.resize(frames, 0);
        for (most, own) in self.most.iter_mut().zip(&other.most) {
            *most = (*most).max(*own);
        }
        self.runs.extend(other.runs);
        self.rows = match (self.rows, other.rows) {
            (Some(a), Some(b)) => Some(*a.start().min(b.start())..=*a.end().max(b.end())),
            (a, b) => a.or(b),
        };
        self.is_counted &= other.is_counted;
        self
    }

    /// The most of one sign and kind in a frame.
    #[must_use]
    pub fn busiest(&self) -> u64 {
        self.most.first().copied().unwrap_or(0)
    }

    /// What 99 % of the frames stay within; none where frames were not counted.
    #[must_use]
    pub fn ninety_nine(&self) -> Option<u64> {
        let at = self.most.len() / 100;
        self.is_counted
            .then(|| self.most.get(at).copied().unwrap_or(0))
    }

    /// Share of the events beyond so many slots for each sign and kind, of the run that loses most.
    #[must_use]
    pub fn lost(&self, slots: u64) -> f64 {
        self.runs
            .iter()
            .map(|run| run.lost(slots))
            .fold(0.0, f64::max)
    }

    /// The rows that have events, from the top; one row where frames were counted and have none,
    /// nothing where nobody knows.
    #[must_use]
    pub fn rows(&self) -> Option<RangeInclusive<u64>> {
        let silent = self.is_counted && self.runs.iter().all(|run| run.events == 0);
        self.rows.clone().or_else(|| silent.then_some(0..=0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{event::Event, plane::Size, unit::Micros};

    /// A packet with so many ON and OFF events in each frame, row by row.
    fn demand(counts: &[(u64, u64)]) -> Demand {
        let mut packet = Packet::new(Size::new(64, 64), 1);
        for (frame, (on, off)) in counts.iter().enumerate() {
            for i in 0..on + off {
                packet.events.push(Event {
                    t: Micros(frame as u64 * 1000),
                    x: (i % 64) as u16,
                    y: (3 + i / 64) as u16,
                    polarity: Polarity::of(i < *on),
                    channel: 0,
                });
            }
        }
        Demand::new(&packet, counts.len() as u64 + 1)
    }

    #[test]
    fn slots_are_sized_to_the_busiest_frame_or_to_most_of_them() {
        let mut counts = vec![(10, 3); 199];
        counts.push((60, 200));
        let demand = demand(&counts);
        assert_eq!((demand.busiest(), demand.ninety_nine()), (200, Some(10)));
        assert_eq!(demand.lost(200).to_bits(), 0.0_f64.to_bits());
        let events = 199.0 * 13.0 + 260.0;
        assert!((demand.lost(10) - 240.0 / events).abs() < 1e-12);
        assert_eq!(demand.rows(), Some(3..=7));
    }

    #[test]
    fn several_runs_are_served_together() {
        let both = demand(&[(10, 3), (5, 5)]).and(demand(&[(8, 2), (7, 20)]));
        assert_eq!(both.busiest(), 20);
        assert_eq!(both.lost(20), 0.0);
        // The share is that of the run that loses most.
        assert!((both.lost(10) - 10.0 / 37.0).abs() < 1e-12);
        let silent = || Demand::new(&Packet::new(Size::new(4, 4), 1), 5);
        assert_eq!(silent().and(silent()).rows(), Some(0..=0));
        assert_eq!(silent().and(demand(&[(70, 0)])).rows(), Some(3..=4));
    }

    #[test]
    fn kinds_are_read_one_by_one() {
        let mut packet = Packet::new(Size::new(64, 64), 2);
        for i in 0..30u16 {
            packet.events.push(Event {
                t: Micros(7),
                x: i,
                y: 5,
                polarity: Polarity::On,
                channel: u8::from(i >= 20),
            });
        }
        let demand = Demand::new(&packet, 2);
        assert_eq!(demand.busiest(), 20);
        assert!((demand.lost(10) - 10.0 / 30.0).abs() < 1e-12);
    }

    #[test]
    fn what_is_only_expected_has_no_rows_and_no_share_of_frames() {
        let demand = Demand::expected(50);
        assert_eq!((demand.busiest(), demand.ninety_nine()), (50, None));
        assert_eq!(demand.rows(), None);
        assert!((demand.lost(40) - 0.2).abs() < 1e-12);
        let silent = Demand::new(&Packet::new(Size::new(4, 4), 1), 5);
        assert_eq!((silent.busiest(), silent.rows()), (0, Some(0..=0)));
    }
}
