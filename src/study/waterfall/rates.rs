//! The waterfall over frame rate: what is kept at each of several rates, and what each cause
//! takes of the rest.

use serde::Serialize;

use super::{
    Cause, Fall, Noise, NoiseAtRate, Sample, WaterfallError,
    estimate::Estimate,
    game::{Game, Judge, causes},
    sample,
    stretch::Stretch,
};
use crate::{
    array::Arithmetic,
    compare::window,
    elementary,
    event::{Packet, readout::Readout},
    number::Format,
    reference::MemoryRule,
    rig,
    scene::{Reopen, Scene, SceneError, held::Held, resample::Resampled},
    study::{
        defaults::WATERFALL_CHIPS,
        equivalent::{self, Ladder},
        expanded::WORK,
        quantisation::Headline,
    },
    unit::Micros,
};

/// Which rates, and how many chips and tiles.
#[derive(Clone, Debug)]
pub struct Choice {
    /// Frames a second; empty for some from the clip's own to the chip's ceiling.
    pub rates: Vec<f64>,
    /// Chips: this many seeds, from that of the question on.
    pub chips: u64,
    /// Tiles; none for as many as take some seconds.
    pub tiles: Option<usize>,
    /// Events of one cell and sign that are at most this far apart match; none for the window of
    /// headlines at each rate.
    pub within: Option<Micros>,
}

impl Choice {
    /// Refuses rates that a scene of so many frames cannot be shown at, before anything is compiled.
    ///
    /// # Errors
    /// [`WaterfallError::Rate`], or a rate that is none.
    pub fn check(&self, frames: u64, fps: f64) -> Result<(), WaterfallError> {
        // Which stretch of the scene it will be is not known; how long it is, is.
        let stretch = Stretch::new(&[], frames, fps, longest(fps));
        check(&self.rates, stretch.seconds())
    }
}

/// The longest stretch that is shown, in seconds of a scene of this rate.
fn longest(fps: f64) -> f64 {
    SECONDS.min(FRAMES / fps)
}

/// Refuses rates at which so many seconds are too few frames or too many.
fn check(rates: &[f64], seconds: f64) -> Result<(), WaterfallError> {
    for rate in rates {
        if !(rate.is_finite() && *rate > 0.0) {
            return Err(SceneError::BadRate { fps: *rate }.into());
        }
        // Half a microsecond decides nothing; `as` saturates.
        let frames = ((seconds + 5e-7) * rate) as u64 + 1;
        if !(2..=MOST_FRAMES).contains(&frames) {
            return Err(WaterfallError::Rate {
                fps: *rate,
                seconds,
                frames,
                most: MOST_FRAMES,
            });
        }
    }
    Ok(())
}

impl Default for Choice {
    fn default() -> Self {
        Self {
            rates: Vec::new(),
            chips: WATERFALL_CHIPS,
            tiles: None,
            within: None,
        }
    }
}

/// The answer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Rates {
    /// Frames a second at most: instruction words, then the slots of the readout.
    pub ceiling_fps: f64,
    /// What was looked at.
    pub sample: Sample,
    /// How many chips.
    pub chips: u64,
    /// Events a second of the float sensor in the stretch, on the whole sensor.
    pub reference_events_per_second: f64,
    /// What a designer can do about noise; none where cells have none.
    pub noise: Option<Noise>,
    /// From slow to fast.
    pub rates: Vec<Rate>,
}

/// One frame rate.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Rate {
    /// What leaves the chip against the float sensor at the times of its crossings; what is kept
    /// is the mean of the chips, none where chance scores as much as anything.
    #[serde(flatten)]
    pub headline: Headline,
    /// Whether the threshold equivalent is at least that.
    pub threshold_equivalent_is_least: bool,
    /// Where a further chip, on another choice of tiles, lies with 80 %; of one chip the tiles alone
    /// count. None where what is kept is not known.
    pub kept_10_90: Option<[f64; 2]>,
    /// Frames that were shown.
    pub frames: u64,
    /// What takes the rest: the shares and what is kept add up to 1.
    pub causes: Vec<Share>,
    /// What noise alone makes of a still picture; none where cells have none.
    pub noise: Option<NoiseAtRate>,
}

/// What one cause takes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Share {
    /// The cause.
    pub cause: Cause,
    /// In a few words.
    pub name: &'static str,
    /// Of what there is to keep; the mean of the chips. Below 0 where it makes up for others; none
    /// where chance scores as much as anything.
    pub share: Option<f64>,
    /// Where a further chip, on another choice of tiles, lies with 80 %.
    pub share_10_90: Option<[f64; 2]>,
    /// How it was told from the others.
    pub how: How,
}

impl Rates {
    /// What of the chip takes most at the slowest rate, and its place among the causes; none where
    /// nothing takes any.
    #[must_use]
    pub fn costliest(&self) -> Option<(usize, &Share)> {
        costliest(&self.rates.first()?.causes)
    }
}

fn costliest(causes: &[Share]) -> Option<(usize, &Share)> {
    { causes.iter().enumerate() }
        .filter(|(_, share)| !share.cause.is_float() && share.share > Some(0.0))
        .max_by(|(_, a), (_, b)| {
            let [a, b] = [a, b].map(|share| share.share.unwrap_or(0.0));
            a.total_cmp(&b)
        })
}

/// How what a cause takes is told from what the others do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum How {
    /// Given the causes before it: not every set of them is a sensor.
    InOrder,
    /// Its Shapley value over all sets of the chip's switches.
    Shapley,
    /// Given all others, on the whole sensor.
    Last,
}

/// Rates between the clip's own and the ceiling, both included.
const LADDER: u32 = 4;
/// The most frames of a rate that nobody asked for.
const FRAMES: f64 = 300.0;
/// The most frames of one that somebody asked for.
const MOST_FRAMES: u64 = 4000;
/// Seconds of the scene that are shown.
const SECONDS: f64 = 2.0;
/// Tiles, where nobody says how many: at least, and at most. Which tiles are seen decides more than
/// which chips: with three, what the bundled clip keeps was 39 points off.
const TILES: [usize; 2] = [12, 48];
/// Chips on which noise alone is measured.
const NOISE_CHIPS: usize = 4;
/// A whole frame may have so many times the events that its tiles make likely.
const MARGIN: f64 = 4.0;

impl Fall<'_> {
    /// What is kept at several frame rates, and what takes the rest. The scene is opened
    /// several times; `seen` is called after each sensor that has watched its tiles.
    ///
    /// # Errors
    /// When scene or sensor cannot go on, a rate shows too few frames or too many, or the float
    /// sensor is silent.
    pub fn rates(
        &self,
        choice: &Choice,
        open: &Reopen<'_>,
        seen: &(dyn Fn() + Sync),
    ) -> Result<Rates, WaterfallError> {
        let question = self.question;
        let mut scene = open()?;
        let (size, fps) = (scene.size(), scene.fps());
        let crossings =
            || { question.design }.reference(size, MemoryRule::FilteredStep, Format::F64);
        let mut frames = 0;
        let mut float = crossings()?;
        let said = rig::watch(&mut *scene, &mut [&mut *float], |_| frames += 1)?;
        drop(scene);
        let said = said.first().ok_or(WaterfallError::Packet)?;
        let stretch = Stretch::new(&said.events, frames, fps, longest(fps));
        let events = stretch.events(&said.events);
        if events.is_empty() {
            return Err(question.silent());
        }
        let seconds = stretch.seconds();
        let rates = self.choose(choice, fps, seconds)?;
        let seeds = self.seeds(choice.chips);
        // What a program stores on its way may lie a little beyond the kernel.
        let halo = self.kinds.reach() + 1;
        let tiles = choice.tiles.unwrap_or_else(|| {
            let frames: f64 = rates.iter().map(|rate| rate * seconds + 1.0).sum();
            self.tiles(frames, halo, seeds.len())
        });
        let sample = Sample::new(
            size,
            halo,
            tiles,
            events,
            (stretch.start_seconds(), seconds, stretch.frames()),
        );

        let mut source = Vec::new();
        rig::play(&mut stretch.of(open()?), |frame| {
            source.push(sample.shown(&frame));
            Ok::<_, SceneError>(std::ops::ControlFlow::Continue(()))
        })?;
        let source = Held::new(source, sample.size(), fps);
        let floats = self.floats(&sample, &source)?;
        let whole = Whole {
            fall: self,
            stretch,
            open,
            reference: stretch.watched(open()?, &mut *crossings()?)?,
        };
        let per_second = events.len() as f64 / seconds;
        let mut answer = Vec::new();
        for rate in rates {
            let one = OneRate {
                fall: self,
                sample: &sample,
                seeds: &seeds,
                whole: &whole,
                per_second,
                window: choice.within.unwrap_or_else(|| window::headline(rate)),
            };
            answer.push(one.told(rate, &source, &floats, seen)?);
        }
        let measured: Vec<(f64, f64)> = answer
            .iter()
            .filter_map(|rate| Some((rate.headline.fps, rate.noise?.events_per_second)))
            .collect();
        let is_noisy = matches!(question.arithmetic, Arithmetic::Silicon { .. });
        Ok(Rates {
            ceiling_fps: self.ceiling_fps(),
            chips: seeds.len() as u64,
            reference_events_per_second: per_second,
            noise: is_noisy.then(|| Noise::new(self, &measured, per_second, size.pixels())),
            rates: answer,
            sample,
        })
    }

    /// The rates to show, ascending.
    fn choose(&self, choice: &Choice, fps: f64, seconds: f64) -> Result<Vec<f64>, WaterfallError> {
        let mut rates = choice.rates.clone();
        if rates.is_empty() {
            rates = ladder(fps, self.ceiling_fps().min(FRAMES / seconds));
        }
        rates.sort_by(f64::total_cmp);
        rates.dedup();
        check(&rates, seconds)?;
        Ok(rates)
    }

    /// Of numbers there is one chip.
    fn seeds(&self, chips: u64) -> Vec<u64> {
        match self.question.arithmetic {
            Arithmetic::Silicon { seed } => {
                (0..chips.max(1)).map(|i| seed.wrapping_add(i)).collect()
            }
            Arithmetic::Number(_) => vec![0],
        }
    }

    /// As many tiles as take some seconds, with so many frames at all rates together.
    fn tiles(&self, frames: f64, halo: usize, chips: usize) -> usize {
        // Of six switches two change nothing on most scenes; of the sets of the other four,
        // twelve are other ones on every chip.
        let sensors = (20 + 12 * chips) as f64;
        let tile = sample::pixels_of_tile(halo) as f64 * self.program().cost.words.0 as f64;
        let [least, most] = TILES;
        // `as` saturates.
        ((WORK / (sensors * tile * frames)) as usize).clamp(least, most)
    }

    /// What the tiles say in the float sensor at the times of its crossings, and in those of
    /// its ladder. They see the scene's own frames: light between frames is a straight line, so
    /// more of them change no crossing.
    fn floats(&self, sample: &Sample, source: &Held) -> Result<Vec<Packet>, WaterfallError> {
        let (design, size) = (self.question.design, source.size());
        let step = MemoryRule::FilteredStep;
        let mut sensors = vec![design.reference(size, step, Format::F64)?];
        sensors.extend(equivalent::sensors(&design, size, step)?);
        let said = rig::watch(&mut source.again(), &mut rig::each(&mut sensors), |_| ())?;
        Ok(said.into_iter().map(|said| sample.within(said)).collect())
    }
}

/// Whole multiples of the clip's rate up to a ceiling, as evenly as can be in logarithm, so that
/// the scene's own frames are among those of every rate.
fn ladder(fps: f64, ceiling: f64) -> Vec<f64> {
    let most = ((ceiling / fps) * (1.0 + 1e-9)).floor().max(1.0);
    let step = |i: u32| {
        let way = f64::from(i) / f64::from(LADDER - 1);
        fps * elementary::pow(most, way).round()
    };
    let mut rates: Vec<f64> = (0..LADDER).map(step).collect();
    rates.dedup();
    rates
}

/// The whole sensor, for what a readout of slots does.
struct Whole<'a> {
    fall: &'a Fall<'a>,
    stretch: Stretch,
    open: &'a Reopen<'a>,
    /// The float sensor at the times of its crossings.
    reference: Packet,
}

impl Whole<'_> {
    /// What the readout takes at a rate, after all else; none where chance scores as much as
    /// anything.
    fn taken(&self, fps: f64, window: Micros) -> Result<Option<f64>, WaterfallError> {
        let question = self.fall.question;
        let (ordered, switches) = causes(question.arithmetic);
        let on = ordered.into_iter().chain(switches).collect();
        let scene = Resampled::new(self.stretch.of((self.open)()?), fps)?;
        let setup = super::sensor::Setup::new(&question, &on).ok_or(WaterfallError::Packet)?;
        let mut chip = setup.sensor(&question, &self.fall.kinds, scene.size())?;
        let said = rig::watch(&mut { scene }, &mut [&mut *chip], |_| ())?;
        let fired = said.first().ok_or(WaterfallError::Packet)?;
        // The readout is of all kinds.
        let read = question.readout.read(fired).packet;
        let (read, fired) = (self.fall.own(&read), self.fall.own(fired));
        if read.events == fired.events {
            return Ok(Some(0.0));
        }
        Ok(
            match Judge::new(&self.reference, None, window, question.design.seed)? {
                Some(judge) => {
                    let all = |packet| -> Result<f64, WaterfallError> {
                        Ok(judge.kept(packet)?.iter().sum())
                    };
                    Some(all(&fired)? - all(&read)?)
                }
                None => None,
            },
        )
    }
}

/// What is needed at each rate.
struct OneRate<'a> {
    fall: &'a Fall<'a>,
    sample: &'a Sample,
    seeds: &'a [u64],
    whole: &'a Whole<'a>,
    per_second: f64,
    window: Micros,
}

impl OneRate<'_> {
    /// `floats` are the float sensor's packet and those of its ladder.
    fn told(
        &self,
        fps: f64,
        source: &Held,
        floats: &[Packet],
        seen: &(dyn Fn() + Sync),
    ) -> Result<Rate, WaterfallError> {
        let (question, window) = (self.fall.question, self.window);
        let (reference, rungs) = floats.split_first().ok_or(WaterfallError::Packet)?;
        let seed = question.design.seed;
        let ladder = Ladder::new(reference.clone(), rungs, window, fps, seed)?;
        let game = Game {
            fall: self.fall,
            sample: self.sample,
            light: held(Resampled::new(source.again(), fps)?)?,
            seen,
        };
        let readout = self.readout(&game, fps)?;
        let judge = Judge::new(reference, Some(self.sample), window, seed)?;
        let judged = match judge.zip(readout) {
            Some((judge, readout)) => Some((game.attribution(judge, self.seeds)?, readout)),
            None => None,
        };
        let (ordered, switches) = causes(question.arithmetic);
        let mut causes = Vec::new();
        for (i, cause) in ordered.iter().chain(&switches).enumerate() {
            let how = if i < ordered.len() {
                How::InOrder
            } else {
                How::Shapley
            };
            let own = { judged.as_ref() }.and_then(|(found, _)| found.taken.get(i));
            causes.push(Share::new(*cause, own, how));
        }
        let readout = judged.as_ref().map(|(_, readout)| *readout);
        let last = readout.map(Estimate::whole);
        causes.push(Share::new(Cause::Readout, last.as_ref(), How::Last));
        let kept = judged.map(|(found, readout)| found.kept.less(readout));
        let mean = kept.as_ref().map(Estimate::mean);
        let equivalent = mean.map(|mean| ladder.equivalent_of_kept(mean));
        let noise = match question.arithmetic {
            Arithmetic::Silicon { .. } => {
                let seeds = self.seeds.get(..NOISE_CHIPS).unwrap_or(self.seeds);
                let each = game.still(seeds, self.sample.seconds)?;
                let events_per_second = each * self.sample.pixels_of as f64;
                Some(NoiseAtRate {
                    events_per_second,
                    share: events_per_second / self.per_second,
                })
            }
            Arithmetic::Number(_) => None,
        };
        Ok(Rate {
            headline: Headline {
                kept: mean,
                window_us: window,
                fps,
                threshold_equivalent_percent: equivalent.map(|(percent, _)| percent),
            },
            threshold_equivalent_is_least: equivalent.is_some_and(|(_, is_least)| is_least),
            // More than all is never kept.
            kept_10_90: { kept.as_ref().map(Estimate::range) }
                .map(|range| range.map(|end| end.min(1.0))),
            frames: game.light.all().len() as u64,
            causes,
            noise,
        })
    }

    /// What the readout takes. Slots are those of the whole sensor, so it is run, but where its
    /// frames cannot fill them; none where chance scores as much as anything.
    fn readout(&self, game: &Game<'_>, fps: f64) -> Result<Option<f64>, WaterfallError> {
        let question = self.fall.question;
        let may_lose = match question.readout {
            Readout::Ideal(_) => false,
            Readout::Scan(scan) => {
                let (ordered, switches) = causes(question.arithmetic);
                let said = game.said(&question, &ordered.into_iter().chain(switches).collect())?;
                let likely = most_at_once(&said) as f64 / self.sample.part();
                MARGIN * likely > f64::from(scan.slots) || scan.period != Micros(0)
            }
            Readout::Arbiter(_) | Readout::Frame(_) => true,
        };
        if may_lose {
            self.whole.taken(fps, self.window)
        } else {
            Ok(Some(0.0))
        }
    }
}

/// The most events of one sign and kind at one time.
fn most_at_once(packet: &Packet) -> usize {
    let mut all: Vec<_> = { packet.events.iter() }
        .map(|e| (e.t, e.channel, e.polarity.bit()))
        .collect();
    all.sort_unstable();
    all.chunk_by(|a, b| a == b)
        .map(<[_]>::len)
        .max()
        .unwrap_or(0)
}

/// All frames of a scene, in memory.
fn held(mut scene: impl Scene) -> Result<Held, SceneError> {
    let mut frames = Vec::new();
    rig::play(&mut scene, |frame| {
        frames.push(frame);
        Ok::<_, SceneError>(std::ops::ControlFlow::Continue(()))
    })?;
    Ok(Held::new(frames, scene.size(), scene.fps()))
}

impl Share {
    fn new(cause: Cause, found: Option<&Estimate>, how: How) -> Self {
        Self {
            cause,
            name: cause.name(),
            share: found.map(Estimate::mean),
            share_10_90: found.map(Estimate::range),
            how,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_multiples_of_the_clips_up_to_the_ceiling() {
        assert_eq!(ladder(10.0, 137.3), [10.0, 20.0, 60.0, 130.0]);
        assert_eq!(ladder(30.0, 137.3), [30.0, 60.0, 90.0, 120.0]);
        assert_eq!(ladder(25.0, 137.3), [25.0, 50.0, 75.0, 125.0]);
        // A clip that is as fast as the chip, or faster.
        assert_eq!(ladder(130.0, 137.3), [130.0]);
        assert_eq!(ladder(240.0, 137.3), [240.0]);
    }

    /// One that brings events back takes nothing, however much it changes, and the float model's
    /// own steps are not the chip's.
    #[test]
    fn the_costliest_is_what_of_the_chip_takes_most() {
        let share =
            |cause, share: f64| Share::new(cause, Some(&Estimate::whole(share)), How::Shapley);
        let causes = [
            share(Cause::Frames, 0.5),
            share(Cause::Converter, -0.6),
            share(Cause::Transfer, 0.1),
            share(Cause::Mismatch, 0.2),
        ];
        let (place, found) = costliest(&causes).unwrap();
        assert_eq!((place, found.cause), (3, Cause::Mismatch));
        assert_eq!(costliest(&causes[..2]), None);
        assert_eq!(
            costliest(&[Share::new(Cause::Noise, None, How::Shapley)]),
            None
        );
    }
}
