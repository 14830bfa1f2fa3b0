//! The survey: every model on the same tiles, none given up, and what each changes and costs.
//!
//! A pilot drops what does not pay as early as it can; who wants to choose sees all of it. Tiles,
//! estimates and limits are the pilot's. Times are those of the tiles, stretched to the whole
//! sensor and the whole scene; of what is timed on the whole sensor, a few frames. A sensor that has
//! no tiles, or a readout that may lose events, can only be run whole, and a second survey runs
//! everything whole to verify.

use std::ops::ControlFlow;

use crate::{
    compare::{Cell, Pair, Times, baseline, matching, window},
    event::{Event, Packet},
    mosaic::Mosaic,
    rig,
    scene::{Scene as _, kept::Kept, upsample},
    sensor::{Sensor, SensorError},
    stop::Stop,
    unit::Micros,
};

use super::{
    change,
    draw::draw,
    estimate::{ChangeEstimate, History, RISK, Tile},
    family::Family,
    first_frames::clocked,
    look::{Grid, Look},
    plan::PlanError,
    spread::{Parts, Spread},
    stage::{self, Between},
    trial::{LEAST_TILES, Ran, Trial},
};

/// How a survey is made.
#[derive(Clone, Copy)]
pub struct Survey<'a> {
    /// The scene.
    pub kept: &'a Kept,
    /// The contrast that frames are inserted for, in ln units.
    pub upsample: Option<f64>,
    /// An event that is moved by more is changed.
    pub within: Micros,
    /// Draws the tiles.
    pub seed: u64,
    /// Seconds since any moment.
    pub clock: &'a (dyn Fn() -> f64 + Sync),
    /// The part of the sensor that is run, 0 to 1.
    pub sample: f64,
    /// Whether to give up.
    pub stop: Stop,
}

/// What is known of a model.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Known {
    /// What it changes.
    pub change: ChangeEstimate,
    /// F1 of its events and the full model's within the same window.
    pub f1: f64,
    /// What of F1 is more than chance, within 100 ms or the time from frame to frame.
    pub kept: Option<f64>,
    /// What chance scores within that time.
    pub floor: f64,
    /// Seconds that it takes for the whole scene, the making of its light included.
    pub seconds: Spread,
    /// Seconds that it took to know this; none where it was run whole.
    pub planning: Option<f64>,
}

/// The tiles that are run, and how many there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Sampled {
    /// Tiles that are run.
    pub tiles: usize,
    /// Of so many.
    pub of: usize,
}

/// Frames that are timed on the whole sensor, where tiles do not tell.
const TIMED: usize = 5;

/// Redraws that a floor is the mean of.
const REDRAWS: u64 = 3;

/// A survey whose full model has been run.
pub struct Begun<'a, F: Family> {
    survey: Survey<'a>,
    trial: Trial<'a, F>,
    look: Look,
    mosaic: Mosaic,
    probabilities: Vec<f64>,
    full: Ran<F::Model>,
    floor: f64,
    /// Seconds for the look and the full model.
    spent: f64,
    /// Seconds that the light takes: with the inserted frames, and without.
    light: [f64; 2],
    full_seconds: Spread,
    /// How many limits are to hold together.
    models: usize,
}

/// Where frames are inserted.
///
/// # Errors
/// When upsampling refuses to.
pub fn inserted(kept: &Kept, upsample: Option<f64>) -> Result<Option<Between>, String> {
    let Some(contrast) = upsample else {
        return Ok(None);
    };
    let between = stage::between(kept, contrast);
    between
        .map(Some)
        .ok_or_else(|| "frames cannot be inserted: the light changes too much".to_owned())
}

impl<'a> Survey<'a> {
    /// Within what `kept` and its floor are.
    fn headline(&self) -> Micros {
        window::headline(self.kept.scene().fps())
    }

    /// Looks, draws, and runs the full model on the tiles. `models`: how many limits are to hold
    /// together.
    ///
    /// # Errors
    /// Why there are no tiles, or when the full model cannot go on.
    pub fn begin<F: Family>(
        self,
        family: &'a F,
        between: Option<&'a Between>,
        models: usize,
    ) -> Result<Begun<'a, F>, String> {
        let start = (self.clock)();
        let kept = self.kept;
        let halo = family.halo().map_err(str::to_owned)?;
        if let Some(why) = family.loses(kept.size()) {
            return Err(why.to_owned());
        }
        let grid = Grid::new(kept.size(), halo);
        if grid.tiles() < 2 * LEAST_TILES {
            return Err("the sensor is too small to be sampled".to_owned());
        }
        let look = Look::new(kept, grid, family.is_relative());
        let trial = Trial {
            family,
            kept,
            between,
            grid,
            halo,
            clock: self.clock,
            stop: self.stop,
        };
        // `as` saturates.
        let count = (self.sample * grid.tiles() as f64).ceil() as usize;
        let drawn = draw(
            &trial.activity(&look),
            &look.extremes,
            count.clamp(LEAST_TILES, grid.tiles()),
            self.seed,
        );
        if drawn.is_empty() {
            return Err("nothing ever changes".to_owned());
        }
        let mosaic = trial.mosaic(&drawn);
        let ran = trial.run(
            &[family.full()],
            &mosaic,
            kept.len(),
            f64::INFINITY,
            |_, _| (),
        );
        let ran = ran.map_err(|error| error.to_string())?;
        let full = ran.into_iter().next().ok_or("nothing was run")?;
        if let Some(why) = &full.given_up {
            return Err(format!("the full model stops: {why}"));
        }
        let mut begun = Begun {
            survey: self,
            light: stage::seconds_of_light(kept, between, self.clock),
            floor: 0.0,
            full_seconds: Spread::default(),
            probabilities: drawn.iter().map(|one| one.probability).collect(),
            spent: 0.0,
            trial,
            look,
            mosaic,
            full,
            models,
        };
        begun.full_seconds = begun.whole_sensor(&begun.full);
        begun.spent = (self.clock)() - start;
        begun.floor = begun.floor()?;
        Ok(begun)
    }
}

impl<F: Family> Begun<'_, F> {
    /// The tiles that are run.
    #[must_use]
    pub fn sampled(&self) -> Sampled {
        Sampled {
            tiles: self.probabilities.len(),
            of: self.trial.grid.tiles(),
        }
    }

    /// What was seen of the light.
    #[must_use]
    pub const fn look(&self) -> &Look {
        &self.look
    }

    /// The full model beside itself.
    #[must_use]
    pub fn full(&self) -> Known {
        // What cells of halos fire is not theirs.
        let own = |event: &&Event| self.mosaic.tile(event.y.into(), event.x.into()).is_some();
        let events = self.full.packet.events.iter().filter(own).count() as u64;
        Known {
            change: ChangeEstimate {
                share: 0.0,
                limit: Some(0.0),
                no_limit: None,
                tiles: self.probabilities.len() as u64,
                events,
                changes: 0,
            },
            f1: 1.0,
            kept: Some(1.0),
            floor: self.floor,
            seconds: { self.full_seconds }.scaled(1.0, self.light_of(&self.full.model)),
            // Nothing need be known to run it.
            planning: Some(0.0),
        }
    }

    /// Runs models on the tiles: what is known of each, or why it cannot go on.
    ///
    /// # Errors
    /// When one cannot be made.
    pub fn ask(&self, models: &[F::Model]) -> Result<Vec<Result<Known, String>>, SensorError> {
        let all = self.survey.kept.len();
        let runs = self
            .trial
            .run(models, &self.mosaic, all, f64::INFINITY, |_, _| ())?;
        Ok(runs.iter().map(|ran| self.known(ran)).collect())
    }

    fn known(&self, ran: &Ran<F::Model>) -> Result<Known, String> {
        if let Some(why) = &ran.given_up {
            return Err(why.clone());
        }
        let start = (self.survey.clock)();
        let seconds = self.whole_sensor(ran);
        let timing = (self.survey.clock)() - start;
        let within = self.survey.within;
        let packets = (&self.full.packet, &ran.packet);
        let pair = Pair::new(packets.0, packets.1).map_err(|error| error.to_string())?;
        let tiles = change::of_pair(&self.mosaic, &self.probabilities, &pair, within);
        let unseen = self.trial.family.unseen(&ran.model, &self.look);
        let headline = self.survey.headline();
        let change = ChangeEstimate::new(&tiles, unseen, RISK / self.models.max(1) as f64);
        Ok(Known {
            change,
            f1: self.f1(&pair, within),
            kept: window::kept(self.f1(&pair, headline), self.floor),
            floor: self.floor,
            seconds: seconds.scaled(1.0, self.light_of(&ran.model)),
            planning: Some(self.spent + self.trial.whole_scene(ran) + timing),
        })
    }

    /// Seconds for the whole scene on the whole sensor.
    fn whole_sensor(&self, ran: &Ran<F::Model>) -> Spread {
        let Self { trial, survey, .. } = self;
        let frames = trial.frames(&ran.model);
        if let Some(each) = per_frame_on_the_whole(trial.family, &ran.model, survey) {
            return each.scaled(frames, 0.0);
        }
        let times = trial.larger_than(&self.mosaic) * frames;
        ran.parts.per_frame().scaled(times, 0.0)
    }

    /// Seconds that the light of a model takes.
    fn light_of(&self, model: &F::Model) -> f64 {
        self.trial.light_of(self.light, model)
    }

    /// What chance scores on these tiles.
    fn floor(&self) -> Result<f64, String> {
        let packet = &self.full.packet;
        let pair = Pair::new(packet, packet).map_err(|error| error.to_string())?;
        let headline = self.survey.headline();
        let redraws = (0..REDRAWS).map(|seed| baseline::redraw(&pair, seed));
        let sum: f64 = redraws.map(|redraw| self.f1(&redraw, headline)).sum();
        Ok(sum / REDRAWS as f64)
    }

    /// F1 of the whole sensor, from tiles that stand for others.
    fn f1(&self, pair: &Pair, within: Micros) -> f64 {
        let weight = |(cell, a, b): (Cell, Times<'_>, Times<'_>)| {
            let tile = self.mosaic.tile(cell.y().into(), cell.x().into())?;
            let weight = 1.0 / self.probabilities.get(tile)?;
            let matched = 2 * matching::matched_of_cell(a, b, within);
            Some([matched as f64 * weight, (a.len() + b.len()) as f64 * weight])
        };
        let [matched, all] = { pair.cells().filter_map(weight) }
            .fold([0.0; 2], |sum, one| [sum[0] + one[0], sum[1] + one[1]]);
        if all > 0.0 { matched / all } else { 1.0 }
    }
}

/// Seconds of a frame on the whole sensor, of its first ones; none where tiles tell.
fn per_frame_on_the_whole<F: Family>(
    family: &F,
    model: &F::Model,
    survey: &Survey<'_>,
) -> Option<Spread> {
    let kept = survey.kept;
    let sensor = family.on_the_whole(model, kept.size())?.ok()?;
    let frames = TIMED.min(kept.len().saturating_sub(1));
    let seconds = clocked(sensor, kept, frames, survey.clock).ok()??;
    Some(Spread::of(seconds))
}

/// The full model on the whole sensor: what everything is verified against.
pub struct Whole<'a, F: Family> {
    survey: Survey<'a>,
    family: &'a F,
    full: Packet,
    redraws: window::Redraws,
    seconds: Spread,
}

impl<'a, F: Family> Whole<'a, F> {
    /// Runs the full model.
    ///
    /// # Errors
    /// When it cannot go on.
    pub fn new(survey: Survey<'a>, family: &'a F) -> Result<Self, PlanError> {
        let (full, seconds) = run(&survey, family, &family.full())?;
        let pair = Pair::new(&full, &full).map_err(|_| SensorError::Stopped {
            sensor: "the full model".to_owned(),
            why: "its events are not of one size".to_owned(),
        })?;
        Ok(Self {
            redraws: window::Redraws::new(&pair, 0),
            survey,
            family,
            full,
            seconds,
        })
    }

    /// The full model beside itself.
    #[must_use]
    pub fn full(&self) -> Known {
        Known {
            change: all_of(self.full.events.len() as u64, 0),
            f1: 1.0,
            kept: Some(1.0),
            floor: self.redraws.floor(self.survey.headline()),
            seconds: self.seconds,
            planning: None,
        }
    }

    /// Events that the full model's readout had no room for.
    #[must_use]
    pub const fn dropped(&self) -> u64 {
        self.full.dropped.no_slot
    }

    /// Runs a model.
    ///
    /// # Errors
    /// When it cannot go on.
    pub fn ask(&self, model: &F::Model) -> Result<Known, PlanError> {
        let (packet, seconds) = run(&self.survey, self.family, model)?;
        let within = self.survey.within;
        let pair = Pair::new(&self.full, &packet).map_err(|error| SensorError::Stopped {
            sensor: "a plainer model".to_owned(),
            why: error.to_string(),
        })?;
        let [full, plain] = pair.events();
        let matched = matching::matched(&pair, within);
        let point = window::Point::new(&pair, &self.redraws, self.survey.headline());
        Ok(Known {
            change: all_of(full, full + plain - 2 * matched),
            f1: window::f1(&pair, within),
            kept: point.kept,
            floor: point.floor,
            seconds,
            planning: None,
        })
    }
}

/// The estimate where nothing is left to estimate.
fn all_of(events: u64, changes: u64) -> ChangeEstimate {
    let whole = Tile {
        probability: 1.0,
        events,
        squares: 0,
        alike: 0,
        changes,
    };
    ChangeEstimate::new(&[whole], History::Cell.into(), RISK)
}

/// Nobody waits for it any longer.
fn given_up(sensor: &dyn Sensor) -> SensorError {
    SensorError::Stopped {
        sensor: sensor.name().to_owned(),
        why: "it was told to".to_owned(),
    }
}

fn run<F: Family>(
    survey: &Survey<'_>,
    family: &F,
    model: &F::Model,
) -> Result<(Packet, Spread), PlanError> {
    let mut sensor = family.whole(model, survey.kept.size())?;
    let mut packet = Packet::new(sensor.size(), sensor.channels());
    let contrast = survey.upsample.filter(|_| family.sees_inserted(model));
    let mut scene = upsample::by_contrast(survey.kept.scene(), contrast)?;
    // The first of all frames pays for the start of threads and for cold memory: one part does.
    let (mut parts, mut frames) = (Parts::default(), 0.0);
    let mut last = (survey.clock)();
    rig::play(&mut *scene, |frame| {
        if survey.stop.is_asked() {
            return Err(given_up(&*sensor).into());
        }
        sensor.watch(&frame, &mut packet)?;
        let now = (survey.clock)();
        parts.add(now - last);
        (last, frames) = (now, frames + 1.0);
        Ok::<_, PlanError>(ControlFlow::Continue(()))
    })?;
    Ok((packet, parts.per_frame().scaled(frames, 0.0)))
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;
    use crate::{
        reference::Description,
        scene::{OpenOptions, open},
        study::pilot::{Choice, Floats},
    };

    #[test]
    fn the_start_is_not_charged_to_the_full_model() {
        let description = Description::open("dvs").unwrap();
        let base = Choice::full();
        let family = Floats {
            description: &description,
            seed: 0,
            base: &base,
        };
        let spec = "pattern:bar?width=8&height=6&frames=4";
        let mut scene = open(spec, &OpenOptions::default()).unwrap();
        let kept = Kept::new(&mut *scene, 1 << 20).unwrap().unwrap();
        // A first frame of 1 s, and three of 0.0625 s.
        let times = Mutex::new(vec![1.1875, 1.125, 1.0625, 1.0, 0.0]);
        let clock = || times.lock().unwrap().pop().unwrap();
        let survey = Survey {
            kept: &kept,
            upsample: None,
            within: Micros(100),
            seed: 0,
            clock: &clock,
            sample: 1.0,
            stop: Stop::NEVER,
        };
        let whole = Whole::new(survey, &family).unwrap();
        let seconds = whole.full().seconds;
        assert_eq!([seconds.median, seconds.most], [0.25, 4.0]);
    }
}
