//! How long a frame takes, and how many a second that allows.

use super::{
    Question,
    estimate::{Estimate, weakest},
    stream,
};
use crate::{
    event::Packet,
    isa::{Device, Evidence, Figure, HostKind},
    program::{Action, Cost, Host, Step},
    study::design::Compiled,
    unit::Micros,
};

/// A frame's time, part by part, and how many frames a second that allows.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Time {
    /// Words at the chip's clock.
    pub array: Estimate,
    /// The readout, with all slots that the program asks for.
    pub readout: Estimate,
    /// The readout with as many slots as the busiest frame of the scene needs.
    pub readout_of_scene: Estimate,
    /// Slots that the program asks for, for each sign.
    pub slots: u64,
    /// Slots that the busiest frame of the scene needs.
    pub slots_of_scene: u64,
    /// Exposure, where one was given.
    pub exposure: Option<Estimate>,
    /// Frames a second at most, with all slots.
    pub ceiling: Estimate,
    /// Frames a second at most, with the slots that the scene needs.
    pub ceiling_of_scene: Estimate,
    /// What takes longest.
    pub binds: Binds,
    /// The longest exposure that leaves the rate that was asked for; none where there is none.
    pub longest_exposure_us: Option<f64>,
}

/// What a frame rate is limited by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Binds {
    /// Instruction words.
    Array,
    /// Events leaving the chip.
    Readout,
    /// Light.
    Exposure,
}

/// What a time is made of.
pub(super) struct Parts<'a> {
    /// Of a frame with all slots that the program asks for.
    pub cost: Cost,
    /// Of a frame with as many as the scene needs.
    pub cost_of_scene: Cost,
    /// Both, for each sign.
    pub slots: [u64; 2],
    /// Where one was given.
    pub exposure: Option<Micros>,
    /// Frames a second that were asked for.
    pub fps: f64,
    /// The chip on which the program is to run.
    pub device: &'a Device,
}

impl Time {
    /// `max(exposure, array) + readout`.
    pub(super) fn new(parts: &Parts<'_>) -> Self {
        let Parts { device, .. } = parts;
        let clock = device.figure(Figure::Clock);
        let launch = device.figure(Figure::Launch);
        let (evidence, launches) = if launch.value > 0.0 {
            (
                weakest([clock.evidence, launch.evidence]),
                format!(
                    "a launch of {} us ({}) is in it",
                    launch.value, launch.source
                ),
            )
        } else {
            (
                clock.evidence,
                "without launches of kernels, whose time nobody states".to_owned(),
            )
        };
        let array = Estimate::one(
            parts.cost.array_us,
            "us",
            evidence,
            format!("words / {} MHz ({}); {launches}", clock.value, clock.source),
        );
        let slot = device.host(HostKind::ScanEvents).item.as_ref();
        let readout = |cost: &Cost, slots: u64| {
            let (us, evidence, source) = slot
                .map_or((0.0, Evidence::Guess, "no time is stated"), |slot| {
                    (slot.value, slot.evidence, slot.source.as_str())
                });
            Estimate::one(
                cost.host_us,
                "us",
                evidence,
                format!("2 x {slots} slots of {us} us ({source}), and what else the host does"),
            )
        };
        let readout_all = readout(&parts.cost, parts.slots[0]);
        let readout_of_scene = readout(&parts.cost_of_scene, parts.slots[1]);
        let exposure = parts.exposure.map(|exposure| {
            Estimate::one(
                exposure.0 as f64,
                "us",
                Evidence::Guess,
                "given with the question",
            )
        });
        let light = exposure.as_ref().map_or(0.0, |exposure| exposure.high);
        let first = array.high.max(light);
        let ceiling = |readout: &Estimate| {
            let of = [Some(&array), Some(readout), exposure.as_ref()];
            let evidence = weakest(of.into_iter().flatten().map(|part| part.evidence));
            Estimate::one(
                1e6 / (first + readout.high),
                "frames/s",
                evidence,
                "1 / (the longer of exposure and array, then readout)",
            )
        };
        let binds = if readout_all.high >= first {
            Binds::Readout
        } else if light > array.high {
            Binds::Exposure
        } else {
            Binds::Array
        };
        let longest = 1e6 / parts.fps - readout_all.high;
        Self {
            ceiling: ceiling(&readout_all),
            ceiling_of_scene: ceiling(&readout_of_scene),
            slots: parts.slots[0],
            slots_of_scene: parts.slots[1],
            binds,
            longest_exposure_us: (longest >= array.high).then_some(longest),
            readout: readout_all,
            readout_of_scene,
            exposure,
            array,
        }
    }
}

/// A frame's time, as programmed and with the slots that the scene needs.
pub(super) fn time(
    question: &Question<'_>,
    program: &Compiled,
    said: Option<&Packet>,
    fps: f64,
) -> Time {
    let slots = slots(&program.code.frame);
    let needed = said
        .map_or(0, stream::most_in_a_frame)
        .clamp(1, slots.max(1));
    let mut fewer = program.code.frame.clone();
    set_slots(&mut fewer, needed as u32);
    Time::new(&Parts {
        cost: program.cost,
        cost_of_scene: Cost::of(&fewer, question.device),
        slots: [slots, needed],
        exposure: question.exposure,
        fps,
        device: question.device,
    })
}

/// Slots of a readout of events.
fn slots(steps: &[Step]) -> u64 {
    let of = |step: &Step| match &step.action {
        Action::Host(Host::ScanEvents { slots, .. } | Host::ScanEventsFrom { slots, .. }) => {
            u64::from(*slots)
        }
        Action::Repeat { body, .. } => self::slots(body),
        Action::Host(_) | Action::Word(_) => 0,
    };
    steps.iter().map(of).max().unwrap_or(0)
}

/// The same for all readouts of events.
fn set_slots(steps: &mut [Step], to: u32) {
    for step in steps {
        match &mut step.action {
            Action::Host(Host::ScanEvents { slots, .. } | Host::ScanEventsFrom { slots, .. }) => {
                *slots = to;
            }
            Action::Repeat { body, .. } => set_slots(body, to),
            Action::Host(_) | Action::Word(_) => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::unit::Words;

    fn time(exposure: Option<u64>, array_us: f64, host_us: f64) -> Time {
        let device = Device::scamp5();
        let cost = Cost {
            words: Words(50),
            array_us,
            host_us,
        };
        Time::new(&Parts {
            cost,
            cost_of_scene: Cost {
                host_us: host_us / 10.0,
                ..cost
            },
            slots: [4000, 400],
            exposure: exposure.map(Micros),
            fps: 100.0,
            device: &device,
        })
    }

    #[test]
    fn exposure_runs_beside_the_array_and_readout_after_both() {
        let plain = time(None, 5.0, 995.0);
        assert_eq!((plain.ceiling.low, plain.binds), (1000.0, Binds::Readout));
        assert!((plain.ceiling_of_scene.low - 1e6 / 104.5).abs() < 1e-9);
        assert_eq!(plain.longest_exposure_us, Some(9005.0));
        // Shorter than the array's own time: it costs nothing.
        assert_eq!(time(Some(3), 5.0, 995.0).ceiling.low, 1000.0);
        let dark = time(Some(4005), 5.0, 995.0);
        assert_eq!((dark.ceiling.low, dark.binds), (200.0, Binds::Exposure));
        let busy = time(Some(3), 900.0, 100.0);
        assert_eq!((busy.ceiling.low, busy.binds), (1000.0, Binds::Array));
        // At 100 frames/s no exposure is left beside 10 ms of readout.
        assert_eq!(time(None, 5.0, 10_000.0).longest_exposure_us, None);
    }
}
