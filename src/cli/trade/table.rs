//! What a trade says: a table, JSON, a drawing.

use std::fmt::Write as _;

use miette::IntoDiagnostic;
use serde_json::{Value, json};

use super::{super::fidelity::share, Arguments, Scened};
use crate::{
    compare::window,
    picture::{self, Drawing, TradeDot, TradeShow},
    rig::guard::Warning,
    scene::Scene as _,
    study::{
        pilot::Known,
        trade::{FULL, Point, Trade},
    },
    unit::counted,
};

/// What there is to tell.
pub struct Told<'a, M> {
    pub arguments: &'a Arguments,
    /// The sensor file or the program.
    pub of: &'a str,
    /// What the full model is.
    pub full: String,
    pub scened: &'a Scened,
    /// The command that runs a model.
    pub command: &'a dyn Fn(&M) -> String,
}

impl<M> Told<'_, M> {
    /// What the figures stand on, in sentences.
    fn ground(&self, trade: &Trade<M>) -> Vec<String> {
        let mut lines = Vec::new();
        if let Some(tiles) = trade.tiles {
            let events = trade.points.iter().find_map(|point| point.sampled);
            let events = events.map_or(0, |known| known.change.events);
            lines.push(format!(
                "{} of {}, {} of the full model in them",
                tiles.tiles,
                counted(tiles.of, "tile"),
                counted(events, "event")
            ));
        }
        lines.push(match (&trade.no_tiles, self.arguments.verify) {
            (Some(why), _) => format!(
                "every model was run on the whole scene, since there is no sample: {why}"
            ),
            (None, true) => "run: seconds, measured on the whole scene; changes are those of the whole scene".to_owned(),
            (None, false) => "run: seconds, stretched from these tiles to the whole scene; --verify measures them".to_owned(),
        });
        if trade.tiles.is_some() {
            let shared = match self.arguments.runs {
                1 => "--runs N shares them among N runs".to_owned(),
                runs => format!("shared by {runs} runs"),
            };
            lines.push(format!(
                "plan: seconds that it took to know the error on the tiles, {shared}; sum: both, what the front is drawn by"
            ));
        }
        let headline = window::headline(self.scened.kept.scene().fps());
        if let Some(warning) = Warning::window(headline, trade.floor()) {
            lines.push(format!("kept says nothing here: {}", warning.seen));
        }
        if trade.without_slot > 0 {
            let more = if trade.no_tiles.is_none() && !self.arguments.verify {
                "; --verify counts what that changes"
            } else {
                ""
            };
            lines.push(format!(
                "{} found no slot of the readout: which ones depends on the whole array{more}",
                counted(trade.without_slot, "event")
            ));
        }
        lines
    }

    fn scene(&self) -> String {
        let Scened { kept, reading, .. } = self.scened;
        format!(
            "{}, {}, {}; reading it takes {} more, whatever runs",
            self.arguments.scene,
            kept.size(),
            counted(kept.len(), "frame"),
            seconds(*reading)
        )
    }

    pub fn text(&self, trade: &Trade<M>) -> String {
        let mut text = format!(
            "scene    {}\nof       {}; the full model is {}\n",
            self.scene(),
            self.of,
            self.full
        );
        for line in self.ground(trade) {
            let _ = writeln!(text, "         {line}");
        }
        text += "\n";
        let width = { trade.points.iter() }
            .map(|point| point.name.chars().count())
            .max()
            .unwrap_or(0);
        let verified = if trade.tiles.is_some() && self.arguments.verify {
            "   changed"
        } else {
            ""
        };
        let _ = writeln!(
            text,
            "  {:<width$} {:>10} {:>10}{verified} {:>7} {:>7} {:>9} {:>9} {:>9}  front",
            "model", "about", "at most", "F1", "kept", "run", "plan", "sum"
        );
        for point in &trade.points {
            text += &Self::row(point, width, !verified.is_empty());
        }
        text += "\n";
        if let Some(knee) = trade.knee() {
            let _ = writeln!(text, "knee     {}", Self::says(trade, knee));
            let _ = writeln!(text, "         {}", (self.command)(&knee.model));
        }
        for point in trade.front().filter(|point| !point.is_knee) {
            let _ = writeln!(text, "front    {}", Self::says(trade, point));
            let _ = writeln!(text, "         {}", (self.command)(&point.model));
        }
        if let Some(path) = &self.arguments.output {
            let _ = writeln!(text, "wrote    {}", path.display());
        }
        text
    }

    fn row(point: &Point<M>, width: usize, verified: bool) -> String {
        let mark = match point {
            point if point.is_knee => '*',
            point if point.on_front => '+',
            _ => ' ',
        };
        let front = match (&point.why, &point.beaten_by) {
            (Some(why), _) => why.clone(),
            (None, Some(by)) => format!("no, {by} is better"),
            (None, None) if point.is_knee => "yes, the knee".to_owned(),
            (None, None) if point.on_front => "yes".to_owned(),
            (None, None) => "too few events to say anything: take a larger --sample".to_owned(),
        };
        let front = match point.free {
            Some(why) => format!("{front}; free: {why}"),
            None => front,
        };
        let told = |of: Option<f64>| of.map_or("-".to_owned(), share);
        let (sampled, known) = (point.sampled.or(point.whole), point.known());
        let about = told(sampled.map(|known| known.change.share));
        let limit = match point.free {
            Some(_) => "free".to_owned(),
            None => told(sampled.and_then(|known| known.change.limit)),
        };
        let measured = if verified {
            format!("{:>10}", told(point.whole.map(|known| known.change.share)))
        } else {
            String::new()
        };
        let number = |of: fn(&Known) -> Option<f64>| {
            let number = known.and_then(|known| of(&known));
            number.map_or("-".to_owned(), |number| format!("{number:.3}"))
        };
        let time = |of: Option<f64>| of.map_or("-".to_owned(), seconds);
        format!(
            "{mark} {:<width$} {about:>10} {limit:>10}{measured} {:>7} {:>7} {:>9} {:>9} {:>9}  {front}\n",
            point.name,
            number(|known| Some(known.f1)),
            number(|known| known.kept),
            time(known.map(|known| known.seconds)),
            time(known.map(|_| point.planning())),
            time(point.seconds()),
        )
    }

    /// A point beside the full model, in a sentence.
    fn says(trade: &Trade<M>, point: &Point<M>) -> String {
        let full = trade.points.iter().find(|point| point.name == FULL);
        let run = |point: &Point<M>| point.known().map_or(0.0, |known| known.seconds);
        let all = full.map_or(0.0, run);
        if full.is_some_and(|full| full.name == point.name) {
            return format!("{}: {}, and nothing changes", point.name, seconds(all));
        }
        let how = if point.whole.is_some() {
            "of the events change"
        } else {
            "of the events change at most"
        };
        format!(
            "{}: {} in place of {}, {}; {} {how}",
            point.name,
            seconds(run(point)),
            seconds(all),
            as_fast(all, run(point)),
            share(point.error().unwrap_or(0.0))
        )
    }

    pub fn json(&self, trade: &Trade<M>) -> miette::Result<Value> {
        let points = trade.points.iter().map(|point| {
            let mut json = serde_json::to_value(point).into_diagnostic()?;
            json["error"] = json!(point.error());
            json["seconds"] = json!(point.known().map(|known| known.seconds));
            json["planning_seconds"] = json!(point.planning());
            json["command"] = (self.command)(&point.model).into();
            Ok(json)
        });
        let points = points.collect::<miette::Result<Vec<Value>>>()?;
        let knee = trade.knee();
        Ok(json!({
            "scene": *self.arguments.scene,
            "of": self.of,
            "full": self.full,
            "frames": self.scened.kept.len(),
            "within_us": self.arguments.within.0,
            "reading_seconds": self.scened.reading,
            "runs": self.arguments.runs,
            "times": if trade.no_tiles.is_some() || self.arguments.verify { "whole" } else { "tiles" },
            "tiles": trade.tiles,
            "no_tiles": trade.no_tiles,
            "without_slot": trade.without_slot,
            "points": points,
            "knee": knee.map(|knee| &knee.name),
            "command": knee.map(|knee| (self.command)(&knee.model)),
        }))
    }

    pub fn drawing(&self, trade: &Trade<M>) -> Drawing {
        let title = format!(
            "{} on {}: what may be left out, and what that saves",
            self.of, self.arguments.scene
        );
        let mut captions = vec![format!("the full model is {}", self.full)];
        captions.extend(self.ground(trade));
        let dots = trade.points.iter().filter_map(|point| {
            let known = point.known()?;
            Some(TradeDot {
                name: point.name.clone(),
                run: known.seconds,
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
                format!("knee: {}", Self::says(trade, knee)),
                (self.command)(&knee.model),
            ],
            None => Vec::new(),
        };
        picture::trade(&TradeShow {
            title: &title,
            is_whole: trade.no_tiles.is_some() || self.arguments.verify,
            captions: &captions,
            dots: dots.collect(),
            knee: &knee,
        })
    }
}

/// Less is told as no time at all.
const LEAST: f64 = 0.000_5;

/// How much faster a run is than the full one, where both take a time that can be told.
fn as_fast(full: f64, own: f64) -> String {
    if own < LEAST {
        return "too quick to compare".to_owned();
    }
    format!("{:.1} times as fast", full / own)
}

/// Seconds with three figures or so.
fn seconds(seconds: f64) -> String {
    if seconds < LEAST {
        "0 s".to_owned()
    } else if seconds < 10.0 {
        format!("{seconds:.3} s")
    } else {
        format!("{seconds:.1} s")
    }
}

#[cfg(test)]
mod tests {
    use super::as_fast;

    #[test]
    fn what_takes_no_time_is_not_compared() {
        assert_eq!(as_fast(0.007, 0.000_02), "too quick to compare");
        assert_eq!(as_fast(0.3, 0.1), "3.0 times as fast");
    }
}
