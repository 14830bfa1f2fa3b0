//! What a program takes of its chip: words, registers, time, and what its errors do.

use std::collections::BTreeSet;

use crate::{
    compile::SensorProgram,
    isa::{Analog, Device, Evidence, Figure, HostKind},
    program::{Cell, Code, Cost, Effect, stored},
    unit::Micros,
};

use super::known::{Known, weakest};

/// A program on its chip.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct OnChip {
    /// Instruction words of the filter.
    pub filter_words: u64,
    /// Instruction words of a frame.
    pub frame_words: u64,
    /// Words that the program takes of the store, the first frame's included.
    pub stored_words: u64,
    /// Words that the store holds.
    pub store: Known,
    /// Analogue registers that the whole program uses.
    pub registers: usize,
    /// Analogue registers that a pixel has, NEWS left out.
    pub registers_of: usize,
    /// Halvings of the light before anything else, a bit each.
    pub prescale_bits: u32,
    /// Whether results are right up to the border.
    pub border: bool,
    /// Whether all sums stay in range, the chip's transfer errors included.
    pub holds: bool,
    /// Time.
    pub time: Time,
    /// What the chip's errors leave in a result.
    pub noise: Noise,
}

/// A frame's time, part by part, and how many frames a second that allows.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Time {
    /// Words at the chip's clock.
    pub array: Known,
    /// The readout, with all slots that the program asks for.
    pub readout: Known,
    /// The readout with as many slots as the busiest frame of the scene needs.
    pub readout_of_scene: Known,
    /// Slots that the program asks for, for each sign.
    pub slots: u64,
    /// Slots that the busiest frame of the scene needs.
    pub slots_of_scene: u64,
    /// Exposure, where one was given.
    pub exposure: Option<Known>,
    /// Frames a second at most, with all slots.
    pub ceiling: Known,
    /// Frames a second at most, with the slots that the scene needs.
    pub ceiling_of_scene: Known,
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

/// The compiler's prediction, to first order, at one uniform level of light.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Noise {
    /// The level.
    pub at_lsb: f64,
    /// From frame to frame.
    pub temporal: Known,
    /// From pixel to pixel, the same in every frame.
    pub fixed: Known,
    /// The threshold, where it is compared.
    pub threshold_lsb: f64,
    /// The threshold over the noise of a difference of two frames; none without noise.
    pub margin: Option<f64>,
    /// Transfer errors of one store that stay in the result.
    pub offset_stores: f64,
}

/// The level of light at which noise is told: the middle of what a capture holds.
const MIDDLE: f64 = 64.0;

impl OnChip {
    /// Of a compiled program and the threshold that it compares with, in LSB.
    pub(super) fn of(
        program: &SensorProgram,
        code: &Code,
        device: &Device,
        threshold_lsb: f64,
        time: Time,
    ) -> Self {
        let filter = &program.filter;
        Self {
            filter_words: filter.words.len() as u64,
            frame_words: Cost::of(&code.frame, device).words.0,
            stored_words: (stored(&code.init, device) + stored(&code.frame, device)).0,
            store: Known::figure(device, Figure::Store),
            registers: registers(code, device),
            registers_of: device.registers().analog.len() - 1,
            prescale_bits: filter.prescale,
            border: filter.border,
            holds: filter.holds,
            noise: Noise::of(program, device, threshold_lsb),
            time,
        }
    }
}

/// Analogue registers that a program touches, NEWS left out.
fn registers(code: &Code, device: &Device) -> usize {
    let mut cells = BTreeSet::new();
    for steps in [&code.init, &code.frame] {
        let Effect { reads, writes, .. } = Effect::of(steps, device);
        cells.extend(reads);
        cells.extend(writes);
    }
    let news = device.news();
    let ordinary = |cell: &&Cell| matches!(cell, Cell::Analog(register) if *register != news);
    cells.iter().filter(ordinary).count()
}

impl Noise {
    fn of(program: &SensorProgram, device: &Device, threshold_lsb: f64) -> Self {
        let filter = &program.filter;
        let of = filter.noise(device, Analog(0), MIDDLE, &program.drives);
        let (temporal, fixed) = of.first().map_or((0.0, 0.0), |n| (n.temporal, n.fixed));
        let evidence = |figures: &[Figure]| {
            let known = figures.iter().map(|figure| device.figure(*figure).evidence);
            weakest(known.chain([Evidence::Modelled]))
        };
        Self {
            at_lsb: MIDDLE,
            temporal: Known::one(
                temporal,
                "LSB",
                evidence(&[Figure::StoreNoise]),
                "noise of every store, to first order",
            ),
            fixed: Known::one(
                fixed,
                "LSB",
                evidence(&[
                    Figure::GainMismatch,
                    Figure::OffsetMismatch,
                    Figure::DivisionMismatch,
                ]),
                "mismatch of every store and of every bus that splits, to first order",
            ),
            threshold_lsb,
            // A decision takes the difference of two frames.
            margin: (temporal > 0.0).then(|| threshold_lsb / (2f64.sqrt() * temporal)),
            offset_stores: filter.offsets.first().copied().unwrap_or(0.0),
        }
    }
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
    /// The chip.
    pub device: &'a Device,
}

impl Time {
    /// `max(exposure, array) + readout`.
    pub(super) fn of(parts: &Parts<'_>) -> Self {
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
        let array = Known::one(
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
            Known::one(
                cost.host_us,
                "us",
                evidence,
                format!("2 x {slots} slots of {us} us ({source}), and what else the host does"),
            )
        };
        let readout_all = readout(&parts.cost, parts.slots[0]);
        let readout_of_scene = readout(&parts.cost_of_scene, parts.slots[1]);
        let exposure = parts.exposure.map(|exposure| {
            Known::one(
                exposure.0 as f64,
                "us",
                Evidence::Guess,
                "given with the question",
            )
        });
        let light = exposure.as_ref().map_or(0.0, |exposure| exposure.high);
        let first = array.high.max(light);
        let ceiling = |readout: &Known| {
            let of = [Some(&array), Some(readout), exposure.as_ref()];
            let evidence = weakest(of.into_iter().flatten().map(|part| part.evidence));
            Known::one(
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
        Time::of(&Parts {
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
