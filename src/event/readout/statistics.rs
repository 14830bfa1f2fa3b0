//! Statistics of a readout: events, latency, utilisation.

use super::time::{picos, since, span_start};
use crate::{
    event::{Dropped, Packet},
    unit::{Micros, Picos},
};

/// Statistics of a readout.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Statistics {
    /// Its name.
    pub readout: &'static str,
    /// Events before and behind it.
    pub events: [u64; 2],
    /// What it dropped; the packet may have lost others before.
    pub dropped: Dropped,
    /// Time from firing to arrival, of the events that arrived; `None` when none did.
    pub latency: Option<Latency>,
    /// Its stages: how busy they were, and how many events waited.
    pub stages: Vec<Stage>,
    /// Events at SCAMP-5's address (0,0), which a host may take for the end of its list.
    pub ambiguous: u64,
    /// Whether most time stamps of the packet have one event, as crossing times do: they are no
    /// frames.
    #[serde(skip)]
    pub lone: bool,
}

/// Latencies, from firing to arrival. A quantile is the smallest latency that this part of the
/// events does not exceed. [`Latency::BEYOND`] stands for that time or longer: it is written as
/// `null`, and there is then no mean.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Latency {
    /// Mean, in seconds; infinite where one of them is not known.
    pub mean_s: f64,
    /// Median.
    #[serde(rename = "p50_ps", serialize_with = "known")]
    pub p50: Picos,
    /// Quantile of 90 %.
    #[serde(rename = "p90_ps", serialize_with = "known")]
    pub p90: Picos,
    /// Quantile of 99 %.
    #[serde(rename = "p99_ps", serialize_with = "known")]
    pub p99: Picos,
    /// Maximum.
    #[serde(rename = "max_ps", serialize_with = "known")]
    pub max: Picos,
}

/// `null` for a time that is not known.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks for it")]
fn known<S: serde::Serializer>(time: &Picos, serializer: S) -> Result<S::Ok, S::Error> {
    let time = Some(time).filter(|time| **time != Latency::BEYOND);
    serde::Serialize::serialize(&time, serializer)
}

impl Latency {
    /// The longest time that picoseconds hold, 213 days.
    pub const BEYOND: Picos = Picos(u64::MAX);

    /// Of latencies in picoseconds, in any order.
    #[must_use]
    pub fn from_latencies(latencies: &[u64]) -> Option<Self> {
        let mut sorted = latencies.to_vec();
        sorted.sort_unstable();
        let max = *sorted.last()?;
        let quantile = |percent: usize| {
            let rank = (sorted.len() * percent).div_ceil(100).max(1);
            Picos(sorted.get(rank - 1).copied().unwrap_or(max))
        };
        let sum: u128 = sorted.iter().map(|l| u128::from(*l)).sum();
        Some(Self {
            mean_s: if Picos(max) == Self::BEYOND {
                f64::INFINITY
            } else {
                sum as f64 / sorted.len() as f64 * 1e-12
            },
            p50: quantile(50),
            p90: quantile(90),
            p99: quantile(99),
            max: Picos(max),
        })
    }
}

/// The latencies of the events that arrive, as they come.
#[derive(Debug)]
pub(super) struct Latencies(Vec<u64>);

impl Latencies {
    /// For the events of a packet.
    pub(super) fn new(packet: &Packet) -> Self {
        Self(Vec::with_capacity(packet.events.len()))
    }

    /// Of an event that fired at `t` and arrived at `at`, picoseconds.
    pub(super) fn push(&mut self, t: Micros, at: u128) {
        self.0.push(since(t, at));
    }
}

/// A stage of a readout, which serves one event at a time.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Stage {
    /// Its name.
    pub name: &'static str,
    /// Part of the time that it was busy, from 0 to 1: its utilisation.
    pub busy: f64,
    /// Whether it cannot keep up: it was busy all the time, and yet more than a hundredth of the
    /// events were lost, or it needed more than a hundredth of the time watched beyond its end.
    pub falls_behind: bool,
    /// The most that waited at once: for the arbiter those that it reads too, for a link of an
    /// arbiter without the one that it sends.
    pub most: u64,
    /// Busy time in picoseconds, until the whole time is known.
    #[serde(skip)]
    time: u128,
}

impl Stage {
    pub(super) const fn new(name: &'static str, time: u128, most: u64) -> Self {
        Self {
            name,
            busy: 0.0,
            falls_behind: false,
            most,
            time,
        }
    }
}

impl Statistics {
    /// Of a readout of `packet` that dropped `dropped`, delivered the others with `latencies`,
    /// and was done at `end` (picoseconds). Utilisation is over the time that was watched, and
    /// on to `end`.
    pub(super) fn new(
        readout: &'static str,
        packet: &Packet,
        dropped: Dropped,
        latencies: &Latencies,
        mut stages: Vec<Stage>,
        end: u128,
    ) -> Self {
        let end = end.max(picos(packet.span.1));
        let whole = end.saturating_sub(picos(span_start(packet)));
        let beyond = end - picos(packet.span.1);
        let count = packet.events.len() as u64;
        let watched = whole - beyond;
        // One event, or several in one instant, are no load.
        let load = count > 1 && watched > 0;
        let too_much = load && (beyond > watched / 100 || dropped.total() > count / 100);
        for stage in &mut stages {
            stage.busy = if whole > 0 {
                stage.time as f64 / whole as f64
            } else {
                0.0
            };
            stage.falls_behind = too_much && stage.busy > 0.99;
        }
        Self {
            readout,
            events: [count, latencies.0.len() as u64],
            dropped,
            latency: Latency::from_latencies(&latencies.0),
            stages,
            ambiguous: 0,
            lone: are_lone(packet),
        }
    }
}

/// Whether most time stamps have one event.
fn are_lone(packet: &Packet) -> bool {
    let (mut stamps, mut lone) = (0_u64, 0_u64);
    for events in packet.events.chunk_by(|a, b| a.t == b.t) {
        stamps += 1;
        lone += u64::from(events.len() == 1);
    }
    2 * lone > stamps
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_ranks() {
        let latencies: Vec<u64> = (1..=200).rev().collect();
        let l = Latency::from_latencies(&latencies).unwrap();
        assert_eq!(
            [l.p50, l.p90, l.p99, l.max].map(|p| p.0),
            [100, 180, 198, 200]
        );
        assert!((l.mean_s - 100.5e-12).abs() < 1e-24);
        let one = Latency::from_latencies(&[7]).unwrap();
        assert_eq!((one.p50.0, one.p99.0), (7, 7));
        let long = Latency::from_latencies(&[7, 7, u64::MAX]).unwrap();
        let json = serde_json::to_value(long).unwrap();
        assert_eq!(json["p50_ps"], 7);
        assert!(json["max_ps"].is_null() && json["mean_s"].is_null());
        assert!(Latency::from_latencies(&[]).is_none());
    }
}
