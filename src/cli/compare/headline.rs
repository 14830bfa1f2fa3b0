//! The headline of a comparison: what is kept, within which window, and the curve of all windows.

use std::{fmt::Write as _, path::Path};

use super::Arguments;
use crate::{
    compare::{metric::Short, window::Point},
    picture::{CurvePoint, CurveShow, Drawing, curve},
    study::{
        comparison::{Answer, Flagged, Headline},
        equivalent,
    },
    unit::{frame_rate, signed},
};

/// A line for people.
pub(super) fn line(headline: &Headline) -> String {
    let Point {
        window_us,
        f1,
        floor,
        kept,
    } = headline.point;
    let mut text = format!(
        "kept {} within {}: F1 {f1:.4}, by chance {floor:.4}",
        equivalent::kept(kept, 4),
        Short(window_us)
    );
    let _ = match (headline.fps, headline.frame_interval_us) {
        (Some(fps), Some(_)) => write!(text, "; {} frames/s", frame_rate(fps)),
        (None, Some(interval)) => write!(
            text,
            "; frame rate not said: by the events' times a frame every {} or a whole part of it (--fps says it)",
            Short(interval)
        ),
        (_, None) => write!(text, "; the events' times are on no frames"),
    };
    if let Some(equivalent) = headline.equivalent.filter(|it| it.percent.is_some()) {
        let percents = equivalent::percents(equivalent.percent, equivalent.is_least);
        let _ = write!(text, "; as a threshold {percents} higher");
    }
    text + "\n"
}

/// Gain and shape apart, where the sensor is known.
pub(super) fn tuned(headline: &Headline) -> String {
    let tuned = headline.equivalent.and_then(|equivalent| equivalent.tuned);
    tuned.map_or_else(String::new, |tuned| {
        let told = match tuned.kept {
            Some(kept) => {
                format!(
                    "kept {kept:.4}, as a threshold {} higher",
                    tuned.equivalent()
                )
            }
            None => "kept -, since chance alone scores 1".to_owned(),
        };
        format!(
            "against the sensor of as many events, its threshold {} %: {told}\n",
            signed(tuned.threshold_percent, 1)
        )
    })
}

/// The curve as a drawing.
pub(super) fn drawing(answer: &Answer<'_>, arguments: &Arguments) -> Drawing {
    let shown = |point: &Point| CurvePoint {
        window: point.window_us,
        score: point.f1,
        floor: point.floor,
    };
    let points: Vec<_> = answer
        .curve
        .iter()
        .map(|flagged| shown(&flagged.point))
        .collect();
    let name = |path: &Path| match path.file_name() {
        Some(name) => name.to_string_lossy().into_owned(),
        None => path.display().to_string(),
    };
    let headline = &answer.headline;
    let line = line(headline);
    let (first, rest) = line.trim_end().split_once("; ").unwrap_or((&line, ""));
    curve(&CurveShow {
        title: &format!("{} against {}", name(&arguments.b), name(&arguments.a)),
        captions: &[first.to_owned(), rest.to_owned()],
        score: "F1",
        points: &points,
        headline: shown(&headline.point),
        frame_interval: headline.frame_interval_us,
    })
}

/// The curve in a few columns: a window of each decade.
pub(super) fn table(curve: &[Flagged]) -> String {
    let decades: Vec<_> = curve.iter().step_by(3).collect();
    let mut text = format!("\n{:<8}", "window");
    for flagged in &decades {
        let mark = if flagged.below_frame_interval {
            "*"
        } else {
            ""
        };
        let window = format!("{}{mark}", Short(flagged.point.window_us));
        let _ = write!(text, "{window:>9}");
    }
    for (row, name) in ["F1", "floor", "kept"].iter().enumerate() {
        let _ = write!(text, "\n{name:<8}");
        for Flagged { point, .. } in &decades {
            let values = [Some(point.f1), Some(point.floor), point.kept];
            let _ = write!(text, "{:>9}", equivalent::kept(values[row], 4));
        }
    }
    if decades.iter().any(|flagged| flagged.below_frame_interval) {
        text += "\n* below the time from frame to frame: says which frame, not when";
    }
    text + "\n\n"
}
