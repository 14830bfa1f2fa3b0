//! How bad a score is, in the one unit that every designer of an event sensor has a feeling for:
//! the **threshold equivalent** is the change of the float sensor's threshold, in per cent, that
//! costs as much.
//!
//! A [`Ladder`] shows the scene to float sensors that differ from the reference by their
//! threshold alone, and judges each as everything else is judged. Between two rungs the score is
//! taken as a straight line over the logarithm of the threshold.
//!
//! Gain and shape are told apart by **equal-event tuning**: the float sensor whose threshold is
//! such that it says as many events as the judged packet is the fairer reference for *which*
//! events these are. Its threshold tells the gain, what is kept of it the shape.

use serde::Serialize;

use super::{
    StudyError,
    design::{Design, DesignError},
};
use crate::{
    compare::{
        CompareError, Pair, Sorted,
        metric::Short,
        window::{self, Point, Redraws},
    },
    elementary,
    event::Packet,
    number::Format,
    plane::Size,
    reference::{Description, MemoryRule},
    rig::{self, guard::Warning},
    scene::{Frame, Scene},
    sensor::Sensor,
    unit::{Micros, fixed, frame_rate},
};

/// Thresholds of the ladder, as parts of the reference's; those below it are for tuning alone.
pub const RUNGS: [f64; 15] = [
    0.25, 0.5, 0.7, 0.85, 0.95, 1.02, 1.05, 1.1, 1.2, 1.35, 1.6, 2.0, 3.0, 5.0, 10.0,
];

/// How a packet compares with the float sensor's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Likeness {
    /// What of F1 is more than chance: `(f1 - floor) / (1 - floor)`; none where the reference has
    /// no event, or chance scores as much as anything, of which there is a
    /// [`warning`](Self::warning).
    pub kept: Option<f64>,
    /// The window of the matches, in microseconds.
    pub window_us: Micros,
    /// Frames a second that were shown.
    pub fps: f64,
    /// F1 within the window.
    pub f1: f64,
    /// F1 of a redraw of the reference.
    pub floor: f64,
    /// The change of the float sensor's threshold that costs as much, in per cent; none where the
    /// reference has no event.
    pub threshold_equivalent_percent: Option<f64>,
    /// Whether the score is beyond the ladder, so that the change is at least that.
    pub threshold_equivalent_is_least: bool,
    /// Events for each of the reference's; none where it has none.
    pub event_ratio: Option<f64>,
    /// The same against a float sensor that says as many events; none where no threshold of the
    /// ladder does, or there is no event.
    pub tuned: Option<Tuned>,
}

impl Likeness {
    /// Whether the scene can judge: the reference has events, and chance scores not nearly as
    /// much as anything ([`window::can_judge`]).
    #[must_use]
    pub fn is_judged(&self) -> bool {
        self.event_ratio.is_some() && window::can_judge(self.floor)
    }

    /// The change of threshold that costs as much; none where the scene cannot judge.
    #[must_use]
    pub fn judged_equivalent(&self) -> Option<f64> {
        self.threshold_equivalent_percent
            .filter(|_| self.is_judged())
    }

    /// That chance scores as much as anything, where it does and there is something to keep;
    /// `name` is whose events these are.
    #[must_use]
    pub fn warning(&self, name: &str) -> Option<Warning> {
        self.event_ratio?;
        let warning = Warning::window(self.window_us, self.floor)?;
        Some(Warning {
            subjects: vec![format!("what is kept of {name}")],
            ..warning
        })
    }
}

/// A comparison with a float sensor of as many events.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Tuned {
    /// What its threshold is more than the reference's, in per cent: the gain error.
    pub threshold_percent: f64,
    /// What is kept of it: the shape; none where chance scores as much as anything, or one of
    /// the two has no event.
    pub kept: Option<f64>,
    /// The change of threshold that costs as much as what is not kept; none where that is not
    /// known.
    pub threshold_equivalent_percent: Option<f64>,
    /// Whether it is at least that.
    pub threshold_equivalent_is_least: bool,
}

/// One float sensor of the ladder.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Rung {
    /// Its threshold as a part of the reference's.
    part: f64,
    events: u64,
    f1: f64,
}

/// The change of the threshold, in per cent, that costs as much as this F1, and whether it is at
/// least that, from rungs above 1 in their order, each the part of the threshold and its F1. No more
/// of them are asked for than are needed: a packet that is hardly off needs one.
///
/// # Errors
/// The first of a rung.
pub fn equivalent<E>(
    f1: f64,
    rungs: impl IntoIterator<Item = Result<(f64, f64), E>>,
) -> Result<(f64, bool), E> {
    let (mut part, mut best) = (1.0, 1.0_f64);
    for rung in rungs {
        let (next, here) = rung?;
        // A rung that scores more than one before it, by chance, is passed over.
        let here = here.min(best);
        if f1 >= here {
            return Ok((percent(between((best, part), (here, next), f1)), false));
        }
        (part, best) = (next, here);
    }
    Ok((percent(part), true))
}

/// What the float sensor says at other thresholds.
#[derive(Clone, Debug)]
pub struct Ladder {
    reference: Packet,
    sorted: Sorted,
    redraws: Redraws,
    window: Micros,
    fps: f64,
    seed: u64,
    rungs: Vec<Rung>,
}

/// The float sensors of a ladder, to be shown the scene beside all others.
///
/// # Errors
/// When the threshold is not positive, or the size has no addresses.
pub fn sensors(
    design: &Design<'_>,
    size: Size,
    memory: MemoryRule,
) -> Result<Vec<Box<dyn Sensor + Send>>, DesignError> {
    { RUNGS.iter() }
        .map(|part| {
            let threshold = design.threshold * part;
            Design {
                threshold,
                ..*design
            }
            .reference(size, memory, Format::F64)
        })
        .collect()
}

/// The parts of the threshold that the equivalent is told by: those of [`RUNGS`] above 1.
pub fn higher() -> impl Iterator<Item = f64> {
    RUNGS.into_iter().filter(|part| *part > 1.0)
}

/// Any sensor with its thresholds at a part of what they are.
#[must_use]
pub fn at_part(description: &Description, part: f64) -> Description {
    let mut other = description.clone();
    for channel in &mut other.channels {
        for threshold in &mut channel.thresholds {
            threshold.on *= part;
            threshold.off *= part;
        }
    }
    other
}

impl Ladder {
    /// Of the packets of the reference and of [`sensors`], in their order, at a number of frames
    /// a second.
    ///
    /// # Errors
    /// When a packet is of another sensor.
    pub fn new(
        reference: Packet,
        packets: &[Packet],
        window: Micros,
        fps: f64,
        seed: u64,
    ) -> Result<Self, CompareError> {
        let mut ladder = Self::bare(reference, window, fps, seed)?;
        for (part, packet) in RUNGS.iter().zip(packets) {
            ladder.add(*part, packet)?;
        }
        Ok(ladder)
    }

    /// Of the packet of the reference alone.
    ///
    /// # Errors
    /// When the packet is inconsistent.
    pub fn bare(
        reference: Packet,
        window: Micros,
        fps: f64,
        seed: u64,
    ) -> Result<Self, CompareError> {
        let sorted = Sorted::new(&reference)?;
        let redraws = Redraws::new(&sorted.identical(), seed);
        let rungs = vec![Rung {
            part: 1.0,
            events: reference.events.len() as u64,
            f1: 1.0,
        }];
        Ok(Self {
            reference,
            sorted,
            redraws,
            window,
            fps,
            seed,
            rungs,
        })
    }

    /// Adds the packet of the float sensor at a part of the threshold.
    ///
    /// # Errors
    /// When the packet is of another sensor.
    pub fn add(&mut self, part: f64, packet: &Packet) -> Result<(), CompareError> {
        let rung = Rung {
            part,
            events: packet.events.len() as u64,
            f1: self.f1(packet)?,
        };
        let above = self.rungs.partition_point(|known| known.part < part);
        self.rungs.insert(above, rung);
        Ok(())
    }

    /// The reference, and a packet that is judged against it.
    ///
    /// # Errors
    /// When it is of another sensor.
    pub fn pair(&self, packet: &Packet) -> Result<Pair, CompareError> {
        self.sorted.judge(packet)
    }

    /// F1 of a packet within the window.
    ///
    /// # Errors
    /// When it is of another sensor.
    pub fn f1(&self, packet: &Packet) -> Result<f64, CompareError> {
        Ok(window::f1(&self.pair(packet)?, self.window))
    }

    /// F1 of a redraw of the reference.
    #[must_use]
    pub fn floor(&self) -> f64 {
        self.redraws.floor(self.window)
    }

    /// Redraws of the reference.
    #[must_use]
    pub const fn redraws(&self) -> &Redraws {
        &self.redraws
    }

    /// The packet of the reference.
    #[must_use]
    pub const fn reference(&self) -> &Packet {
        &self.reference
    }

    /// The window of the matches.
    #[must_use]
    pub const fn window(&self) -> Micros {
        self.window
    }

    /// Judges a packet; not tuned yet.
    ///
    /// # Errors
    /// When it is of another sensor.
    pub fn judge(&self, packet: &Packet) -> Result<Likeness, CompareError> {
        let pair = self.pair(packet)?;
        let point = Point::new(&pair, &self.redraws, self.window);
        let [reference, judged] = pair.events().map(|events| events as f64);
        // The ladder of a silent reference tells nothing apart.
        let equivalent = (reference > 0.0).then(|| self.equivalent(point.f1));
        Ok(Likeness {
            kept: point.kept.filter(|_| reference > 0.0),
            window_us: self.window,
            fps: self.fps,
            f1: point.f1,
            floor: point.floor,
            threshold_equivalent_percent: equivalent.map(|(percent, _)| percent),
            threshold_equivalent_is_least: equivalent.is_some_and(|(_, is_least)| is_least),
            event_ratio: (reference > 0.0).then(|| judged / reference),
            tuned: None,
        })
    }

    /// The change of the threshold, in per cent, that costs as much as this F1; and whether it is
    /// at least that, being beyond the last rung. F1 and what is kept rise together, and F1 tells
    /// packets apart also where chance scores as much.
    #[must_use]
    pub fn equivalent(&self, f1: f64) -> (f64, bool) {
        let rungs = self.rungs.iter().filter(|rung| rung.part > 1.0);
        let known = rungs.map(|rung| Ok::<_, std::convert::Infallible>((rung.part, rung.f1)));
        let Ok(equivalent) = equivalent(f1, known);
        equivalent
    }

    /// The same of what is kept above the reference's floor.
    #[must_use]
    pub fn equivalent_of_kept(&self, kept: f64) -> (f64, bool) {
        let floor = self.floor();
        self.equivalent(floor + kept * (1.0 - floor))
    }

    /// The threshold, as a part of the reference's, at which the float sensor says this many
    /// events; none where no threshold of the ladder does, and of no event at all, which any
    /// threshold is high enough for.
    #[must_use]
    pub fn part_of(&self, events: u64) -> Option<f64> {
        if events == 0 {
            return None;
        }
        // Fewer events the higher the threshold; where more events are lost to chance than that,
        // the first crossing counts.
        let events = events as f64;
        self.rungs.windows(2).find_map(|two| {
            let [a, b] = [two[0].events as f64, two[1].events as f64];
            let lies = (b..=a).contains(&events);
            lies.then(|| between((a, two[0].part), (b, two[1].part), events))
        })
    }

    /// Adds what a float sensor with as many events says, whose threshold is this part of the
    /// reference's, of a packet that was judged.
    ///
    /// # Errors
    /// When it is of another sensor.
    pub fn tune(
        &self,
        likeness: &mut Likeness,
        packet: &Packet,
        (part, tuned): (f64, &Packet),
    ) -> Result<(), CompareError> {
        let pair = Pair::new(tuned, packet)?;
        let point = Point::new(&pair, &Redraws::new(&pair, self.seed), self.window);
        let kept = point
            .kept
            .filter(|_| pair.events().iter().all(|events| *events > 0));
        // The ladder of a silent reference tells nothing apart.
        let known = kept.filter(|_| !self.reference.events.is_empty());
        let equivalent = known.map(|kept| self.equivalent_of_kept(kept));
        likeness.tuned = Some(Tuned {
            threshold_percent: percent(part),
            kept,
            threshold_equivalent_percent: equivalent.map(|(percent, _)| percent),
            threshold_equivalent_is_least: equivalent.is_some_and(|(_, is_least)| is_least),
        });
        Ok(())
    }
}

/// Tells gain and shape apart for packets that were judged: shows the scene once more, to the
/// float sensors that say as many events as they.
///
/// # Errors
/// When scene or sensor cannot go on.
pub fn tune(
    ladder: &Ladder,
    design: &Design<'_>,
    memory: MemoryRule,
    scene: &mut dyn Scene,
    judged: &mut [(&Packet, &mut Likeness)],
    seen: impl FnMut(&Frame),
) -> Result<(), StudyError> {
    let size = scene.size();
    let parts: Vec<Option<f64>> = { judged.iter() }
        .map(|(packet, _)| ladder.part_of(packet.events.len() as u64))
        .collect();
    let mut sensors = Vec::new();
    for part in parts.iter().flatten() {
        let threshold = design.threshold * part;
        sensors.push(
            Design {
                threshold,
                ..*design
            }
            .reference(size, memory, Format::F64)?,
        );
    }
    let tuned = rig::watch(scene, &mut rig::each(&mut sensors), seen)?;
    let found = { judged.iter_mut() }
        .zip(parts)
        .filter_map(|(one, part)| Some((one, part?)));
    for (((packet, likeness), part), tuned) in found.zip(&tuned) {
        ladder.tune(likeness, packet, (part, tuned))?;
    }
    Ok(())
}

/// The value between two of which this abscissa lies, over the value's logarithm.
fn between((x, a): (f64, f64), (y, b): (f64, f64), at: f64) -> f64 {
    let way = if x == y { 0.0 } else { (at - x) / (y - x) };
    elementary::exp(elementary::ln(a) + way * (elementary::ln(b) - elementary::ln(a)))
}

/// A part of the threshold as a change.
fn percent(part: f64) -> f64 {
    100.0 * (part - 1.0)
}

impl std::fmt::Display for Likeness {
    /// `kept 0.847 (100 ms, 10 frames/s), as a threshold 16 % higher`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let kept = kept(self.kept, 3);
        write!(
            f,
            "kept {kept} ({}, {} frames/s)",
            Short(self.window_us),
            frame_rate(self.fps)
        )?;
        match self.event_ratio {
            Some(_) => write!(f, ", as a threshold {} higher", self.equivalent()),
            None => Ok(()),
        }
    }
}

impl Likeness {
    /// The threshold equivalent in a few characters.
    #[must_use]
    pub fn equivalent(&self) -> String {
        percents(
            self.threshold_equivalent_percent,
            self.threshold_equivalent_is_least,
        )
    }
}

impl Tuned {
    /// The threshold equivalent in a few characters.
    #[must_use]
    pub fn equivalent(&self) -> String {
        percents(
            self.threshold_equivalent_percent,
            self.threshold_equivalent_is_least,
        )
    }
}

/// A threshold equivalent in a few characters, such as `16 %` or `> 900 %`; a dash where there is
/// none.
#[must_use]
pub fn percents(percent: Option<f64>, is_least: bool) -> String {
    let least = if is_least { "> " } else { "" };
    match percent {
        None => "-".to_owned(),
        Some(percent) if percent < 9.95 => format!("{least}{} %", fixed(percent, 1)),
        Some(percent) => format!("{least}{percent:.0} %"),
    }
}

/// What is kept, with so many decimals, or a dash where nothing can be. Where chance scores nearly 1
/// it can be far below 0: of that only so much is told, so that columns stay apart.
#[must_use]
pub fn kept(kept: impl Into<Option<f64>>, decimals: usize) -> String {
    const LEAST: f64 = -9.9;
    match kept.into() {
        None => "-".to_owned(),
        Some(kept) if kept < LEAST => format!("<{LEAST}"),
        Some(kept) => fixed(kept, decimals),
    }
}
