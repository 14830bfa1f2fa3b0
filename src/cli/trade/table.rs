//! What a trade says: a table, JSON.

use std::fmt::Write as _;

use miette::IntoDiagnostic;
use serde_json::{Value, json};

use super::{Arguments, Scened};
use crate::{
    compare::window,
    study::{
        pilot::{Known, change::share},
        trade::{
            Point, Trade,
            told::{Told, percent, seconds},
        },
    },
    unit::counted,
};

/// What there is to tell.
pub struct Table<'a, M> {
    pub arguments: &'a Arguments,
    pub scened: &'a Scened,
    pub told: Told<'a, M>,
}

impl<M> Table<'_, M> {
    fn scene(&self) -> String {
        let Scened { kept, reading, .. } = self.scened;
        format!(
            "{}, {}, {}; reading it takes {} more, whatever runs",
            self.arguments.given.scene,
            kept.size(),
            counted(kept.len(), "frame"),
            seconds(*reading)
        )
    }

    pub fn text(&self, trade: &Trade<M>) -> String {
        let mut text = format!(
            "scene    {}\nof       {}; the full model is {}\n",
            self.scene(),
            self.told.of,
            self.told.full
        );
        for line in self.told.ground(trade) {
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
            "  {:<width$} {:>10} {:>10}{verified} {:>7} {:>7} {:>9} {:>5} {:>9} {:>9}  front",
            "model", "about", "at most", "F1", "kept", "run", "±", "plan", "sum"
        );
        for point in &trade.points {
            text += &Self::row(point, width, !verified.is_empty());
        }
        text += "\n";
        if let Some(knee) = trade.knee() {
            let _ = writeln!(text, "knee     {}", self.told.says(trade, knee));
            let _ = writeln!(text, "         {}", (self.told.command)(&knee.model));
        }
        if let Some(why) = trade.no_knee() {
            let _ = writeln!(text, "no knee: {why}");
        }
        for point in trade.front().filter(|point| !point.is_knee) {
            let _ = writeln!(text, "front    {}", self.told.says(trade, point));
            let _ = writeln!(text, "         {}", (self.told.command)(&point.model));
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
            (None, None) => Told::no_limit(point).unwrap_or_default(),
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
            "{mark} {:<width$} {about:>10} {limit:>10}{measured} {:>7} {:>7} {:>9} {:>5} {:>9} {:>9}  {front}\n",
            point.name,
            number(|known| Some(known.f1)),
            number(|known| known.kept),
            time(known.map(|known| known.seconds.median)),
            known.map_or("-".to_owned(), |known| percent(known.seconds)),
            time(known.map(|_| point.planning())),
            time(point.seconds()),
        )
    }

    pub fn json(&self, trade: &Trade<M>) -> miette::Result<Value> {
        let points = trade.points.iter().map(|point| {
            let mut json = serde_json::to_value(point).into_diagnostic()?;
            json["error"] = json!(point.error());
            json["no_limit"] = json!(point.no_limit());
            let seconds = point.known().map(|known| known.seconds);
            json["seconds"] = json!(seconds.map(|seconds| seconds.median));
            json["seconds_range"] = json!(seconds.map(|seconds| [seconds.least, seconds.most]));
            json["planning_seconds"] = json!(point.planning());
            json["command"] = (self.told.command)(&point.model).into();
            Ok(json)
        });
        let points = points.collect::<miette::Result<Vec<Value>>>()?;
        let knee = trade.knee();
        Ok(json!({
            "scene": *self.arguments.given.scene,
            "of": self.told.of,
            "full": self.told.full,
            "frames": self.scened.kept.len(),
            "within_us": self.arguments.within.0,
            "f1_within_us": self.arguments.within.0,
            "kept_within_us": window::headline(self.told.fps).0,
            "reading_seconds": self.scened.reading,
            "runs": self.arguments.runs,
            "times": if trade.no_tiles.is_some() || self.arguments.verify { "whole" } else { "tiles" },
            "tiles": trade.tiles,
            "no_tiles": trade.no_tiles,
            "without_slot": trade.without_slot,
            "points": points,
            "knee": knee.map(|knee| &knee.name),
            "no_knee": trade.no_knee(),
            "command": knee.map(|knee| (self.told.command)(&knee.model)),
        }))
    }
}
