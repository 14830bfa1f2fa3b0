//! What a trade says, as a table.

use std::fmt::Write as _;

use super::Arguments;
use crate::{
    study::{
        pilot::{Known, change::share},
        trade::{
            Point,
            answer::{Answer, Held},
            told::{Told, percent, seconds},
        },
    },
    unit::counted,
};

/// All of it.
pub fn text<M>(arguments: &Arguments, answer: &Answer<'_, M>, held: &Held) -> String {
    let (told, trade) = (&answer.told, &answer.trade);
    let mut text = format!(
        "scene    {}, {}, {}; reading it takes {} more, whatever runs\nof       {}; the full model is {}\n",
        told.scene,
        held.kept.size(),
        counted(held.kept.len(), "frame"),
        seconds(held.seconds),
        told.of,
        told.full
    );
    for line in told.ground(trade) {
        let _ = writeln!(text, "         {line}");
    }
    text += "\n";
    let width = { trade.points.iter() }
        .map(|point| point.name.chars().count())
        .max()
        .unwrap_or(0);
    let verified = if trade.tiles.is_some() && told.verify {
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
        text += &row(point, width, !verified.is_empty());
    }
    text += "\n";
    if let Some(knee) = trade.knee() {
        let _ = writeln!(text, "knee     {}", told.says(trade, knee));
        let _ = writeln!(text, "         {}", (told.command)(&knee.model));
    }
    if let Some(why) = trade.no_knee() {
        let _ = writeln!(text, "no knee: {why}");
    }
    for point in trade.front().filter(|point| !point.is_knee) {
        let _ = writeln!(text, "front    {}", told.says(trade, point));
        let _ = writeln!(text, "         {}", (told.command)(&point.model));
    }
    if let Some(path) = &arguments.output {
        let _ = writeln!(text, "wrote    {}", path.display());
    }
    text
}

fn row<M>(point: &Point<M>, width: usize, verified: bool) -> String {
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
