//! The game of the chip's switches at one frame rate: what is kept with each set of them on.

use rayon::prelude::*;

use super::{
    Cause, Fall, Question, WaterfallError,
    estimate::Estimate,
    sample::Sample,
    sensor::{Setup, Switches},
    shapley,
};
use crate::{
    array::Arithmetic,
    compare::{CompareError, Pair, matching, window::Redraws},
    event::Packet,
    rig,
    scene::{Frame, Scene as _, held::Held},
    unit::Micros,
};

/// What is kept of the float sensor's events: on all tiles, then without each of them.
type Kept = Vec<f64>;

/// Judges what the tiles of a sample say.
#[derive(Clone, Copy, Debug)]
pub(super) struct Judge<'a> {
    reference: &'a Packet,
    /// None for the whole sensor.
    sample: Option<&'a Sample>,
    /// F1 of a redraw of the reference, below 1.
    floor: f64,
    window: Micros,
}

/// Events of a part of the cells.
#[derive(Clone, Copy, Default)]
struct Part {
    matched: u64,
    /// Of both packets.
    events: u64,
}

impl<'a> Judge<'a> {
    /// None where chance scores 1: then nothing can be said of what is kept.
    pub(super) fn new(
        reference: &'a Packet,
        sample: Option<&'a Sample>,
        window: Micros,
        seed: u64,
    ) -> Result<Option<Self>, CompareError> {
        let floor = Redraws::new(&Pair::new(reference, reference)?, seed).floor(window);
        Ok((floor < 1.0).then_some(Self {
            reference,
            sample,
            floor,
            window,
        }))
    }

    /// F1 within the window, above chance (which is taken for that of all tiles).
    pub(super) fn kept(self, said: &Packet) -> Result<Kept, CompareError> {
        let mut parts = vec![Part::default(); self.sample.map_or(1, Sample::parts)];
        for (cell, reference, judged) in Pair::new(self.reference, said)?.cells() {
            let part = (self.sample)
                .and_then(|sample| sample.part_of(cell.x(), cell.y()))
                .unwrap_or(0);
            if let Some(part) = parts.get_mut(part) {
                part.matched += matching::matched_of_cell(reference, judged, self.window);
                part.events += (reference.len() + judged.len()) as u64;
            }
        }
        let all = parts.iter().fold(Part::default(), |all, part| Part {
            matched: all.matched + part.matched,
            events: all.events + part.events,
        });
        let above = |Part { matched, events }| {
            let f1 = matching::share(2 * matched, events);
            (f1 - self.floor) / (1.0 - self.floor)
        };
        let less = |part: &Part| Part {
            matched: all.matched - part.matched,
            events: all.events - part.events,
        };
        let without = parts.iter().filter(|_| parts.len() > 1);
        let all = std::iter::once(above(all));
        Ok(all.chain(without.map(|part| above(less(part)))).collect())
    }
}

/// The tiles' light at one rate, and the sensors that may see it.
pub(super) struct Game<'a> {
    pub fall: &'a Fall<'a>,
    pub sample: &'a Sample,
    pub light: Held,
    /// Called after each sensor.
    pub seen: &'a (dyn Fn() + Sync),
}

/// What each cause takes.
pub(super) struct Attribution {
    /// In the order of [`causes`].
    pub taken: Vec<Estimate>,
    /// What the chips keep.
    pub kept: Estimate,
}

/// The causes of an arithmetic: those that come in order, since not every set of them is a
/// sensor, and the chip's switches, of which every set is.
pub(super) fn causes(arithmetic: Arithmetic) -> (Vec<Cause>, Vec<Cause>) {
    let (all, ordered): (&[Cause], usize) = match arithmetic {
        // Without its format analogue silicon is no sensor.
        Arithmetic::Silicon { .. } => (Cause::SILICON, 4),
        Arithmetic::Number(_) => (&Cause::NUMBERS, 3),
    };
    let switches = all.iter().skip(ordered);
    let chip = switches.filter(|cause| **cause != Cause::Readout).copied();
    (all.iter().take(ordered).copied().collect(), chip.collect())
}

impl Game<'_> {
    /// What the tiles say with these switches on.
    pub(super) fn said(
        &self,
        question: &Question<'_>,
        on: &Switches,
    ) -> Result<Packet, WaterfallError> {
        self.said_of(question, on, self.light.again())
    }

    fn said_of(
        &self,
        question: &Question<'_>,
        on: &Switches,
        mut light: Held,
    ) -> Result<Packet, WaterfallError> {
        let setup = Setup::new(question, on).ok_or(WaterfallError::Packet)?;
        let mut sensor = setup.sensor(question, &self.fall.kinds, light.size())?;
        let packets = rig::watch(&mut light, &mut [&mut *sensor], |_| ())?;
        (self.seen)();
        let said = packets.into_iter().next().ok_or(WaterfallError::Packet)?;
        Ok(self.sample.within(self.fall.own(&said).into_owned()))
    }

    fn kept(
        &self,
        judge: Judge<'_>,
        question: &Question<'_>,
        on: &Switches,
    ) -> Result<Kept, WaterfallError> {
        Ok(judge.kept(&self.said(question, on)?)?)
    }

    /// Attributes what is not kept to the causes before the readout, for the chips of these
    /// seeds. For each chip the parts add up to 1 less what it keeps.
    pub(super) fn attribution(
        &self,
        judge: Judge<'_>,
        seeds: &[u64],
    ) -> Result<Attribution, WaterfallError> {
        let question = self.fall.question;
        let (ordered, switches) = causes(question.arithmetic);
        let base: Switches = ordered.iter().copied().collect();
        // The float sensors: 1, 2 and 3 of the steps on.
        let floats = ordered.iter().take_while(|cause| cause.is_float()).count();
        let in_order: Vec<Kept> = (1..=floats)
            .into_par_iter()
            .map(|n| self.kept(judge, &question, &ordered.iter().take(n).copied().collect()))
            .collect::<Result<_, _>>()?;
        let first = seeds
            .first()
            .map_or(question, |seed| question.of_chip(*seed));
        let alive = self.alive(&first, &base, &switches)?;
        // Those that change nothing stay on.
        let dead = { switches.iter() }.filter(|cause| !alive.contains(cause));
        let base: Switches = base.iter().chain(dead).copied().collect();
        let values = self.values(judge, seeds, &base, &alive)?;
        // What the causes take of one chip: on all tiles, or without the one of this number.
        let chip = |values: &[Kept], tile: usize| -> Vec<f64> {
            let mut before = 1.0;
            let mut taken = Vec::new();
            for kept in in_order
                .iter()
                .chain(values.first().filter(|_| ordered.len() > floats))
            {
                taken.push(before - kept[tile]);
                before = kept[tile];
            }
            let shares = shapley(alive.len(), |set| {
                // Where numbers have no format of their own, the game begins at the float model.
                let float = set == 0 && ordered.len() == floats;
                if float { before } else { values[set][tile] }
            });
            taken.extend({ switches.iter() }.map(|cause| {
                let place = alive.iter().position(|other| other == cause);
                place.and_then(|i| shares.get(i)).map_or(0.0, |gain| -gain)
            }));
            taken
        };
        let replicates = in_order.first().map_or(1, Vec::len);
        let taken: Vec<Vec<Vec<f64>>> = { values.iter() }
            .map(|values| (0..replicates).map(|tile| chip(values, tile)).collect())
            .collect();
        let of_cause = |i: usize| {
            let own = |tiles: &Vec<Vec<f64>>| tiles.iter().map(|taken| taken[i]).collect();
            Estimate::new(&taken.iter().map(own).collect::<Vec<_>>())
        };
        let kept: Vec<Kept> = values.iter().filter_map(|v| v.last().cloned()).collect();
        Ok(Attribution {
            taken: (0..ordered.len() + switches.len()).map(of_cause).collect(),
            kept: Estimate::new(&kept),
        })
    }

    /// The switches that change any event of a chip, alone or with all others on.
    fn alive(
        &self,
        chip: &Question<'_>,
        base: &Switches,
        switches: &[Cause],
    ) -> Result<Vec<Cause>, WaterfallError> {
        let all: Switches = base.iter().chain(switches).copied().collect();
        let mut sets = vec![base.clone(), all.clone()];
        for cause in switches {
            let (mut alone, mut without) = (base.clone(), all.clone());
            alone.insert(*cause);
            without.remove(cause);
            sets.extend([alone, without]);
        }
        let said: Vec<Packet> = sets
            .par_iter()
            .map(|on| self.said(chip, on))
            .collect::<Result<_, _>>()?;
        let [none, all, pairs @ ..] = &said[..] else {
            return Err(WaterfallError::Packet);
        };
        Ok({ switches.iter().zip(pairs.chunks(2)) }
            .filter(|(_, pair)| {
                let changes =
                    |of: Option<&Packet>, by: &Packet| of.is_none_or(|of| of.events != by.events);
                changes(pair.first(), none) || changes(pair.last(), all)
            })
            .map(|(cause, _)| *cause)
            .collect())
    }

    /// For each chip what is kept with each set of the switches on. Sets without chance are the
    /// same on all chips, and are run once.
    fn values(
        &self,
        judge: Judge<'_>,
        seeds: &[u64],
        base: &Switches,
        alive: &[Cause],
    ) -> Result<Vec<Vec<Kept>>, WaterfallError> {
        let question = self.fall.question;
        let on = |set: usize| -> Switches {
            let own = alive.iter().enumerate().filter(|(i, _)| set >> i & 1 == 1);
            base.iter()
                .chain(own.map(|(_, cause)| cause))
                .copied()
                .collect()
        };
        let is_chance = |set: usize| {
            let mut own = alive.iter().enumerate().filter(|(i, _)| set >> i & 1 == 1);
            own.any(|(_, cause)| cause.is_chance())
        };
        let sets = 1_usize << alive.len();
        let jobs: Vec<(usize, usize)> = (0..seeds.len())
            .flat_map(|chip| (0..sets).map(move |set| (chip, set)))
            .filter(|(chip, set)| *chip == 0 || is_chance(*set))
            .collect();
        let found: Vec<Kept> = jobs
            .par_iter()
            .map(|(chip, set)| self.kept(judge, &question.of_chip(seeds[*chip]), &on(*set)))
            .collect::<Result<_, _>>()?;
        let mut values = vec![vec![Kept::new(); sets]; seeds.len()];
        for ((chip, set), kept) in jobs.into_iter().zip(found) {
            let chips = if is_chance(set) {
                chip..chip + 1
            } else {
                0..seeds.len()
            };
            for values in values.iter_mut().take(chips.end).skip(chips.start) {
                values[set].clone_from(&kept);
            }
        }
        Ok(values)
    }

    /// Events that noise alone makes of a still picture, the first one, for each pixel and
    /// second: a mean of these chips.
    pub(super) fn still(&self, seeds: &[u64], seconds: f64) -> Result<f64, WaterfallError> {
        let question = self.fall.question;
        let (ordered, _) = causes(question.arithmetic);
        let on: Switches = ordered.into_iter().chain([Cause::Noise]).collect();
        let frames = self.light.all();
        let still = |frame: &Frame| Frame {
            light: frames.first().unwrap_or(frame).light.clone(),
            ..*frame
        };
        let light = Held::new(
            frames.iter().map(still).collect(),
            self.light.size(),
            self.light.fps(),
        );
        let events: Vec<u64> = seeds
            .par_iter()
            .map(|seed| {
                let said = self.said_of(&question.of_chip(*seed), &on, light.again())?;
                Ok(said.events.len() as u64)
            })
            .collect::<Result<_, WaterfallError>>()?;
        let pixels = (seeds.len() * self.sample.pixels) as f64;
        Ok(events.iter().sum::<u64>() as f64 / (pixels * seconds))
    }
}
