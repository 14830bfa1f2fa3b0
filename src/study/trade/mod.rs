//! The trade: error against seconds, for every plainer model of one sensor in one scene.
//!
//! ```text
//! [Family] models ─► [survey] on tiles: changes, their limit, seconds, what it took to know ─┐
//!                 ─► [survey] on the whole scene, where that is asked for, or has to be ─────┤
//!                                                    [front] what no other beats ─ [knee] ◄──┘
//! ```
//!
//! First each thing is left out by itself; then what changes least is left out together, one
//! more at a time, in the full model's numbers and in the best of the others.

pub mod answer;
mod floats;
mod programs;
mod together;
pub mod told;

use std::fmt;

use serde::Serialize;

use crate::{elementary, order::Order};

use super::{
    front::Cost,
    pilot::{
        Grid, Known, Look, NoLimit, PlanError, Sampled, Spread, Survey,
        family::Family,
        survey::{Whole, inserted},
    },
};

pub use programs::{Programs, Setup};
pub use together::together;

/// Number formats that are tried of a sensor where none are named.
pub const OF_SENSOR: [&str; 5] = ["f32", "f16", "bf16", "q16.16", "q8.8"];

/// The same of a program.
pub const OF_PROGRAM: [&str; 4] = ["exact", "f32", "f16", "q8.8"];

/// A model, and where it stands.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(bound = "")]
pub struct Point<M> {
    /// What it is called.
    pub name: String,
    /// The model.
    #[serde(skip)]
    pub model: M,
    /// What the tiles say; none where there are none.
    pub sampled: Option<Known>,
    /// What the whole scene says, where it was run.
    pub whole: Option<Known>,
    /// Why it changes nothing, where a rule says so.
    pub free: Option<&'static str>,
    /// Whether nothing is better in both error and seconds.
    pub on_front: bool,
    /// The point on the front that beats it.
    pub beaten_by: Option<String>,
    /// Whether it is the knee of the front.
    pub is_knee: bool,
    /// Why nothing is known of it.
    pub why: Option<String>,
}

/// All models of a sensor in a scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(bound = "")]
pub struct Trade<M> {
    /// In the order of their seconds, planning included.
    pub points: Vec<Point<M>>,
    /// The tiles that were run; none where everything was run whole.
    pub tiles: Option<Sampled>,
    /// Why there are no tiles.
    pub no_tiles: Option<String>,
    /// Events of the full model that found no slot of its readout, in the whole scene: where there
    /// may be any, there are no tiles.
    pub without_slot: u64,
}

impl<M> Trade<M> {
    /// The most that chance scores where `kept` is measured.
    #[must_use]
    pub fn floor(&self) -> f64 {
        let floors = self.points.iter().filter_map(Point::known);
        floors.map(|known| known.floor).fold(0.0, f64::max)
    }
}

impl<M> Point<M> {
    /// What is known best: of the whole scene, else of the tiles.
    #[must_use]
    pub fn known(&self) -> Option<Known> {
        self.whole.or(self.sampled)
    }

    /// The share of changed events, or its upper confidence limit (95 %) where that was not measured
    /// whole.
    #[must_use]
    pub fn error(&self) -> Option<f64> {
        match self.free {
            Some(_) if self.whole.is_none() => Some(0.0),
            _ => self.known()?.change.limit,
        }
    }

    /// Why that is not known of a model that was run.
    #[must_use]
    pub fn no_limit(&self) -> Option<NoLimit> {
        let change = self.known()?.change;
        change.no_limit.filter(|_| self.error().is_none())
    }

    /// Seconds that it took to know that, of each run that shares them.
    #[must_use]
    pub fn planning(&self) -> f64 {
        self.sampled.and_then(|known| known.planning).unwrap_or(0.0)
    }

    /// Seconds with the planning.
    #[must_use]
    pub fn seconds(&self) -> Option<f64> {
        Some(self.spread()?.median)
    }

    /// The same with the least and the most that were measured.
    #[must_use]
    pub fn spread(&self) -> Option<Spread> {
        Some(self.known()?.seconds.scaled(1.0, self.planning()))
    }

    fn cost(&self) -> Option<Cost> {
        Some(Cost {
            x: self.seconds()?,
            y: self.error()?,
        })
    }
}

impl<M> Trade<M> {
    /// The points that nothing beats, the quickest first.
    pub fn front(&self) -> impl Iterator<Item = &Point<M>> {
        self.points.iter().filter(|point| point.on_front)
    }

    /// The knee of the front; there is one where the front has a point.
    #[must_use]
    pub fn knee(&self) -> Option<&Point<M>> {
        self.points.iter().find(|point| point.is_knee)
    }

    /// Why there is no knee, where there is none.
    #[must_use]
    pub fn no_knee(&self) -> Option<&'static str> {
        (self.knee().is_none()).then_some(NO_KNEE)
    }
}

/// What is asked.
pub struct Ask<'a, M> {
    /// How the survey is made.
    pub survey: Survey<'a>,
    /// Things left out one at a time, and other numbers.
    pub models: Vec<M>,
    /// Whether a model is another's alternative, and not together with it: a number format.
    pub alternative: &'a dyn Fn(&M) -> bool,
    /// Why a model changes nothing, where that needs no measurement.
    pub free: &'a dyn Fn(&M, &Look) -> Option<&'static str>,
    /// Whether everything is run on the whole scene, too.
    pub verify: bool,
    /// How many runs share the planning.
    pub runs: u32,
    /// Called before each model is run whole, and before the tiles.
    pub begin: &'a dyn Fn(&str),
}

/// Measures all of it.
///
/// # Errors
/// When a model cannot be made, or the full one cannot go on.
pub fn trade<F>(family: &F, ask: &Ask<'_, F::Model>) -> Result<Trade<F::Model>, PlanError>
where
    F: Family,
    F::Model: fmt::Display,
{
    let survey = ask.survey;
    let full = family.full();
    let mut trade = Trade {
        points: vec![point(full.clone(), FULL.to_owned())],
        tiles: None,
        no_tiles: None,
        without_slot: 0,
    };
    for model in ask.models.iter().filter(|model| **model != full) {
        trade.add(model.clone());
    }
    let between = inserted(survey.kept, survey.upsample);
    let begun = between.as_ref().map_err(String::clone).and_then(|between| {
        (ask.begin)("tiles");
        // As many more come together later.
        survey.begin(family, between.as_ref(), 2 * trade.points.len())
    });
    match begun {
        Err(why) => {
            trade.no_tiles = Some(why);
            let whole = Whole::new(survey, family)?;
            trade.run_whole(&whole, ask);
            trade.add_together(family, ask);
            trade.run_whole(&whole, ask);
            let grid = Grid::new(survey.kept.size(), family.halo().unwrap_or(0));
            let look = Look::new(survey.kept, grid, family.is_relative());
            for point in trade.points.iter_mut().filter(|it| it.model != full) {
                point.free = (ask.free)(&point.model, &look);
            }
        }
        Ok(begun) => {
            trade.tiles = Some(begun.sampled());
            for _ in 0..2 {
                let todo: Vec<usize> = trade.unknown();
                let models: Vec<F::Model> = { todo.iter() }
                    .filter_map(|i| Some(trade.points.get(*i)?.model.clone()))
                    .filter(|model| *model != full)
                    .collect();
                let mut known = begun.ask(&models)?.into_iter();
                for i in todo {
                    let Some(point) = trade.points.get_mut(i) else {
                        continue;
                    };
                    if point.model == full {
                        point.sampled = Some(begun.full());
                        continue;
                    }
                    point.free = (ask.free)(&point.model, begun.look());
                    match known.next() {
                        Some(Ok(mut known)) => {
                            // What a rule allows needs no tiles.
                            let planning = match point.free {
                                Some(_) => Some(0.0),
                                None => known.planning.map(|s| s / f64::from(ask.runs)),
                            };
                            known.planning = planning;
                            point.sampled = Some(known);
                        }
                        Some(Err(why)) => point.why = Some(why),
                        None => {}
                    }
                }
                trade.add_together(family, ask);
            }
            trade
                .points
                .retain(|point| point.sampled.is_some() || point.why.is_some());
            if ask.verify {
                trade.run_whole(&Whole::new(survey, family)?, ask);
            }
        }
    }
    trade.judge();
    Ok(trade)
}

/// Why there is no front, and no knee of it.
const NO_KNEE: &str = "no model has both its seconds and its error known; each says why";

/// What the full model is called.
pub const FULL: &str = "the full model";

fn point<M>(model: M, name: String) -> Point<M> {
    Point {
        name,
        model,
        sampled: None,
        whole: None,
        free: None,
        on_front: false,
        beaten_by: None,
        is_knee: false,
        why: None,
    }
}

impl<M: Clone + PartialEq + fmt::Display> Trade<M> {
    fn add(&mut self, model: M) {
        if !self.points.iter().any(|point| point.model == model) {
            let name = model.to_string();
            self.points.push(point(model, name));
        }
    }

    /// Points of which nothing is known yet.
    fn unknown(&self) -> Vec<usize> {
        let points = self.points.iter().enumerate();
        points
            .filter(|(_, point)| point.known().is_none() && point.why.is_none())
            .map(|(i, _)| i)
            .collect()
    }

    fn add_together<F: Family<Model = M>>(&mut self, family: &F, ask: &Ask<'_, M>) {
        for model in together(family, &self.points, ask.alternative) {
            self.add(model);
        }
    }

    fn run_whole<F: Family<Model = M>>(&mut self, whole: &Whole<'_, F>, ask: &Ask<'_, M>) {
        self.without_slot = whole.dropped();
        for point in &mut self.points {
            if point.whole.is_some() || point.why.is_some() {
                continue;
            }
            (ask.begin)(&point.name);
            if point.name == FULL {
                point.whole = Some(whole.full());
                continue;
            }
            match whole.ask(&point.model) {
                Ok(known) => point.whole = Some(known),
                // What its tiles say is of no use.
                Err(error) => (point.sampled, point.why) = (None, Some(error.to_string())),
            }
        }
    }
}

impl<M> Trade<M> {
    /// Puts the points in order, and marks the front and its knee.
    ///
    /// The knee is the point of the front that is nearest to the corner where nothing changes and
    /// nothing is quicker (the utopia point of compromise programming, Yu 1973), seconds counted
    /// as a share of the full model's: one per cent of the events weighs as one of the time. What
    /// was measured of it and of another point of the front may overlap: then seconds do not tell
    /// them apart, and the one that changes less is the knee. Nor does a point beat another by such
    /// seconds alone. One that is hardly faster than the full model is no knee: then that is the
    /// full model, or what changes least where another beats it. A front with a point has a knee.
    fn judge(&mut self) {
        let seconds = |point: &Point<M>| point.seconds().unwrap_or(f64::INFINITY);
        self.points
            .order_by(|a, b| seconds(a).total_cmp(&seconds(b)));
        let placed = self.points.iter().enumerate();
        let placed: Vec<Placed> = placed
            .filter_map(|(at, point)| {
                Some(Placed {
                    at,
                    cost: point.cost()?,
                    spread: point.spread()?,
                    is_full: point.name == FULL,
                })
            })
            .collect();
        let mut front: Vec<Placed> = Vec::new();
        for own in &placed {
            // The first of those that change least is the quickest.
            let by = { placed.iter() }
                .filter(|by| by.beats(own))
                .min_by(|a, b| a.cost.y.total_cmp(&b.cost.y));
            let by = by.and_then(|by| Some(self.points.get(by.at)?.name.clone()));
            if by.is_none() {
                front.push(*own);
            }
            if let Some(point) = self.points.get_mut(own.at) {
                point.on_front = by.is_none();
                point.beaten_by = by;
            }
        }
        let full = placed.iter().find(|placed| placed.is_full);
        if let Some(point) = knee(&front, full).and_then(|at| self.points.get_mut(at)) {
            point.is_knee = true;
        }
    }
}

/// A point of which error and seconds are known.
#[derive(Clone, Copy)]
struct Placed {
    /// Its number.
    at: usize,
    cost: Cost,
    spread: Spread,
    is_full: bool,
}

impl Placed {
    fn beats(&self, other: &Self) -> bool {
        let is_told = self.cost.y < other.cost.y || !self.spread.overlaps(other.spread);
        self.cost.dominates(other.cost) && is_told
    }
}

/// How many times as fast as the full model a knee is at least: less is written as 1.0.
const FASTER: f64 = 1.05;

/// The number of the front's knee.
fn knee(front: &[Placed], full: Option<&Placed>) -> Option<usize> {
    let all = full.map_or(1.0, |full| full.cost.x).max(1e-9);
    let costs = front.iter().map(|placed| placed.cost.x);
    let least = costs.fold(f64::INFINITY, f64::min);
    let away = |placed: &Placed| {
        let late = (placed.cost.x - least) / all;
        elementary::hypot(late, placed.cost.y)
    };
    let nearest = { front.iter() }.min_by(|a, b| away(a).total_cmp(&away(b)))?;
    let alike = front
        .iter()
        .filter(|other| other.cost.y <= nearest.cost.y && other.spread.overlaps(nearest.spread));
    let knee = alike.min_by(|a, b| {
        let error = a.cost.y.total_cmp(&b.cost.y);
        error
            .then(b.is_full.cmp(&a.is_full))
            .then(away(a).total_cmp(&away(b)))
    })?;
    if full.is_none_or(|full| full.cost.x >= FASTER * knee.cost.x) {
        return Some(knee.at);
    }
    // Where the full model is not on the front, what changes nothing has beaten it: a little time for
    // nothing is worth having. The first of these is the quickest.
    let least = { front.iter() }.min_by(|a, b| a.cost.y.total_cmp(&b.cost.y));
    let full = front.iter().find(|placed| placed.is_full);
    full.or(least).map(|placed| placed.at)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::pilot::ChangeEstimate;

    fn known(seconds: Spread, limit: Option<f64>, planning: f64) -> Known {
        let (tiles, events, changes) = (10, 1000, 0);
        let share = limit.unwrap_or(0.0) / 2.0;
        Known {
            change: ChangeEstimate {
                share,
                limit,
                no_limit: limit.is_none().then_some(NoLimit::FewEvents),
                tiles,
                events,
                changes,
            },
            f1: 1.0 - share,
            kept: Some(1.0 - share),
            floor: 0.0,
            seconds,
            planning: Some(planning),
        }
    }

    fn judged(points: &[(&'static str, f64, Option<f64>, f64)]) -> Trade<&'static str> {
        let exact = |(name, seconds, limit, planning): &(&'static str, f64, _, _)| {
            let seconds = Spread::of(vec![*seconds]);
            (*name, seconds, *limit, *planning)
        };
        spread(&points.iter().map(exact).collect::<Vec<_>>())
    }

    fn spread(points: &[(&'static str, Spread, Option<f64>, f64)]) -> Trade<&'static str> {
        let points = { points.iter() }
            .map(|(name, seconds, limit, planning)| Point {
                sampled: Some(known(*seconds, *limit, *planning)),
                ..point("", (*name).to_owned())
            })
            .collect();
        let mut trade = Trade {
            points,
            tiles: None,
            no_tiles: None,
            without_slot: 0,
        };
        trade.judge();
        trade
    }

    #[test]
    fn the_knee_is_where_little_changes_for_much_time() {
        let trade = judged(&[
            (FULL, 10.0, Some(0.0), 0.0),
            ("f32", 5.0, Some(0.002), 0.1),
            ("bf16", 4.9, Some(0.4), 0.1),
            ("f16", 20.0, Some(0.1), 0.1),
            ("unknown", 1.0, None, 0.1),
        ]);
        let front: Vec<&str> = trade.front().map(|point| point.name.as_str()).collect();
        assert_eq!(front, ["bf16", "f32", FULL]);
        assert_eq!(trade.knee().unwrap().name, "f32");
        let beaten = trade.points.iter().find(|point| point.name == "f16");
        assert_eq!(beaten.unwrap().beaten_by.as_deref(), Some(FULL));
        assert!(!trade.points[0].on_front, "nothing is known of its error");
    }

    #[test]
    fn planning_is_part_of_the_price() {
        let with = |planning| {
            let trade = judged(&[
                (FULL, 1.0, Some(0.0), 0.0),
                ("f32", 0.8, Some(0.0), planning),
            ]);
            trade.knee().unwrap().name.clone()
        };
        assert_eq!([with(0.1), with(0.3)], ["f32", FULL]);
    }

    #[test]
    fn what_is_hardly_faster_is_no_knee() {
        let knee = |limit, seconds| {
            let trade = judged(&[
                (FULL, 1.0, Some(0.0), 0.0),
                ("f32", seconds, Some(limit), 0.0),
            ]);
            trade.knee().map(|point| point.name.clone())
        };
        assert_eq!(knee(0.001, 0.96).as_deref(), Some(FULL));
        // The full model is not on the front, since the other changes nothing.
        assert_eq!(knee(0.0, 0.96).as_deref(), Some("f32"));
        // Whatever else is quicker still, but hardly.
        let trade = judged(&[
            (FULL, 1.0, Some(0.0), 0.0),
            ("f32", 0.99, Some(0.0), 0.0),
            ("f16", 0.97, Some(0.001), 0.0),
        ]);
        assert_eq!(trade.knee().unwrap().name, "f32");
        assert_eq!(knee(0.0, 0.94).as_deref(), Some("f32"));
    }

    #[test]
    fn equal_seconds_have_a_knee() {
        let same = [
            (FULL, 1.0, Some(0.0), 0.0),
            ("f32", 1.0, Some(0.0), 0.0),
            ("f16", 1.0, Some(0.1), 0.0),
        ];
        assert_eq!(judged(&same).knee().unwrap().name, FULL);
        // Too quick for the clock.
        let none = same.map(|(name, _, limit, planning)| (name, 0.0, limit, planning));
        assert_eq!(judged(&none).knee().unwrap().name, FULL);
        // Nothing is known of the full model.
        let blind = [(FULL, 1.0, None, 0.0), ("f32", 1.0, Some(0.5), 0.0)];
        assert_eq!(judged(&blind).knee().unwrap().name, "f32");
        let unknown = judged(&[(FULL, 1.0, None, 0.0), ("f32", 1.0, None, 0.0)]);
        assert_eq!((unknown.front().count(), unknown.knee()), (0, None));
        assert!(unknown.no_knee().is_some());
    }

    proptest::proptest! {
        /// Whatever was measured, a front with a point has one knee, which is on it.
        #[test]
        fn every_front_has_a_knee(
            points in proptest::collection::vec((0..12_u8, 0..4_u8, 0..4_u8), 1..9)
        ) {
            let points: Vec<_> = { points.into_iter().enumerate() }
                .map(|(n, (least, wide, limit))| {
                    let least = 0.9 + 0.02 * f64::from(least);
                    let seconds = Spread::of(vec![least, least + 0.02 * f64::from(wide)]);
                    let (name, limit) = if n == 0 {
                        (FULL, 0.0)
                    } else {
                        ("another", 0.002 * f64::from(limit))
                    };
                    (name, seconds, Some(limit), 0.0)
                })
                .collect();
            let trade = spread(&points);
            let knee = trade.knee();
            proptest::prop_assert!(knee.is_some_and(|knee| knee.on_front));
            proptest::prop_assert_eq!(trade.no_knee(), None);
        }
    }

    #[test]
    fn seconds_within_the_spread_decide_no_knee() {
        let of = |least: f64, most: f64| Spread::of(vec![least, most]);
        let knee = |full: Spread, plain: Spread, limit| {
            let trade = spread(&[
                (FULL, full, Some(0.0), 0.0),
                ("f32", plain, Some(limit), 0.0),
            ]);
            let front = trade.front().count();
            (trade.knee().unwrap().name.clone(), front)
        };
        let full = of(0.9, 1.1);
        assert_eq!(knee(full, of(0.7, 0.8), 0.01), ("f32".to_owned(), 2));
        assert_eq!(knee(full, of(0.7, 0.95), 0.01), (FULL.to_owned(), 2));
        // What changes nothing is no better for a little less time, nor worse for a little more.
        assert_eq!(knee(full, of(0.7, 0.95), 0.0), (FULL.to_owned(), 2));
        assert_eq!(knee(full, of(0.95, 1.2), 0.0), (FULL.to_owned(), 2));
        assert_eq!(knee(full, of(0.7, 0.8), 0.0), ("f32".to_owned(), 1));
    }
}
