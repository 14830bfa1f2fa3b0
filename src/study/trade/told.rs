//! What a trade says in words, and as a drawing.

use super::{FULL, Point, Trade};
use crate::{
    compare::window,
    picture::{self, Drawing, TradeDot, TradeShow},
    rig::guard::Warning,
    study::pilot::{NoLimit, Spread, change::share},
    unit::counted,
};

/// What was asked, as it is told.
pub struct Told<'a, M> {
    /// The sensor file or the program.
    pub of: &'a str,
    /// What the scene is called.
    pub scene: &'a str,
    /// Its frames a second.
    pub fps: f64,
    /// What the full model is.
    pub full: String,
    /// Whether everything was run on the whole scene, too.
    pub verify: bool,
    /// How many runs share the planning.
    pub runs: u32,
    /// The command that runs a model.
    pub command: &'a dyn Fn(&M) -> String,
}

impl<M> Told<'_, M> {
    /// What the figures stand on, in sentences.
    #[must_use]
    pub fn ground(&self, trade: &Trade<M>) -> Vec<String> {
        let mut lines = Vec::new();
        let full = { trade.points.iter() }.find(|point| point.name == FULL);
        let known = full.and_then(|full| full.sampled.or(full.whole));
        let events = known.map_or(0, |known| known.change.events);
        if let Some(tiles) = trade.tiles {
            lines.push(format!(
                "{} of {}, {} of the full model in them",
                tiles.tiles,
                counted(tiles.of, "tile"),
                counted(events, "event")
            ));
        }
        lines.push(match (&trade.no_tiles, self.verify) {
            (Some(why), _) => format!(
                "every model was run on the whole scene, since there is no sample: {why}"
            ),
            (None, true) => "run: seconds, measured on the whole scene; changes are those of the whole scene".to_owned(),
            (None, false) => "run: seconds, stretched from these tiles to the whole scene; --verify measures them".to_owned(),
        });
        if events == 0 {
            lines.push(Self::nothing(trade));
        }
        lines.push("each is the median of five parts of its frames, ± half of what the three in the middle are apart; what lies within that decides no knee".to_owned());
        if trade.tiles.is_some() {
            let shared = match self.runs {
                1 => "--runs N shares them among N runs".to_owned(),
                runs => format!("shared by {runs} runs"),
            };
            lines.push(format!(
                "plan: seconds that it took to know the error on the tiles, {shared}; sum: both, what the front is drawn by"
            ));
        }
        if let Some(warning) = Warning::window(window::headline(self.fps), trade.floor()) {
            lines.push(format!("kept says nothing here: {}", warning.seen));
        }
        if trade.without_slot > 0 {
            lines.push(format!(
                "slots of the readout are full: {} of the {} that the full model has in the whole scene {} lost, and changes are those of what is read",
                trade.without_slot,
                counted(events + trade.without_slot, "event"),
                if trade.without_slot == 1 { "is" } else { "are" }
            ));
        }
        lines
    }

    /// What is said of a full model that has no event.
    fn nothing(trade: &Trade<M>) -> String {
        let of_sample = |point: &Point<M>| point.no_limit().is_some_and(NoLimit::is_of_sample);
        let mut points = trade.points.iter();
        let so = if points.all(|point| point.no_limit().is_none()) {
            ", so nothing that is left out changes anything"
        } else {
            ""
        };
        let more = if trade.points.iter().any(of_sample) {
            "take a larger --sample, "
        } else {
            ""
        };
        format!(
            "the full model has no event{}{so}: {more}lower the thresholds, or show a scene that moves",
            if trade.tiles.is_some() { " there" } else { "" }
        )
    }

    /// Why the limit of a model that was run is not known, and what gives one.
    #[must_use]
    pub fn no_limit(point: &Point<M>) -> Option<String> {
        let why = point.no_limit()?;
        Some(if why.is_of_sample() {
            format!("{why}: take a larger --sample")
        } else {
            why.to_string()
        })
    }

    /// The models that have no place in a drawing, each reason once.
    fn unplaced(trade: &Trade<M>) -> Vec<String> {
        let mut lines: Vec<(String, Vec<&str>)> = Vec::new();
        for point in &trade.points {
            let Some(why) = Self::no_limit(point) else {
                continue;
            };
            match lines.iter_mut().find(|(known, _)| *known == why) {
                Some((_, names)) => names.push(&point.name),
                None => lines.push((why, vec![&point.name])),
            }
        }
        let told = |(why, names): (String, Vec<&str>)| {
            let names: Vec<_> = names.into_iter().map(|name| format!("`{name}`")).collect();
            format!("not drawn: {}: {why}", names.join(", "))
        };
        lines.into_iter().map(told).collect()
    }

    /// A point beside the full model, in a sentence.
    #[must_use]
    pub fn says(&self, trade: &Trade<M>, point: &Point<M>) -> String {
        let full = trade.points.iter().find(|point| point.name == FULL);
        let run = |point: &Point<M>| point.known().map(|known| known.seconds);
        let all = full.and_then(run).unwrap_or_default();
        if full.is_some_and(|full| full.name == point.name) {
            return format!("{}: {}, and nothing changes", point.name, measured(all));
        }
        let how = if point.whole.is_some() {
            "of the events change"
        } else {
            "of the events change at most"
        };
        let own = run(point).unwrap_or_default();
        format!(
            "{}: {} in place of {}, {}; {} {how}",
            point.name,
            measured(own),
            measured(all),
            as_fast(all, own),
            share(point.error().unwrap_or(0.0))
        )
    }

    /// The chart.
    #[must_use]
    pub fn drawing(&self, trade: &Trade<M>) -> Drawing {
        let title = format!(
            "{} on {}: what may be left out, and what that saves",
            self.of, self.scene
        );
        let mut captions = vec![format!("the full model is {}", self.full)];
        captions.extend(self.ground(trade));
        captions.extend(Self::unplaced(trade));
        let dots = trade.points.iter().filter_map(|point| {
            let known = point.known()?;
            let Spread {
                median,
                least,
                most,
            } = known.seconds;
            Some(TradeDot {
                name: point.name.clone(),
                run: median,
                range: [least, most],
                planning: point.planning(),
                share: if point.free.is_some() {
                    0.0
                } else {
                    known.change.share
                },
                limit: point.error()?,
                on_front: point.on_front,
                is_knee: point.is_knee,
            })
        });
        let knee: Vec<String> = match trade.knee() {
            Some(knee) => vec![
                format!("knee: {}", self.says(trade, knee)),
                (self.command)(&knee.model),
            ],
            None => Vec::new(),
        };
        picture::trade(&TradeShow {
            title: &title,
            is_whole: trade.no_tiles.is_some() || self.verify,
            captions: &captions,
            dots: dots.collect(),
            knee: &knee,
        })
    }
}

/// Less is too quick to compare.
const LEAST: f64 = 0.000_5;

/// How much faster a run is than the full one, where both take a time that can be told, and are not
/// as fast as far as was measured.
fn as_fast(full: Spread, own: Spread) -> String {
    if own.median < LEAST {
        return "too quick to compare".to_owned();
    }
    let times = full.median / own.median;
    if full.overlaps(own) {
        format!("{times:.1} times as fast, within what was measured of both")
    } else {
        format!("{times:.1} times as fast")
    }
}

/// Seconds with what they differ by.
fn measured(of: Spread) -> String {
    if of.median < LEAST {
        return seconds(of.median);
    }
    format!("{} ± {}", seconds(of.median), percent(of))
}

/// Half of what the measurements in the middle are apart, in per cent.
#[must_use]
pub fn percent(of: Spread) -> String {
    format!("{:.0} %", (100.0 * of.part()).min(999.0))
}

/// A time with two figures at least, in the unit that suits it.
#[must_use]
pub fn seconds(seconds: f64) -> String {
    let two = |number: f64| format!("{number:.*}", usize::from(number < 9.95));
    if seconds < 0.5e-7 {
        "0 s".to_owned()
    } else if seconds < 0.9995e-3 {
        format!("{} us", two(1e6 * seconds))
    } else if seconds < 0.09995 {
        format!("{} ms", two(1e3 * seconds))
    } else if seconds < 10.0 {
        format!("{seconds:.3} s")
    } else {
        format!("{seconds:.1} s")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_takes_no_time_is_not_compared() {
        let of = |least, most| Spread::of(vec![least, most]);
        let quick = of(0.000_02, 0.000_02);
        assert_eq!(as_fast(of(0.007, 0.007), quick), "too quick to compare");
        let [full, own] = [of(0.28, 0.32), of(0.1, 0.1)];
        assert_eq!(as_fast(full, own), "3.0 times as fast");
        let near = as_fast(full, of(0.2, 0.3));
        assert_eq!(near, "1.2 times as fast, within what was measured of both");
        assert_eq!(measured(full), "0.300 s ± 7 %");
        let told = [0.0, 0.000_02, 0.0072, 0.042, 12.34].map(seconds);
        assert_eq!(told, ["0 s", "20 us", "7.2 ms", "42 ms", "12.3 s"]);
    }
}
