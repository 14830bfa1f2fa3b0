//! The program on many chips that the public data allow, and what decides.
//!
//! Each chip has its numbers drawn from their intervals (`draw`) and mismatch of
//! its own. It watches the scene, or a stated stretch of it, and is judged as the chip of the
//! seed is: against the float sensor, within the same window, by the same ladder of thresholds.
//! A chip is *feasible* if it keeps at least [`MOSTLY`] and reaches the frame rate of the scene.
//!
//! The tornado turns one number at a time: the chip of the seed with this number at the low and
//! at the high end of its interval, all others at their values.

use super::{
    FeasibilityError, Question, draw::Drawn, named::Named, power::worked, time::FrameWords,
    tornado::Turn,
};
use crate::{
    array::Arithmetic,
    compare::{CompareError, window::can_judge},
    event::Packet,
    isa::{Device, Evidence, Figure},
    program::readout::{Demand, Scans},
    rig,
    scene::{Frame, Reopen, Scene as _, part::First},
    study::{
        design::Compiled,
        equivalent::{Ladder, Likeness},
        expanded::{Expanded, WORK},
        spread::Spread,
    },
    unit::Micros,
};

/// From what share of the float sensor's events on a chip is feasible: those of the words
/// *mostly kept* and *kept*.
pub const MOSTLY: f64 = 0.80;

/// From what share on it is feasible with loss: *half kept*.
pub const HALF: f64 = 0.50;

/// Chips that watch side by side.
const ABREAST: usize = 8;

/// What becomes of a program on the chips that the public data allow.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct OverChips {
    /// Chips that were drawn.
    pub chips: u64,
    /// The share of them that is feasible; none where the scene cannot judge them.
    pub chips_feasible: Option<f64>,
    /// Between what the share of all chips lies that the data allow, with 95 % (Wilson 1927).
    pub chips_feasible_95: Option<[f64; 2]>,
    /// The share that is feasible, with loss or without.
    pub chips_feasible_with_loss: Option<f64>,
    /// The share that reaches the frame rate; none without a program.
    pub chips_fast_enough: Option<f64>,
    /// How well all that is known: as well as the weakest number that it is made of.
    pub chips_evidence: Option<Evidence>,
    /// What they watched.
    pub stretch: Option<Stretch>,
    /// Headlines over the chips.
    pub ranges: Option<Ranges>,
    /// Each chip.
    pub drawn: Vec<DrawnChip>,
    /// What decides, the strongest first.
    pub tornado: Vec<Turn>,
}

/// What of the scene the chips watched.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Stretch {
    /// Frames, from the first on.
    pub frames: u64,
    /// Frames of the whole scene.
    pub of_frames: u64,
    /// Events of the float sensor in it.
    pub reference_events: u64,
    /// F1 of redraws of them: what chance scores.
    pub floor: f64,
}

impl Stretch {
    /// Whether it can tell what chips keep.
    fn can_judge(&self) -> bool {
        self.reference_events > 0 && can_judge(self.floor)
    }
}

/// The headlines over the chips.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Ranges {
    /// What of F1 is more than chance; none where the scene cannot judge it.
    pub kept: Option<Spread>,
    /// The change of the float sensor's threshold that costs as much, in per cent; none where the
    /// scene cannot judge it.
    pub threshold_equivalent_percent: Option<Spread>,
    /// Events for each of the float sensor's; none where it has none.
    pub event_ratio: Option<Spread>,
    /// Frames a second at most.
    pub frames_s: Spread,
    /// Of the array while it runs words, at the scene's frame rate.
    pub power_busy_mw: Spread,
}

/// One chip.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct DrawnChip {
    /// Its number, from 0.
    pub chip: u64,
    /// The seed of its mismatch and noise.
    pub seed: u64,
    /// Whether it keeps enough and is fast enough.
    pub is_feasible: bool,
    /// What of F1 is more than chance; none where the scene cannot judge it.
    pub kept: Option<f64>,
    /// The window of the matches, in microseconds.
    pub window_us: Micros,
    /// Frames a second that were shown.
    pub fps: f64,
    /// The change of the float sensor's threshold that costs as much, in per cent; none where the
    /// scene cannot judge it.
    pub threshold_equivalent_percent: Option<f64>,
    /// Events for each of the float sensor's; none where it has none.
    pub event_ratio: Option<f64>,
    /// Frames a second at most.
    pub frames_s: f64,
    /// Of the array while it runs words, at the scene's frame rate.
    pub power_busy_mw: f64,
    /// Its numbers.
    pub values: Vec<DrawnValue>,
}

/// A number of a chip.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct DrawnValue {
    /// As `section.key`.
    pub figure: String,
    /// Its value on this chip.
    pub value: f64,
}

/// What the chips are asked.
pub(super) struct Trial<'a> {
    pub question: &'a Question<'a>,
    pub program: &'a Compiled,
    /// The words of a frame.
    pub words: FrameWords,
    /// The packets of the float sensor and of the ladder's, over the whole scene.
    pub floats: &'a [Packet],
    /// What the chip of the seed said of the whole scene.
    pub nominal: &'a Packet,
    /// Frames of the scene, and frames a second.
    pub frames: u64,
    pub fps: f64,
}

/// A chip that is to run: its numbers and the seed of its mismatch.
pub(super) struct Run {
    pub device: Device,
    pub seed: u64,
}

impl Trial<'_> {
    /// Runs all chips.
    ///
    /// # Errors
    /// When the scene or a chip cannot go on.
    pub fn run(
        &self,
        open: &Reopen<'_>,
        seen: &mut dyn FnMut(&Frame),
    ) -> Result<OverChips, FeasibilityError> {
        let Self { question, .. } = *self;
        let numbers = Named::with_interval(question.device);
        let drawn: Vec<Drawn> = (0..question.chips)
            .map(|chip| Drawn::new(question.seed, chip, question.device))
            .collect();
        let mut runs = Vec::new();
        for chip in &drawn {
            runs.push(Run {
                device: chip.device(question.device)?,
                seed: chip.seed,
            });
        }
        let ends = self.ends(&numbers, &mut runs)?;
        let size = self.nominal.size;
        let frames = stretch(runs.len(), size.pixels(), self.words.count, self.frames);
        let cut = |packet: &Packet| self.cut(packet, frames);
        let floats: Vec<Packet> = self.floats.iter().map(cut).collect();
        let ladder = self.ladder(&floats)?;
        let packets = self.watch(&runs, frames, open, seen)?;
        let (chips, turned) = packets.split_at(drawn.len());
        let mut each = Vec::new();
        for (chip, packet) in drawn.iter().zip(chips) {
            each.push(self.judged(chip, packet, &ladder, frames)?);
        }
        let nominal = cut(self.nominal);
        let tornado = self.tornado(&numbers, &ends, turned, &nominal, &ladder)?;
        let stretch = Stretch {
            frames,
            of_frames: self.frames,
            reference_events: ladder.reference().events.len() as u64,
            floor: ladder.judge(ladder.reference())?.floor,
        };
        let used = Named::of_results(question.device);
        let evidence = used.iter().filter_map(|it| it.quantity(question.device));
        let evidence = Evidence::weakest(evidence.map(crate::isa::Quantity::interval_evidence));
        Ok(OverChips::new(each, tornado, stretch, evidence))
    }

    /// What of a packet lies within the first frames.
    fn cut(&self, packet: &Packet, frames: u64) -> Packet {
        let mut cut = packet.clone();
        if frames < self.frames {
            let last = Micros::from_seconds(frames.saturating_sub(1) as f64 / self.fps);
            cut.events.retain(|event| event.t <= last);
            cut.span.1 = cut.span.1.min(last);
        }
        cut
    }

    fn ladder(&self, floats: &[Packet]) -> Result<Ladder, CompareError> {
        let [reference, rungs @ ..] = floats else {
            let none = Packet::new(self.nominal.size, 1);
            let Question { within, seed, .. } = *self.question;
            return Ladder::new(none, &[], within, self.fps, seed);
        };
        let Question { within, seed, .. } = *self.question;
        Ladder::new(reference.clone(), rungs, within, self.fps, seed)
    }

    /// Shows the first frames to all chips, some at a time.
    fn watch(
        &self,
        runs: &[Run],
        frames: u64,
        open: &Reopen<'_>,
        seen: &mut dyn FnMut(&Frame),
    ) -> Result<Vec<Packet>, FeasibilityError> {
        let mut packets = Vec::new();
        for some in runs.chunks(ABREAST) {
            let mut scene = First::new(open()?, frames);
            let size = scene.size();
            let mut chips = Vec::new();
            for run in some {
                let program = Expanded {
                    device: run.device.clone(),
                    ..self.program.expanded.clone()
                };
                let silicon = Arithmetic::Silicon { seed: run.seed };
                let chip = program.chip(silicon, size, program.settings())?;
                // The readout that is told of loses none.
                chips.push(program.all_events(chip));
            }
            packets.extend(rig::watch(
                &mut scene,
                &mut rig::each(&mut chips),
                &mut *seen,
            )?);
        }
        Ok(packets)
    }

    /// Frames a second at most, of a chip with these numbers that says this.
    pub(super) fn frames_s(&self, value: &dyn Fn(Named) -> f64, busy: &Demand) -> f64 {
        let Self { question, .. } = *self;
        let of = |figure| value(Named::Figure(figure));
        let array = self.words.us(of(Figure::Clock), of(Figure::Launch));
        let scans = Scans::new(&self.program.code.frame, question.device)
            .with_rows(self.nominal.size.height);
        let times = |kind| [Named::Call(kind), Named::Item(kind)].map(value);
        let readout = scans.cheapest(busy, times, question.device);
        let exposure = question.exposure.map_or(0.0, |it| it.0 as f64);
        1e6 / question.order.frame(exposure, array, readout)
    }

    /// A drawn chip, judged.
    fn judged(
        &self,
        chip: &Drawn,
        packet: &Packet,
        ladder: &Ladder,
        frames: u64,
    ) -> Result<DrawnChip, CompareError> {
        let device = self.question.device;
        let likeness = ladder.judge(packet)?;
        let Likeness {
            window_us,
            fps,
            event_ratio,
            ..
        } = likeness;
        let threshold_equivalent_percent = likeness.judged_equivalent();
        let kept = likeness.kept.filter(|_| likeness.is_judged());
        let value = |named| chip.value(named, device);
        let frames_s = self.frames_s(&value, &Demand::new(packet, frames));
        let watts = value(Named::Figure(Figure::Power));
        let worked = worked(self.words.count, device, self.fps);
        let values = chip.values.iter().map(|(named, value)| DrawnValue {
            figure: named.name(),
            value: *value,
        });
        Ok(DrawnChip {
            chip: chip.chip,
            seed: chip.seed,
            is_feasible: kept >= Some(MOSTLY) && frames_s >= self.fps,
            kept,
            window_us,
            fps,
            threshold_equivalent_percent,
            event_ratio,
            frames_s,
            power_busy_mw: watts * worked * 1e3,
            values: values.collect(),
        })
    }
}

/// Frames of a scene that all runs watch: as many as [`WORK`] allows, and two at least.
fn stretch(runs: usize, pixels: usize, words: f64, frames: u64) -> u64 {
    let one = runs.max(1) as f64 * pixels.max(1) as f64 * words.max(1.0);
    // `as` saturates, which is what is meant.
    ((WORK / one) as u64).max(2).min(frames)
}

/// Between what a share lies of which so many draws were that, with 95 %: the score interval
/// (Wilson 1927).
fn wilson(share: f64, draws: u64) -> [f64; 2] {
    const SIGMAS: f64 = 1.959_963_984_540;
    let (n, square) = (draws.max(1) as f64, SIGMAS * SIGMAS);
    let middle = share + square / (2.0 * n);
    let half = SIGMAS * (share * (1.0 - share) / n + square / (4.0 * n * n)).sqrt();
    [middle - half, middle + half].map(|end| (end / (1.0 + square / n)).clamp(0.0, 1.0))
}

impl OverChips {
    /// What stands in place of what is kept, where what the chips watched cannot judge it.
    #[must_use]
    pub fn unjudged(&self) -> Option<&'static str> {
        let stretch = self.stretch?;
        if stretch.reference_events == 0 {
            Some("nothing to keep: the float kernel has no event in what they were shown")
        } else if stretch.can_judge() {
            None
        } else {
            Some("chance alone scores nearly 1 in what they were shown")
        }
    }

    /// Of all chips that were drawn.
    fn new(
        drawn: Vec<DrawnChip>,
        tornado: Vec<Turn>,
        stretch: Stretch,
        evidence: Evidence,
    ) -> Self {
        let share = |of: &dyn Fn(&DrawnChip) -> bool| {
            let count = drawn.iter().filter(|chip| of(chip)).count();
            (!drawn.is_empty()).then(|| count as f64 / drawn.len() as f64)
        };
        let is_fast = |chip: &DrawnChip| chip.frames_s >= chip.fps;
        let can_judge = stretch.can_judge();
        let chips = drawn.len() as u64;
        let judged = |of: &dyn Fn(&DrawnChip) -> bool| share(of).filter(|_| can_judge);
        let spread = |of: &dyn Fn(&DrawnChip) -> f64| {
            let values: Vec<f64> = drawn.iter().map(of).collect();
            Spread::new(&values)
        };
        let known = |of: &dyn Fn(&DrawnChip) -> Option<f64>| {
            let values: Vec<f64> = drawn.iter().filter_map(of).collect();
            Spread::new(&values)
        };
        let ranges = || {
            Some(Ranges {
                kept: known(&|chip| chip.kept).filter(|_| can_judge),
                threshold_equivalent_percent: known(&|chip| chip.threshold_equivalent_percent)
                    .filter(|_| can_judge),
                event_ratio: known(&|chip| chip.event_ratio),
                frames_s: spread(&|chip| chip.frames_s)?,
                power_busy_mw: spread(&|chip| chip.power_busy_mw)?,
            })
        };
        let feasible = judged(&|chip| chip.is_feasible);
        Self {
            chips,
            chips_feasible: feasible,
            chips_feasible_95: feasible.map(|share| wilson(share, chips)),
            chips_feasible_with_loss: judged(&|chip| chip.kept >= Some(HALF) && is_fast(chip)),
            chips_fast_enough: share(&is_fast),
            chips_evidence: Some(evidence),
            stretch: Some(stretch),
            ranges: ranges(),
            tornado,
            drawn,
        }
    }

    /// Of chips that have no program: none of them is feasible.
    pub(super) fn without_program(chips: u64) -> Self {
        Self {
            chips,
            chips_feasible: Some(0.0),
            chips_feasible_with_loss: Some(0.0),
            ..Self::default()
        }
    }

    /// So many of the chips, of a share.
    #[must_use]
    pub fn count(&self, share: f64) -> u64 {
        (share * self.chips as f64).round() as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_scene_is_watched_for_a_while() {
        // 51 words on 256x256 pixels: the bundled clip whole.
        assert_eq!(stretch(58, 65536, 51.0, 72), 72);
        let part = stretch(58, 65536, 190.0, 72);
        assert!((15..25).contains(&part), "{part}");
        assert_eq!(stretch(58, 65536, 1e6, 72), 2);
        assert_eq!(stretch(58, 65536, 1e6, 1), 1);
    }

    fn chip(kept: f64, frames_s: f64) -> DrawnChip {
        DrawnChip {
            chip: 0,
            seed: 0,
            is_feasible: kept >= MOSTLY && frames_s >= 100.0,
            kept: Some(kept),
            window_us: Micros(100_000),
            fps: 100.0,
            threshold_equivalent_percent: Some(1.0),
            event_ratio: Some(1.0),
            frames_s,
            power_busy_mw: 1.0,
            values: Vec::new(),
        }
    }

    #[test]
    fn shares_count_chips_that_keep_enough_and_are_fast_enough() {
        let drawn = vec![
            chip(0.9, 200.0),
            chip(0.9, 50.0),
            chip(0.6, 200.0),
            chip(0.1, 200.0),
        ];
        let stretch = |reference_events, floor| Stretch {
            frames: 3,
            of_frames: 3,
            reference_events,
            floor,
        };
        let of = |stretch| OverChips::new(drawn.clone(), Vec::new(), stretch, Evidence::Guess);
        let all = of(stretch(7, 0.1));
        assert_eq!((all.chips, all.chips_feasible), (4, Some(0.25)));
        // Of one in four, by the tables of the score interval.
        let [least, most] = all.chips_feasible_95.unwrap();
        assert!((least - 0.0456).abs() < 1e-4 && (most - 0.6994).abs() < 1e-4);
        let [none, most] = wilson(0.0, 32);
        assert!(none == 0.0 && (most - 0.1072).abs() < 1e-4);
        assert_eq!(all.chips_feasible_with_loss, Some(0.5));
        assert_eq!(all.chips_fast_enough, Some(0.75));
        assert_eq!(all.count(0.5), 2);
        // A scene in which nothing happens judges nobody, nor does one of which chance knows all.
        for stretch in [stretch(0, 0.0), stretch(7, 0.95)] {
            let cannot = of(stretch);
            assert_eq!(
                (cannot.chips_feasible, cannot.chips_fast_enough),
                (None, Some(0.75))
            );
            let ranges = cannot.ranges.unwrap();
            assert!(ranges.kept.is_none() && ranges.event_ratio.is_some());
            assert!(ranges.threshold_equivalent_percent.is_none());
            assert!(cannot.chips_feasible_95.is_none());
            assert!(cannot.unjudged().is_some());
        }
        assert!(all.ranges.unwrap().kept.is_some() && all.unjudged().is_none());
    }
}
