//! The headline of a comparison: what is kept, within which window, and the curve of all windows.

use std::{fmt::Write as _, path::Path};

use serde::Serialize;

use super::Arguments;
use crate::{
    compare::{
        Pair,
        metric::Short,
        window::{self, Point, Redraws},
    },
    event::Packet,
    picture::{CurvePoint, CurveShow, Drawing, curve},
    rig::guard::Warning,
    scene::SceneError,
    study::{equivalent, remade::Equivalent},
    unit::{Micros, frame_rate, signed},
};

/// What a comparison begins with.
#[derive(Serialize)]
pub(super) struct Headline {
    #[serde(flatten)]
    point: Point,
    /// None where events are on no frames.
    frame_interval_us: Option<Micros>,
    /// Where it was said, or a scene was shown.
    fps: Option<f64>,
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    equivalent: Option<Equivalent>,
}

/// F1 within one window, and whether that is less than the time from frame to frame.
#[derive(Serialize)]
pub(super) struct Flagged {
    #[serde(flatten)]
    point: Point,
    below_frame_interval: bool,
}

impl Headline {
    /// Of a pair that shows frames at a rate, where that is known.
    ///
    /// # Errors
    /// When the rate is none.
    pub(super) fn new(
        arguments: &Arguments,
        pair: &Pair,
        redraws: &Redraws,
        fps: Option<f64>,
    ) -> Result<Self, SceneError> {
        let told = || window::frame_interval(pair);
        let interval = match fps {
            // The scene has frames; whether the events are at their times is for them to say.
            Some(fps) if fps > 0.0 && fps.is_finite() => Some(window::interval(fps))
                .filter(|_| arguments.sensor.is_none() || window::at_frames(pair, fps)),
            Some(fps) => return Err(SceneError::BadRate { fps }),
            None => told(),
        };
        let asked = arguments.window.within;
        let within = asked.unwrap_or_else(|| window::headline_of(interval));
        Ok(Self {
            point: Point::new(pair, redraws, within),
            frame_interval_us: interval,
            fps,
            equivalent: None,
        })
    }

    /// With the threshold equivalent.
    pub(super) const fn with(self, equivalent: Equivalent) -> Self {
        Self {
            equivalent: Some(equivalent),
            ..self
        }
    }

    /// The window.
    pub(super) const fn window(&self) -> Micros {
        self.point.window_us
    }

    /// What there is to warn of: the recordings, their names, and chance that scores as much as
    /// anything.
    pub(super) fn warnings(&self, packets: [&Packet; 2]) -> Vec<Warning> {
        let Point {
            window_us, floor, ..
        } = self.point;
        Warning::of_comparison(packets, window_us, floor)
    }

    /// The curve of a pair.
    pub(super) fn curve(&self, pair: &Pair, redraws: &Redraws) -> Vec<Flagged> {
        let interval = self.frame_interval_us.unwrap_or_default();
        { window::curve(pair, redraws).into_iter() }
            .map(|point| Flagged {
                point,
                below_frame_interval: point.window_us < interval,
            })
            .collect()
    }

    /// A line for people.
    pub(super) fn line(&self) -> String {
        let Point {
            window_us,
            f1,
            floor,
            kept,
        } = self.point;
        let mut text = format!(
            "kept {} within {}: F1 {f1:.4}, by chance {floor:.4}",
            equivalent::kept(kept, 4),
            Short(window_us)
        );
        let _ = match (self.fps, self.frame_interval_us) {
            (Some(fps), Some(_)) => write!(text, "; {} frames/s", frame_rate(fps)),
            (None, Some(interval)) => write!(
                text,
                "; frame rate not said: by the events' times a frame every {} or a whole part of it (--fps says it)",
                Short(interval)
            ),
            (_, None) => write!(text, "; the events' times are on no frames"),
        };
        if let Some(equivalent) = self.equivalent.filter(|it| it.percent.is_some()) {
            let percents = equivalent::percents(equivalent.percent, equivalent.is_least);
            let _ = write!(text, "; as a threshold {percents} higher");
        }
        text + "\n"
    }

    /// Gain and shape apart, where the sensor is known.
    pub(super) fn tuned(&self) -> String {
        let tuned = self.equivalent.and_then(|equivalent| equivalent.tuned);
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
    pub(super) fn drawing(&self, arguments: &Arguments, curve_of: &[Flagged]) -> Drawing {
        let shown = |point: &Point| CurvePoint {
            window: point.window_us,
            score: point.f1,
            floor: point.floor,
        };
        let points: Vec<_> = curve_of
            .iter()
            .map(|flagged| shown(&flagged.point))
            .collect();
        let name = |path: &Path| match path.file_name() {
            Some(name) => name.to_string_lossy().into_owned(),
            None => path.display().to_string(),
        };
        let line = self.line();
        let (first, rest) = line.trim_end().split_once("; ").unwrap_or((&line, ""));
        curve(&CurveShow {
            title: &format!("{} against {}", name(&arguments.b), name(&arguments.a)),
            captions: &[first.to_owned(), rest.to_owned()],
            score: "F1",
            points: &points,
            headline: shown(&self.point),
            frame_interval: self.frame_interval_us,
        })
    }
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
