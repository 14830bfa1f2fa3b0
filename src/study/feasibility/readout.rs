//! How events leave the chip: as many slots as a scene needs, or whole bit planes.
//!
//! A scan of events costs by the slot that is asked for, not by the event that is found. A
//! program asks for as many slots as the host can take; a designer asks for as many as the
//! events that he expects: those of the busiest frame, or those that 99 % of the frames stay
//! within. From a number of slots on it is cheaper to read all bits of the two registers of
//! events, row by row.

use super::{estimate::Estimate, named::Named};
use crate::{
    event::{Packet, Polarity},
    isa::{Device, Evidence, HostKind},
    program::{Action, Cost, Host, Step, host_us},
};

/// One way to read a frame's events.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct ReadoutPlan {
    /// Which.
    pub plan: Way,
    /// Slots for each sign; none for bit planes.
    pub slots: Option<u64>,
    /// Time a frame.
    pub time: Estimate,
    /// Share of the scene's events that find no slot.
    pub lost: f64,
    /// Whether times and rates are told for this one: the cheapest of those that lose nothing.
    pub is_chosen: bool,
}

/// What a frame's events leave the chip as.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Way {
    /// As many slots as the program asks for.
    AsProgrammed,
    /// Slots for the busiest frame of the scene.
    BusiestFrame,
    /// Slots within which 99 % of the frames of the scene stay.
    NinetyNinePercent,
    /// All bits of the registers of events.
    BitPlanes,
}

impl Way {
    /// In a few words.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::AsProgrammed => "all slots that the program asks for",
            Self::BusiestFrame => "slots for the busiest frame",
            Self::NinetyNinePercent => "slots for 99 % of the frames",
            Self::BitPlanes => "whole bit planes",
        }
    }
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

/// Events of each frame and sign, and the frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Busy {
    /// The larger of ON and OFF, of every frame, from the busiest on.
    most: Vec<u64>,
    /// All events.
    events: u64,
    /// ON and OFF of each frame that has any.
    signs: Vec<[u64; 2]>,
}

impl Busy {
    /// Of a packet of so many frames.
    pub fn new(packet: &Packet, frames: u64) -> Self {
        let of_frames = packet.events.chunk_by(|a, b| a.t == b.t);
        let signs = of_frames.map(|frame| {
            let on = frame.iter().filter(|e| e.polarity == Polarity::On).count();
            [on as u64, (frame.len() - on) as u64]
        });
        let signs: Vec<[u64; 2]> = signs.collect();
        let mut most: Vec<u64> = signs.iter().map(|[on, off]| *on.max(off)).collect();
        most.sort_unstable_by_key(|count| std::cmp::Reverse(*count));
        // Frames without an event are frames too; the first one has nothing to compare with.
        most.resize(most.len().max(frames.saturating_sub(1) as usize), 0);
        Self {
            most,
            events: packet.events.len() as u64,
            signs,
        }
    }

    /// The most of one sign in a frame.
    pub fn busiest(&self) -> u64 {
        self.most.first().copied().unwrap_or(0)
    }

    /// What 99 % of the frames stay within.
    fn ninety_nine(&self) -> u64 {
        self.most.get(self.most.len() / 100).copied().unwrap_or(0)
    }

    /// Share of the events beyond so many slots for each sign.
    fn lost(&self, slots: u64) -> f64 {
        let beyond = self.signs.iter().flatten();
        let beyond: u64 = beyond.map(|count| count.saturating_sub(slots)).sum();
        beyond as f64 / self.events.max(1) as f64
    }
}

/// What a program reads out each frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scans {
    /// Scans of events: one for each sign and kind.
    pub count: u64,
    /// Slots of each.
    pub slots: u64,
    /// Time of all that the host does besides, us.
    pub rest: f64,
    /// Rows that hold the scene.
    pub rows: u64,
}

impl Scans {
    /// Of a frame's program for a scene of so many rows.
    pub fn new(frame: &[Step], device: &Device, rows: usize) -> Self {
        let mut found = (0, 0, 0.0);
        collect(frame, device, &mut found);
        let (count, slots, of_scans) = found;
        Self {
            count,
            slots,
            rest: (Cost::of(frame, device).host_us - of_scans).max(0.0),
            rows: rows as u64,
        }
    }

    /// Time of a frame's readout with so many slots, of one time each.
    pub fn of_slots(&self, slots: u64, slot: f64, device: &Device) -> f64 {
        let call = device.host(HostKind::ScanEvents).call.value;
        self.rest + self.count as f64 * (call + slots as f64 * slot)
    }

    /// Time of a frame's readout as bit planes, of one time a row.
    pub fn of_planes(&self, row: f64, device: &Device) -> f64 {
        let call = device.host(HostKind::ScanDigital).call.value;
        self.rest + self.count as f64 * (call + self.rows as f64 * row)
    }

    /// The cheapest readout that loses nothing, of a chip with these times of a slot and of a
    /// row.
    pub fn cheapest(&self, busy: &Busy, slot: f64, row: f64, device: &Device) -> f64 {
        let slots = busy.busiest().clamp(1, self.slots.max(1));
        let planes = self.of_planes(row, device);
        self.of_slots(slots, slot, device).min(planes)
    }

    /// All ways to read a scene, and which of them is chosen.
    pub fn plans(&self, busy: &Busy, device: &Device) -> Vec<ReadoutPlan> {
        let most = self.slots.max(1);
        let (slot, row) = (
            Named::Item(HostKind::ScanEvents),
            Named::Item(HostKind::ScanDigital),
        );
        let source = |named: Named| {
            { named.quantity(device) }.map_or("no time is stated", |it| it.source.as_str())
        };
        let of_slots = |plan, slots: u64| {
            let ends = slot.ends(device);
            let time = ends.map(|us| self.of_slots(slots, us, device));
            let [least, longest] = ends;
            let scans = self.count;
            let what = format!(
                "{scans} x {slots} slots of {least} to {longest} us ({}), and what else the host does",
                source(slot)
            );
            let time = Estimate::between(time, "us", Evidence::Measured, what);
            ReadoutPlan {
                plan,
                slots: Some(slots),
                time: time.made_of(device, &[slot]),
                lost: busy.lost(slots),
                is_chosen: false,
            }
        };
        let planes = {
            let time = row.ends(device).map(|us| self.of_planes(us, device));
            let [least, longest] = row.ends(device);
            let what = format!(
                "{} x {} rows of {least} to {longest} us ({}), and what else the host does",
                self.count,
                self.rows,
                source(row)
            );
            let time = Estimate::between(time, "us", Evidence::Measured, what);
            ReadoutPlan {
                plan: Way::BitPlanes,
                slots: None,
                time: time.made_of(device, &[row]),
                lost: 0.0,
                is_chosen: false,
            }
        };
        let mut plans = vec![
            of_slots(Way::AsProgrammed, self.slots),
            of_slots(Way::BusiestFrame, busy.busiest().clamp(1, most)),
            of_slots(Way::NinetyNinePercent, busy.ninety_nine().clamp(1, most)),
            planes,
        ];
        let cheapest = { plans.iter_mut() }
            .filter(|plan| plan.lost == 0.0)
            .min_by(|a, b| a.time.high.total_cmp(&b.time.high));
        if let Some(plan) = cheapest {
            plan.is_chosen = true;
        }
        plans
    }
}

/// Scans of events, the most slots of one, and the time of all.
fn collect(steps: &[Step], device: &Device, found: &mut (u64, u64, f64)) {
    for step in steps {
        match &step.action {
            Action::Host(
                host @ (Host::ScanEvents { slots, .. } | Host::ScanEventsFrom { slots, .. }),
            ) => {
                found.0 += 1;
                found.1 = found.1.max(u64::from(*slots));
                found.2 += host_us(host, device);
            }
            Action::Repeat { body, times } => {
                for _ in 0..*times {
                    collect(body, device, found);
                }
            }
            Action::Host(_) | Action::Word(_) => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{event::Event, plane::Size, unit::Micros};

    fn busy(counts: &[(u64, u64)]) -> Busy {
        let mut packet = Packet::new(Size::new(64, 64), 1);
        for (frame, (on, off)) in counts.iter().enumerate() {
            for i in 0..on + off {
                packet.events.push(Event {
                    t: Micros(frame as u64 * 1000),
                    x: (i % 64) as u16,
                    y: (i / 64) as u16,
                    polarity: if i < *on { Polarity::On } else { Polarity::Off },
                    channel: 0,
                });
            }
        }
        Busy::new(&packet, counts.len() as u64 + 1)
    }

    const SCANS: Scans = Scans {
        count: 2,
        slots: 4000,
        rest: 1.0,
        rows: 64,
    };

    #[test]
    fn slots_are_sized_to_the_busiest_frame_or_to_most_of_them() {
        let mut counts = vec![(10, 3); 199];
        counts.push((60, 200));
        let busy = busy(&counts);
        assert_eq!((busy.busiest(), busy.ninety_nine()), (200, 10));
        assert_eq!(busy.lost(200).to_bits(), 0.0_f64.to_bits());
        let events = 199.0 * 13.0 + 260.0;
        assert!((busy.lost(10) - 240.0 / events).abs() < 1e-12);
    }

    #[test]
    fn many_slots_cost_more_than_all_bits() {
        let device = Device::scamp5();
        let chosen = |most: u64| {
            let plans = SCANS.plans(&busy(&[(most, 0)]), &device);
            let chosen: Vec<Way> = { plans.iter() }
                .filter(|plan| plan.is_chosen)
                .map(|plan| plan.plan)
                .collect();
            assert_eq!(chosen.len(), 1);
            chosen[0]
        };
        // 2 x 64 rows of 4 us at the most are 512 us, as 281 slots of 0.91 us for each sign.
        assert_eq!(chosen(281), Way::BusiestFrame);
        assert_eq!(chosen(282), Way::BitPlanes);
        let plans = SCANS.plans(&busy(&[(20, 0)]), &device);
        assert!((plans[0].time.high - (1.0 + 2.0 * 4000.0 * 0.91)).abs() < 1e-9);
        assert!(
            plans
                .iter()
                .all(|plan| plan.time.evidence == Evidence::Guess)
        );
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
