//! What a program reads out each frame, and what other ways to read the same would take.

use super::{Demand, Plan, Way};
use crate::{
    isa::{Device, Figure, HostKind},
    program::{Action, Host, HostCalls, HostTimes, Step},
};

/// What a program reads out each frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Scans {
    /// Scans of events: one for each sign and kind.
    pub count: u64,
    /// Slots of each.
    pub slots: u64,
    /// All that the host does besides.
    pub rest: Vec<HostCalls>,
    /// Rows that hold the scene.
    pub rows: u64,
}

impl Scans {
    /// Of a frame's program; whole bit planes are all rows of the chip, whatever the scene.
    #[must_use]
    pub fn new(frame: &[Step], device: &Device) -> Self {
        let calls = HostCalls::of(frame, device).into_iter();
        let (scans, rest): (Vec<_>, Vec<_>) = calls.partition(|it| it.kind == HostKind::ScanEvents);
        Self {
            count: scans.iter().map(|it| it.calls as u64).sum(),
            slots: most_slots(frame),
            rest,
            rows: device.value(Figure::Height) as u64,
        }
    }

    /// The same on an array of at least so many rows: that of a scene that is larger than the chip.
    #[must_use]
    pub fn with_rows(self, rows: usize) -> Self {
        Self {
            rows: self.rows.max(rows as u64),
            ..self
        }
    }

    /// The cheapest readout that loses nothing, of a chip with these times of the host, us.
    pub fn cheapest(
        &self,
        demand: &Demand,
        times: impl Fn(HostKind) -> HostTimes,
        device: &Device,
    ) -> f64 {
        let ways = [Way::BusiestFrame, Way::BitPlanes, Way::Region];
        let plans = ways.into_iter().filter_map(|way| {
            let plan = self.plan(way, Some(demand), device)?;
            Some(self.us(&plan, &times))
        });
        plans.fold(f64::INFINITY, f64::min)
    }

    /// All ways to read so many events, in the order in which they are shown; without a demand
    /// those whose size needs none.
    #[must_use]
    pub fn plans(&self, demand: Option<&Demand>, device: &Device) -> Vec<Plan> {
        let plans = Way::ALL.iter();
        plans
            .filter_map(|way| self.plan(*way, demand, device))
            .collect()
    }

    /// One way to read so many events; none where its size is not known.
    #[must_use]
    pub fn plan(&self, way: Way, demand: Option<&Demand>, device: &Device) -> Option<Plan> {
        let fit = |slots: u64| slots.clamp(1, self.slots.max(1));
        let slots = match way {
            Way::AsProgrammed => Some(self.slots),
            Way::BusiestFrame => Some(fit(demand?.busiest())),
            Way::NinetyNinePercent => Some(fit(demand?.ninety_nine()?)),
            _ => None,
        };
        let rows = match way {
            Way::BitPlanes => Some(0..=self.rows.saturating_sub(1)),
            Way::Region => Some(demand?.rows()?),
            _ => None,
        };
        let lost = match slots {
            Some(slots) => demand.map(|demand| demand.lost(slots)),
            None if way.is_summary() => Some(1.0),
            None => Some(0.0),
        };
        let mut plan = Plan {
            way,
            calls: if way.reads_drives() {
                self.count.div_ceil(2)
            } else {
                self.count
            },
            slots,
            rows,
            us: [0.0; 2],
            lost,
        };
        plan.us = [0, 1].map(|end| self.us(&plan, &|kind| HostCalls::times(kind, device)[end]));
        Some(plan)
    }

    /// Time of a frame's readout, us.
    fn us(&self, plan: &Plan, times: &impl Fn(HostKind) -> HostTimes) -> f64 {
        let rows = plan.rows.as_ref().map(|rows| rows.end() - rows.start() + 1);
        let (calls, items) = (plan.calls as f64, plan.slots.or(rows).unwrap_or(0) as f64);
        let read = HostCalls {
            kind: plan.way.host(),
            calls,
            items: calls * items,
        };
        let all = self.rest.iter().chain([&read]);
        all.map(|it| it.us(times(it.kind))).sum()
    }
}

/// The most slots of one scan of events.
fn most_slots(steps: &[Step]) -> u64 {
    let slots = steps.iter().map(|step| match &step.action {
        Action::Host(Host::ScanEvents { slots, .. }) => u64::from(*slots),
        Action::Repeat { body, times } if *times > 0 => most_slots(body),
        Action::Repeat { .. } | Action::Host(_) | Action::Word(_) => 0,
    });
    slots.max().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::{super::choose, *};

    /// Two scans, beside a call that takes 0 to 13 us.
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
    fn many_slots_cost_more_than_all_bits() {
        let device = Device::scamp5();
        let chosen = |most: u64| {
            let plans = scans().plans(Some(&Demand::expected(most)), &device);
            plans[choose(&plans).unwrap()].way
        };
        // 2 x 64 rows of 4 us at the most are 512 us, as 281 slots of 0.91 us for each sign.
        assert_eq!(chosen(281), Way::BusiestFrame);
        assert_eq!(chosen(282), Way::BitPlanes);
        // More than the host's list holds: slots would lose some.
        assert_eq!(chosen(5000), Way::BitPlanes);
    }

    #[test]
    fn every_way_costs_what_the_chip_s_data_say() {
        let device = Device::scamp5();
        let plans = scans().plans(Some(&Demand::expected(20)), &device);
        let us = |way| plans.iter().find(|plan| plan.way == way).map(|it| it.us);
        let near = |way, [low, high]: [f64; 2]| {
            let [least, most] = us(way).unwrap();
            let off = (least - low).abs() + (most - high).abs();
            assert!(off < 1e-9, "{way:?}: {least} to {most}");
        };
        near(Way::AsProgrammed, [2400.0, 13.0 + 7280.0]);
        near(Way::BusiestFrame, [12.0, 13.0 + 36.4]);
        near(Way::BitPlanes, [38.4, 13.0 + 512.0]);
        near(Way::BoundingBox, [8.0, 13.0 + 8.0]);
        near(Way::EventCounts, [28.0, 13.0 + 28.0]);
        near(Way::Sums, [14.0, 13.0 + 14.0]);
        near(Way::AnyEvent, [2.0, 13.0 + 2.0]);
        // Which rows have events, and how many 99 % of the frames have, nobody has said.
        assert_eq!((us(Way::Region), us(Way::NinetyNinePercent)), (None, None));
    }

    #[test]
    fn without_a_demand_only_what_keeps_all_is_lossless() {
        let device = Device::scamp5();
        let plans = scans().plans(None, &device);
        assert_eq!(plans[choose(&plans).unwrap()].way, Way::BitPlanes);
        assert_eq!(plans[0].way, Way::AsProgrammed);
        assert_eq!(plans[0].lost, None);
        assert!(plans.iter().all(|plan| plan.way != Way::BusiestFrame));
    }
}
