//! The measurement: candidates against the full model on the tiles that can be afforded.

use std::cell::OnceCell;

use crate::{
    compare::Sorted,
    mosaic::Mosaic,
    scene::kept::Kept,
    sensor::SensorError,
    stop::Stop,
    unit::{Micros, counted},
};

use super::{
    answer::{Answer, Offer},
    change::{self, Change},
    draw::{Drawn, draw},
    estimate::{ChangeEstimate, RISK},
    family::Family,
    first_frames::clocked,
    look::{Grid, Look},
    stage::{self, Stage},
    trial::{LEAST_TILES, Ran, Trial},
};

/// How a measurement is made.
#[derive(Clone, Copy)]
pub struct Measure<'a> {
    /// The scene.
    pub kept: &'a Kept,
    /// The contrast that frames are inserted for, in ln units.
    pub upsample: Option<f64>,
    /// The share of events that may change.
    pub tolerance: f64,
    /// An event that is moved by more is changed.
    pub within: Micros,
    /// Draws the tiles.
    pub seed: u64,
    /// Seconds since any moment.
    pub clock: &'a (dyn Fn() -> f64 + Sync),
    /// What the pilot may spend: this part of what the full model is expected to take, and these
    /// seconds besides.
    pub budget: (f64, f64),
    /// So many tiles whatever they cost, in place of what the budget affords.
    pub tiles: Option<usize>,
    /// A look at the scene in the tiles of the family, where somebody had one already.
    pub look: Option<&'a Look>,
    /// Whether only limits are wanted: what changes far too much is dropped early, though tiles are
    /// given, and nothing is measured together.
    pub limits_only: bool,
}

/// Pixels of the mosaic on which costs are learned, and frames of the scene.
const TRIED_PIXELS: usize = 1 << 11;
const TRIED_FRAMES: usize = 6;

/// Frames that are tried in all, about, where some are inserted.
const TRIED_INSERTED: usize = 30;

/// Frames on the whole sensor behind the first, where tiles do not tell what it costs.
const TRIED_WHOLE: usize = 1;

/// What would save less than this part of the full model's time is not worth it.
pub(super) const WORTH: f64 = 0.07;

impl Measure<'_> {
    /// Measures candidates, each with what it is called, against the full model.
    ///
    /// # Errors
    /// When the full model cannot be made.
    pub fn ask<F: Family>(
        &self,
        family: &F,
        candidates: &[(String, F::Model)],
    ) -> Result<Answer<F::Model>, SensorError> {
        let start = (self.clock)();
        let offer = |(what, model): &(String, F::Model)| Offer {
            what: what.clone(),
            model: model.clone(),
            change: None,
            seconds: None,
            left_out: false,
            why: String::new(),
        };
        let mut answer = Answer {
            choice: family.full(),
            change: None,
            offers: candidates.iter().map(offer).collect(),
            why: String::new(),
            seconds: 0.0,
            expected: None,
        };
        match self.answer(family, start, &mut answer) {
            Ok(()) => "it is the quickest within the tolerance".clone_into(&mut answer.why),
            Err(End::Because(why)) => answer.why = why,
            Err(End::Sensor(error)) => return Err(error),
        }
        for offer in &mut answer.offers {
            if offer.why.is_empty() {
                offer.why.clone_from(&answer.why);
            }
        }
        answer.seconds = (self.clock)() - start;
        Ok(answer)
    }

    fn answer<F: Family>(&self, family: &F, start: f64, answer: &mut Answer<F::Model>) -> Step<()> {
        if answer.offers.is_empty() {
            return because("there is nothing to leave out that takes time");
        }
        if self.tolerance <= 0.0 {
            return because("nothing may change");
        }
        if self.kept.len() < 3 {
            return because("the scene is too short to measure anything");
        }
        let halo = family.halo().map_err(|why| End::Because(why.to_owned()))?;
        let grid = Grid::new(self.kept.size(), halo);
        if grid.tiles() < 2 * LEAST_TILES && self.tiles.is_none() {
            return because("the sensor is too small to be sampled");
        }
        let between = match self.upsample {
            Some(contrast) => {
                let between = stage::between(self.kept, contrast);
                Some(between.ok_or_else(|| End::Because("frames cannot be inserted".to_owned()))?)
            }
            None => None,
        };
        let look = match self.look.filter(|look| look.grid == grid) {
            Some(look) => look.clone(),
            None => Look::new(self.kept, grid, family.is_relative()),
        };
        let trial = Trial {
            family,
            kept: self.kept,
            between: between.as_ref(),
            grid,
            halo,
            clock: self.clock,
            stop: Stop::NEVER,
        };
        let pilot = Pilot {
            measure: self,
            start,
            light: match &between {
                Some(_) => stage::seconds_of_light(self.kept, between.as_ref(), self.clock),
                None => [0.0; 2],
            },
            activity: trial.activity(&look),
            trial,
            look,
        };
        let count = match self.tiles {
            Some(count) => count,
            None => pilot.afford(answer)?,
        };
        pilot.choose(count, answer)
    }
}

/// Why a pilot ends before it has measured.
enum End {
    Because(String),
    Sensor(SensorError),
}

impl From<SensorError> for End {
    fn from(error: SensorError) -> Self {
        Self::Sensor(error)
    }
}

type Step<T> = Result<T, End>;

fn because<T>(why: &str) -> Step<T> {
    Err(End::Because(why.to_owned()))
}

/// A pilot that has looked at the scene.
struct Pilot<'a, F> {
    measure: &'a Measure<'a>,
    start: f64,
    /// Seconds of the light on the whole sensor, with the inserted frames and without, where any
    /// are inserted.
    light: [f64; 2],
    trial: Trial<'a, F>,
    look: Look,
    activity: Vec<f64>,
}

/// The models that go on: the full one, and the offers of which nothing is said yet.
fn going<M: Clone>(full: M, offers: &[Offer<M>]) -> Vec<M> {
    let going = offers.iter().filter(|offer| offer.why.is_empty());
    let models = going.map(|offer| offer.model.clone());
    std::iter::once(full).chain(models).collect()
}

impl<F: Family> Pilot<'_, F> {
    fn drawn(&self, count: usize) -> Vec<Drawn> {
        let Self { look, measure, .. } = self;
        draw(&self.activity, &look.extremes, count, measure.seed)
    }

    /// Learns what models cost by running them on a few tiles for a few frames, drops those that
    /// would save too little, and says how many tiles can be afforded.
    fn afford(&self, answer: &mut Answer<F::Model>) -> Step<usize> {
        let Self { trial, measure, .. } = self;
        let on_the_whole = self.time_to_try(answer)?;
        let few = self.drawn((TRIED_PIXELS / trial.pixels()).max(LEAST_TILES));
        if few.is_empty() {
            return because("nothing ever changes");
        }
        let mosaic = trial.mosaic(&few);
        let models = going(trial.family.full(), &answer.offers);
        let [inserted, own] = Stage::frames(measure.kept, trial.between);
        let frames = (TRIED_INSERTED * own / inserted.max(1)).clamp(3, TRIED_FRAMES);
        // Where only tiles tell what the full model takes, nothing is known yet to stop by.
        let late = on_the_whole.map_or(f64::INFINITY, |whole| self.start + self.allowed(whole));
        let is_late = || late.is_finite() && (measure.clock)() > late;
        let tried = trial.run(&models, &mosaic, frames, late, |_, _| ())?;
        if is_late() {
            return because(TOO_QUICK);
        }
        let Some((reference, others)) = tried.split_first() else {
            return because("nothing was run");
        };
        if let Some(why) = &reference.given_up {
            return Err(End::Because(format!("the full model stops: {why}")));
        }
        let larger = trial.larger_than(&mosaic);
        let of_tiles =
            |ran: &Ran<F::Model>| larger * trial.whole_scene(ran) + self.light_of(&ran.model);
        let expected = |ran: &Ran<F::Model>| {
            let whole = self.on_the_whole(&ran.model);
            whole.unwrap_or_else(|| of_tiles(ran))
        };
        let whole = on_the_whole.unwrap_or_else(|| of_tiles(reference));
        answer.expected = Some([whole, whole]);
        let mut each = trial.whole_scene(reference);
        let full = Sorted::new(&reference.packet).ok();
        let going = answer
            .offers
            .iter_mut()
            .filter(|offer| offer.why.is_empty());
        for (offer, ran) in going.zip(others) {
            if is_late() {
                return because(TOO_QUICK);
            }
            let seconds = expected(ran);
            offer.seconds = Some([seconds, whole]);
            let much = || self.changes_much(full.as_ref()?, ran);
            if let Some(why) = ran.given_up.clone().or_else(much) {
                offer.why = why;
            } else if whole - seconds < WORTH * whole {
                SAVES_LITTLE.clone_into(&mut offer.why);
            } else {
                each += trial.whole_scene(ran);
            }
        }
        if answer.offers.iter().all(|offer| !offer.why.is_empty()) {
            let saves = |offer: &Offer<_>| offer.why != SAVES_LITTLE && offer.why != NOT_TRIED;
            return because(if answer.offers.iter().any(saves) {
                "nothing to win: what would save time changes too much"
            } else {
                "nothing to win: what could be left out takes hardly any time"
            });
        }
        // A sample costs time now and saves some later: no more than half of what may be saved.
        let going = answer.offers.iter().filter(|offer| offer.why.is_empty());
        let saves: f64 = { going.filter_map(|offer| offer.seconds) }
            .map(|[plain, full]| full - plain)
            .sum();
        let left = self.allowed(whole) - ((measure.clock)() - self.start);
        // Some is left for a last trial of all that may go together. `as` saturates.
        let tile = each / mosaic.tiles().len() as f64;
        let affordable = ((0.7 * left).min(saves / 2.0) / tile) as usize;
        if affordable < LEAST_TILES {
            return because(TOO_QUICK);
        }
        Ok(affordable.min(trial.grid.tiles()))
    }

    /// Seconds of the full model, where only the whole sensor tells them. Candidates are then tried
    /// on the whole sensor as well: so many of the first as there is time for.
    fn time_to_try(&self, answer: &mut Answer<F::Model>) -> Step<Option<f64>> {
        let start = (self.measure.clock)();
        let Some(whole) = self.on_the_whole(&self.trial.family.full()) else {
            return Ok(None);
        };
        let now = (self.measure.clock)();
        answer.expected = Some([whole, whole]);
        // The rest is for the sample. `as` saturates.
        let left = TRYING * (self.allowed(whole) - (now - self.start));
        let most = (left / (now - start)) as usize;
        if most == 0 {
            return because(TOO_QUICK);
        }
        for offer in answer.offers.iter_mut().skip(most) {
            NOT_TRIED.clone_into(&mut offer.why);
        }
        Ok(Some(whole))
    }

    /// Seconds that the light of a model takes, beyond that of the scene's own frames.
    fn light_of(&self, model: &F::Model) -> f64 {
        self.trial.light_of(self.light, model)
    }

    /// Seconds that a model takes for the whole scene, from its first frames on the whole sensor;
    /// none where tiles tell them.
    fn on_the_whole(&self, model: &F::Model) -> Option<f64> {
        let Self { trial, measure, .. } = self;
        let kept = measure.kept;
        let sensor = trial.family.on_the_whole(model, kept.size())?.ok()?;
        let seconds = clocked(sensor, kept, TRIED_WHOLE, measure.clock).ok()??;
        let each = seconds.iter().sum::<f64>() / TRIED_WHOLE as f64;
        let [all, _] = Stage::frames(kept, trial.between);
        Some(each * all as f64)
    }

    /// Seconds that the pilot may take, of a full model that takes so many.
    fn allowed(&self, whole: f64) -> f64 {
        let (part, besides) = self.measure.budget;
        part * whole + besides
    }

    /// Runs what goes on on so many tiles, and chooses.
    fn choose(&self, count: usize, answer: &mut Answer<F::Model>) -> Step<()> {
        let Self { trial, measure, .. } = self;
        let drawn = self.drawn(count);
        let mosaic = trial.mosaic(&drawn);
        let models = going(trial.family.full(), &answer.offers);
        let whole = answer.expected.map_or(0.0, |[whole, _]| whole);
        // Who asks for tiles waits for them.
        let late = match measure.tiles {
            Some(_) => f64::INFINITY,
            None => self.start + 2.0 * self.allowed(whole),
        };
        let all = measure.kept.len();
        let runs = trial.run(&models, &mosaic, all, late, |shown, runs| {
            self.drop_early(shown, runs);
        })?;
        let Some((reference, others)) = runs.split_first() else {
            return because("nothing was run");
        };
        if let Some(why) = &reference.given_up {
            return Err(End::Because(why.clone()));
        }
        // Each candidate and what goes together has a limit, and all are to hold.
        let judge = Judge {
            pilot: self,
            mosaic: &mosaic,
            probabilities: drawn.iter().map(|one| one.probability).collect(),
            reference,
            full: Sorted::new(&reference.packet)
                .map_err(|error| End::Because(error.to_string()))?,
            risk: RISK / models.len() as f64,
        };
        let going = answer
            .offers
            .iter_mut()
            .filter(|offer| offer.why.is_empty());
        for (offer, ran) in going.zip(others) {
            judge.fill(offer, ran, whole);
        }
        let allowed: Vec<&Offer<F::Model>> = { answer.offers.iter() }
            .filter(|offer| offer.change.is_some_and(|c| c.is_within(measure.tolerance)))
            .collect();
        if allowed.is_empty() {
            let is_late = |offer: &Offer<F::Model>| offer.change.is_none();
            return because(if answer.offers.iter().any(is_late) {
                NONE_SAVES
            } else {
                "no plainer model stays within the tolerance"
            });
        }
        // What is allowed by itself need not be together: that is measured too.
        let apart: Vec<F::Model> = allowed.iter().map(|offer| offer.model.clone()).collect();
        let together = trial
            .family
            .together(&apart)
            .filter(|_| !measure.limits_only && apart.len() > 1);
        if let Some(together) = together
            && !apart.contains(&together)
        {
            let mut offer = Offer {
                what: "all of these".to_owned(),
                model: together.clone(),
                change: None,
                seconds: None,
                left_out: false,
                why: String::new(),
            };
            for ran in trial.run(&[together], &mosaic, all, late, |_, _| ())? {
                judge.fill(&mut offer, &ran, whole);
            }
            answer.offers.push(offer);
        }
        self.take_quickest(answer)
    }

    /// Chooses the quickest model within the tolerance: one that is quicker than the full one, since
    /// what was so on a few tiles need not be on more.
    fn take_quickest(&self, answer: &mut Answer<F::Model>) -> Step<()> {
        let Measure {
            tolerance,
            limits_only,
            ..
        } = *self.measure;
        let is_allowed =
            |offer: &Offer<F::Model>| offer.change.is_some_and(|c| c.is_within(tolerance));
        let mut quickest: Option<(f64, &mut Offer<F::Model>)> = None;
        for offer in answer.offers.iter_mut().filter(|offer| is_allowed(offer)) {
            let [plain, full] = offer.seconds.unwrap_or([f64::INFINITY; 2]);
            let saves = plain < full;
            if !saves && !limits_only {
                SAVES_LITTLE.clone_into(&mut offer.why);
            } else if quickest.as_ref().is_none_or(|(least, _)| plain < *least) {
                quickest = Some((plain, offer));
            }
        }
        let Some((_, offer)) = quickest else {
            return because(NONE_SAVES);
        };
        offer.left_out = true;
        answer.choice = offer.model.clone();
        answer.change = offer.change;
        answer.expected = offer.seconds.map(|[plain, full]| [full, plain]);
        Ok(())
    }

    /// Gives candidates up that would save too little, or that change far too much.
    fn drop_early(&self, shown: usize, runs: &mut [Ran<F::Model>]) {
        let of = self.measure.kept.len();
        let Some((reference, others)) = runs.split_first_mut() else {
            return;
        };
        if shown != (of / 8).max(4) && shown != of / 2 {
            return;
        }
        let whole = self.trial.whole_scene(reference);
        let by_time = self.measure.tiles.is_none();
        // Sorted once for all candidates.
        let full = OnceCell::new();
        for ran in others.iter_mut().filter(|ran| ran.given_up.is_none()) {
            if by_time && whole - self.trial.whole_scene(ran) < WORTH * whole {
                ran.given_up = Some(SAVES_LITTLE.to_owned());
            } else if (by_time || self.measure.limits_only)
                && let Some(full) = full.get_or_init(|| Sorted::new(&reference.packet).ok())
                && let Some(why) = self.changes_much(full, ran)
            {
                ran.given_up = Some(why);
            }
        }
    }

    /// Whether so much changes already that more of the scene need not be seen.
    fn changes_much(&self, full: &Sorted, plain: &Ran<F::Model>) -> Option<String> {
        let pair = full.judge(&plain.packet).ok()?;
        let change = Change::of_pair(&pair, self.measure.within);
        let is_much = change.share > 5.0 * self.measure.tolerance;
        let told = || {
            format!(
                "{:.0} % of the events of a few tiles change",
                100.0 * change.share
            )
        };
        (is_much && change.missing + change.extra > 50).then(told)
    }
}

const SAVES_LITTLE: &str = "it would save too little";

const NONE_SAVES: &str = "no plainer model both stays within the tolerance and saves enough";

const NOT_TRIED: &str = "there is no time to try it";

const TOO_QUICK: &str = "the part of the full run's time that a pilot may take is too short for a sample that says anything";

/// The part of a pilot's time that may go into trying what candidates cost on the whole sensor.
const TRYING: f64 = 0.4;

/// What candidates are judged by.
struct Judge<'a, F: Family> {
    pilot: &'a Pilot<'a, F>,
    mosaic: &'a Mosaic,
    probabilities: Vec<f64>,
    reference: &'a Ran<F::Model>,
    /// Its events.
    full: Sorted,
    risk: f64,
}

impl<F: Family> Judge<'_, F> {
    /// Fills in what a run says of an offer, `whole` being the seconds of the full model.
    fn fill(&self, offer: &mut Offer<F::Model>, ran: &Ran<F::Model>, whole: f64) {
        let Pilot {
            measure,
            trial,
            look,
            ..
        } = self.pilot;
        if let Some(why) = &ran.given_up {
            offer.why.clone_from(why);
            return;
        }
        match self.full.judge(&ran.packet) {
            Err(error) => offer.why = error.to_string(),
            Ok(pair) => {
                let within = measure.within;
                let tiles = change::of_pair(self.mosaic, &self.probabilities, &pair, within);
                let unseen = trial.family.unseen(&ran.model, look);
                let change = ChangeEstimate::new(&tiles, unseen, self.risk);
                let change = match trial.family.loses(measure.kept.size()) {
                    Some(_) => change.behind_slots(),
                    None => change,
                };
                offer.change = Some(change);
                offer.why = said(change, measure.tolerance);
            }
        }
        // Who wants limits only asks for no times.
        let timed = (!measure.limits_only).then(|| self.pilot.on_the_whole(&ran.model));
        let seconds = timed.flatten().unwrap_or_else(|| {
            let [full, own] = [self.reference, ran].map(|ran| self.pilot.light_of(&ran.model));
            let part = trial.whole_scene(ran) / trial.whole_scene(self.reference);
            (whole - full) * part + own
        });
        offer.seconds = Some([seconds, whole]);
    }
}

/// What a limit says beside a tolerance.
fn said(change: ChangeEstimate, tolerance: f64) -> String {
    let ChangeEstimate {
        events,
        changes,
        tiles,
        ..
    } = change;
    let measured = format!(
        "{} in {} of {}",
        counted(changes, "change"),
        counted(events, "event"),
        counted(tiles, "tile")
    );
    match (change.limit, change.no_limit) {
        (None, Some(why)) => format!("{measured}: {why}"),
        (Some(limit), _) if limit <= tolerance => measured,
        _ => format!("{measured}: that may be more than is tolerated"),
    }
}
