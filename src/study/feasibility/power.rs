//! Power in parts: what is known of each as an interval, and what is not known alone.

use super::{Stream, estimate::Estimate, named::Named, time::Time};
use crate::{
    event::readout::Frame,
    isa::{Device, Evidence, Figure},
    plane::Size,
    program::{Cost, Step},
};

/// Electrical power at the frame rate that was asked for, part by part.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Power {
    /// Share of the time in which the array runs words.
    pub share: Estimate,
    /// The array while it runs words.
    pub busy: Part,
    /// The array while it waits.
    pub idle: Part,
    /// The periphery that finds and reads events.
    pub readout: Part,
    /// The link, with the energy of a bit that was given.
    pub link: Part,
    /// The micro-controller beside the array.
    pub host: Part,
    /// The parts that are known together: the array while it is busy, and the link.
    pub known: Estimate,
    /// Energy of the known parts for one frame.
    pub frame: Estimate,
    /// Energy of the known parts for one event of the chip; none without events.
    pub event: Option<Estimate>,
}

/// One part of the power.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Part {
    /// What it is.
    pub what: &'static str,
    /// Its power; none where it is not known.
    pub power: Option<Estimate>,
    /// What it cannot be more than, where that is known and the power is not.
    pub at_most: Option<Estimate>,
    /// What is known of it, and what is not.
    pub says: &'static str,
}

/// What the power of a program is made of.
pub(super) struct Load<'a> {
    /// Instruction words of a frame.
    pub words: f64,
    /// Those of each instruction.
    pub each: &'a [Named],
    /// Times of a frame.
    pub time: &'a Time,
    /// Frames a second that were asked for.
    pub fps: f64,
    /// Events a second of the chip; none in a scene without duration.
    pub events_s: Option<f64>,
    /// Thousands of bits a second on the link.
    pub kbit_s: Option<f64>,
    /// Energy of a bit on the link.
    pub bit: &'a Estimate,
}

/// The time of words at the highest clock, us: a word takes the energy that it takes there, however
/// long the host needs to launch it.
fn at_the_highest_clock(words: f64, device: &Device) -> f64 {
    let [_, peak] = Named::Figure(Figure::Clock).ends(device);
    words / peak
}

/// The share of the time in which the words of frames would take full power: all of it at most.
pub(super) fn worked(words: f64, device: &Device, fps: f64) -> f64 {
    (at_the_highest_clock(words, device) * 1e-6 * fps).min(1.0)
}

/// What the words of a frame take.
#[must_use]
pub fn words_energy(frame: &[Step], device: &Device) -> Estimate {
    let words = Cost::of(frame, device).words.0 as f64;
    let [full, clock] = [Figure::Power, Figure::Clock].map(Named::Figure);
    let us = at_the_highest_clock(words, device);
    Estimate::between(
        full.ends(device).map(|watts| watts * us),
        "uJ",
        Evidence::Modelled,
        "energy of a word (full power / the highest clock) x words a frame",
    )
    .made_of(device, &[full, clock])
    .made_of(device, &Named::words_of(frame))
}

impl Power {
    /// Of a program at a frame rate.
    pub(super) fn new(load: &Load<'_>, device: &Device) -> Self {
        let Load { words, fps, .. } = *load;
        let full = Named::Figure(Figure::Power);
        let clock = Named::Figure(Figure::Clock);
        // Words cannot run for more than all of the time.
        let share = load.time.array.ends().map(|us| (us * 1e-6 * fps).min(1.0));
        let share = Estimate::between(
            share,
            "1",
            Evidence::Measured,
            "time of the array a frame x frames/s",
        )
        .with(&load.time.array);
        let worked = worked(words, device, fps);
        let busy = Estimate::between(
            full.ends(device).map(|watts| watts * worked * 1e3),
            "mW",
            Evidence::Modelled,
            "energy of a word (full power / the highest clock) x words a frame x frames/s",
        )
        .made_of(device, &[full, clock])
        .made_of(device, load.each);
        let [_, most] = full.ends(device);
        let idle = Estimate::between(
            [0.0, most * (1.0 - worked) * 1e3],
            "mW",
            Evidence::Modelled,
            "full power for the rest of the time, which no array that waits takes",
        )
        .made_of(device, &[full, clock])
        .made_of(device, load.each);
        let link = load.kbit_s.map(|kbit_s| {
            let what = "bits a second x energy of a bit";
            load.bit.times(kbit_s * 1e-6, "mW", what)
        });
        let ends = link.as_ref().map_or([0.0; 2], Estimate::ends);
        let known = Estimate::between(
            [busy.low + ends[0], busy.high + ends[1]],
            "mW",
            Evidence::Modelled,
            "the array while it is busy, and the link; without what is not known",
        );
        let known = link.iter().fold(known.with(&busy), Estimate::with);
        Self {
            share,
            busy: Part {
                what: "array, busy",
                power: Some(busy),
                at_most: None,
                says: "A word is taken to need the same energy as at the peak rate, however long the host needs to launch it.",
            },
            idle: Part {
                what: "array, idle",
                power: None,
                at_most: Some(idle),
                says: "Not known: no power of the waiting array is published.",
            },
            readout: Part {
                what: "readout",
                power: None,
                at_most: None,
                says: "Not known: no power of a scan is published.",
            },
            link: Part {
                what: "link",
                power: link,
                at_most: None,
                says: "Addresses of all events, each bit with the energy that was given.",
            },
            host: Part {
                what: "host",
                power: None,
                at_most: None,
                says: "Not known: a micro-controller of two cores, outside the array. A whole system, array and host, took 1.58 W at 2260 frames/s (ANET).",
            },
            frame: known.times(1e3 / fps, "uJ", "known power / frame rate"),
            event: { load.events_s }
                .filter(|rate| *rate > 0.0)
                .map(|rate| known.times(1e6 / rate, "nJ", "known power / events a second")),
            known,
        }
    }

    /// Its parts, from the array outwards.
    #[must_use]
    pub const fn parts(&self) -> [&Part; 5] {
        [
            &self.busy,
            &self.idle,
            &self.readout,
            &self.link,
            &self.host,
        ]
    }
}

/// What leaves the chip a second, in the codings that one would compare.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Link {
    /// Energy of a bit on the link.
    pub bit: Estimate,
    /// A row for each way to send.
    pub rows: Vec<LinkRow>,
}

/// One way to send.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct LinkRow {
    /// What is sent.
    pub what: String,
    /// Thousands of bits a second over the scene.
    pub kbit_s: f64,
    /// What the link takes for that.
    pub power: Estimate,
}

/// A byte a pixel.
const VIDEO_BITS: f64 = 8.0;

impl Link {
    /// Of streams by name, a bit map and plain video, at a frame rate; `bit` in pJ.
    pub(super) fn new(bit: Estimate, streams: &[(&str, &Stream)], size: Size, fps: f64) -> Self {
        let sent = streams
            .iter()
            .filter_map(|(name, stream)| Some((format!("events of {name}"), stream.mean_kbit_s?)));
        let fixed = [
            (
                "a bit map of ON and OFF, every frame".to_owned(),
                Frame::bits(size, 1) as f64 * fps * 1e-3,
            ),
            (
                "8-bit video, every frame".to_owned(),
                size.pixels() as f64 * VIDEO_BITS * fps * 1e-3,
            ),
        ];
        let rows = sent.chain(fixed).map(|(what, kbit_s)| LinkRow {
            what,
            kbit_s,
            power: bit.times(kbit_s * 1e-3, "uW", "bits a second x energy of a bit"),
        });
        Self {
            rows: rows.collect(),
            bit,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        event::Packet,
        program::readout::{Demand, Scans},
        study::feasibility::{
            readout::ReadoutOrder,
            time::{FrameWords, Parts},
        },
    };

    fn power(words: f64, fps: f64, events_s: Option<f64>, kbit_s: Option<f64>) -> Power {
        let device = Device::scamp5();
        let time = Time::new(&Parts {
            words: FrameWords::new(&[], &device).unwrap(),
            scans: Scans::new(&[], &device),
            busy: &Demand::new(&Packet::new(Size::new(1, 1), 1), 1),
            exposure: None,
            order: ReadoutOrder::Overlapped,
            fps,
            device: &device,
        });
        let bit = Estimate::between([1.0, 20.0], "pJ", Evidence::Guess, "test");
        let load = Load {
            words,
            each: &[],
            time: &time,
            fps,
            events_s,
            kbit_s,
            bit: &bit,
        };
        Power::new(&load, &device)
    }

    #[track_caller]
    fn near(got: f64, want: f64) {
        assert!((got - want).abs() <= 1e-9 * want.abs(), "{got}, not {want}");
    }

    #[test]
    fn what_is_known_is_added_and_what_is_not_stands_alone() {
        let power = power(100.0, 1000.0, Some(2000.0), Some(50.0));
        // 0.12 to 0.158 uJ a word: 12 to 15.8 mW.
        let busy = power.busy.power.as_ref().unwrap();
        near(busy.low, 12.0);
        near(busy.high, 15.8);
        assert_eq!(busy.evidence, Evidence::Modelled);
        // 50 kbit/s of 1 to 20 pJ: 50 nW to 1 uW.
        let link = power.link.power.as_ref().unwrap();
        near(link.low, 5e-5);
        near(link.high, 1e-3);
        near(power.known.low, 12.0 + 5e-5);
        assert_eq!(power.known.evidence, Evidence::Guess);
        for part in [&power.idle, &power.readout, &power.host] {
            assert!(part.power.is_none() && part.says.starts_with("Not known"));
        }
        near(power.idle.at_most.as_ref().unwrap().high, 1580.0 * 0.99);
        // A frame of 1 ms; two events a frame.
        near(power.frame.high, power.known.high);
        near(power.event.as_ref().unwrap().low, power.known.low * 500.0);
    }

    #[test]
    fn words_run_for_all_of_the_time_at_most() {
        let power = power(100.0, 1e9, None, None);
        near(power.busy.power.unwrap().low, 1200.0);
        assert!(power.event.is_none() && power.link.power.is_none());
    }

    #[test]
    fn a_link_takes_energy_by_the_bit() {
        let bit = Estimate::between([1.0, 20.0], "pJ", Evidence::Guess, "test");
        let link = Link::new(bit, &[], Size::new(256, 256), 100.0);
        let rows: Vec<f64> = link.rows.iter().map(|row| row.kbit_s).collect();
        assert_eq!(rows, [13_107.2, 52_428.8]);
        assert!((link.rows[0].power.low - 13.1072).abs() < 1e-9);
        assert!((link.rows[0].power.high - 262.144).abs() < 1e-9);
    }
}
