//! How events leave the chip, as the answer tells it: every way of
//! [`program::readout`](crate::program::readout) with its time, its rate and how well they are
//! known.

use super::{estimate::Estimate, named::Named};
use crate::{
    isa::{Device, Evidence},
    program::readout::{Demand, Plan, Scans, Way, choose},
};

/// One way to read a frame's events.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct ReadoutPlan {
    /// The way.
    pub plan: Way,
    /// Slots for each sign; none where no slots are asked for.
    pub slots: Option<u64>,
    /// First and last row that is read, from the top; none where no rows are.
    pub rows: Option<[u64; 2]>,
    /// Time a frame.
    pub time: Estimate,
    /// Frames a second at most.
    pub frames_s: Estimate,
    /// What comes out of the chip.
    pub carries: &'static str,
    /// Share of the scene's events that do not leave the chip; 1 for a summary.
    pub lost: f64,
    /// Whether times and rates are told for this one: the cheapest of those that lose nothing.
    pub is_chosen: bool,
}

/// Whether light is collected while events are read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ReadoutOrder {
    /// The photodiodes integrate on while events are read: `max(exposure, array + readout)`.
    #[default]
    Overlapped,
    /// The next exposure begins when the last event is read: `max(exposure, array) + readout`.
    Sequential,
}

impl ReadoutOrder {
    /// As it is written.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Overlapped => "overlapped",
            Self::Sequential => "sequential",
        }
    }

    /// Time of a frame, from those of its parts.
    #[must_use]
    pub fn frame(self, exposure: f64, array: f64, readout: f64) -> f64 {
        match self {
            Self::Overlapped => exposure.max(array + readout),
            Self::Sequential => exposure.max(array) + readout,
        }
    }
}

/// All ways to read a scene, and which of them is chosen; `rate`: frames a second at most with a
/// readout of this time.
pub(super) fn plans(
    scans: &Scans,
    demand: &Demand,
    device: &Device,
    rate: impl Fn(&Estimate) -> Estimate,
) -> Vec<ReadoutPlan> {
    let plans = scans.plans(Some(demand), device);
    let chosen = choose(&plans);
    let told = |(at, plan): (usize, &Plan)| {
        let time = time(scans, plan, device);
        ReadoutPlan {
            plan: plan.way,
            slots: plan.slots,
            rows: plan.rows.as_ref().map(|rows| [*rows.start(), *rows.end()]),
            frames_s: rate(&time),
            time,
            carries: plan.way.carries(),
            lost: plan.lost.unwrap_or(0.0),
            is_chosen: chosen == Some(at),
        }
    };
    plans.iter().enumerate().map(told).collect()
}

/// The time of a plan, and what it is made of.
fn time(scans: &Scans, plan: &Plan, device: &Device) -> Estimate {
    let kind = plan.way.host();
    let calls = plan.calls;
    let (named, items) = match (plan.slots, &plan.rows) {
        (Some(slots), _) => (Named::Item(kind), crate::unit::counted(slots, "slot")),
        (_, Some(rows)) => {
            let count = rows.end() - rows.start() + 1;
            (Named::Item(kind), crate::unit::counted(count, "row"))
        }
        (None, None) => (Named::Call(kind), "a call".to_owned()),
    };
    let [least, most] = named.ends(device);
    let between = if least < most {
        format!("{least} to {most} us")
    } else {
        format!("{least} us")
    };
    let source = named.quantity(device);
    let source = source.map_or("no time is stated", |it| it.source.as_str());
    let what = format!("{calls} x {items} of {between} ({source}), and what else the host does");
    let mut made_of = vec![named];
    made_of.extend(
        { scans.rest.iter() }
            .filter(|it| it.items > 0.0)
            .map(|it| Named::Item(it.kind)),
    );
    let called = scans.rest.iter().map(|it| it.kind).chain([kind]);
    made_of.extend(
        called
            .map(Named::Call)
            .filter(|call| call.takes_time(device)),
    );
    Estimate::between(plan.us, "us", Evidence::Measured, what).made_of(device, &made_of)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{isa::HostKind, program::HostCalls};

    fn scans() -> Scans {
        Scans {
            count: 2,
            slots: 4000,
            rest: vec![HostCalls {
                kind: HostKind::LoadIn,
                calls: 1.0,
                items: 0.0,
            }],
            rows: 64,
        }
    }

    #[test]
    fn every_way_has_a_time_a_rate_and_an_evidence() {
        let device = Device::scamp5();
        let rate = |time: &Estimate| {
            let ends = [1e6 / time.high, 1e6 / time.low];
            Estimate::between(ends, "frames/s", Evidence::Measured, "test").with(time)
        };
        let plans = plans(&scans(), &Demand::expected(20), &device, rate);
        assert_eq!(plans.iter().filter(|plan| plan.is_chosen).count(), 1);
        assert!((plans[0].time.high - (13.0 + 2.0 * 4000.0 * 0.91)).abs() < 1e-9);
        assert_eq!(plans[0].time.inputs, ["scan_events.item", "load_in.call"]);
        for plan in &plans {
            assert_ne!(plan.time.evidence, Evidence::Measured, "{:?}", plan.plan);
            assert_eq!(plan.frames_s.inputs, plan.time.inputs);
            assert!((plan.frames_s.low * plan.time.high - 1e6).abs() < 1e-3);
        }
        let sums = plans.iter().find(|plan| plan.plan == Way::Sums).unwrap();
        // That of a sum is quoted, that of the other call is not.
        assert_eq!(sums.time.inputs, ["global_sum.call", "load_in.call"]);
        assert_eq!(sums.time.evidence, Evidence::Guess);
    }

    #[test]
    fn exposure_goes_on_while_events_are_read_or_does_not() {
        use ReadoutOrder::{Overlapped, Sequential};
        assert!((Overlapped.frame(500.0, 20.0, 400.0) - 500.0).abs() < 1e-12);
        assert!((Sequential.frame(500.0, 20.0, 400.0) - 900.0).abs() < 1e-12);
        for order in [Overlapped, Sequential] {
            assert!((order.frame(0.0, 20.0, 400.0) - 420.0).abs() < 1e-12);
        }
    }
}
