//! What the verb `compare` and Python's function answer: one packet judged against another, within
//! all windows, by every metric, and beside the sensor that made the reference.

use std::path::Path;

use serde::{Serialize, Serializer, ser::SerializeMap as _};

use super::remade::Equivalent;
use crate::{
    compare::{
        CompareError, Comparison, Pair,
        score::{Scales, Score, scores_beside},
        window::{self, Point, Redraws},
    },
    event::{Dropped, Packet, file::Loaded},
    plane::Size,
    rig::guard::Warning,
    scene::SceneError,
    stop::Stop,
    unit::Micros,
};

/// What is known of the frames that events are at the times of.
#[derive(Clone, Copy, Debug)]
pub enum Frames {
    /// Nothing.
    Unknown,
    /// Somebody says how many there are in a second.
    Said(f64),
    /// The scene that was shown has so many in a second; whether the events are at their times is for
    /// them to say.
    Shown(f64),
}

/// What is asked.
#[derive(Clone, Copy, Debug)]
pub struct Asked {
    /// Events that are at most this far apart match; none for the window of headlines.
    pub within: Option<Micros>,
    /// The frames.
    pub frames: Frames,
    /// Bins of the voxel grids.
    pub bins: usize,
    /// Seed of the redraw and the permutation.
    pub seed: u64,
    /// Whether to give up.
    pub stop: Stop,
}

/// Why there is no answer.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum ComparisonError {
    /// The packets have nothing in common.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Compare(#[from] CompareError),
    /// A frame rate that is none.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Rate(#[from] SceneError),
    /// Nobody waits for it.
    #[error("the comparison was given up")]
    #[diagnostic(help("compare again"))]
    Stopped,
}

/// The answer.
#[derive(Serialize)]
pub struct Answer<'a> {
    /// What a comparison begins with.
    pub headline: Headline,
    /// F1 within every window.
    pub curve: Vec<Flagged>,
    /// What is counted.
    #[serde(flatten)]
    pub comparison: Comparison,
    /// Every metric.
    pub ruler: Ruler,
    /// The reference.
    pub reference: Side<'a>,
    /// What is judged against it.
    pub judged: Side<'a>,
    /// What makes these figures mean something else than they seem to.
    pub warnings: Vec<Warning>,
}

/// One of the two.
#[derive(Debug, Serialize)]
pub struct Side<'a> {
    /// What it is called: a file.
    pub file: &'a Path,
    /// The size of its sensor.
    #[serde(flatten)]
    pub size: Size,
    /// Otherwise the size is the smallest that holds the events of both.
    pub size_known: bool,
    /// How many kinds of cells there are.
    pub channels: u8,
    /// Otherwise there are as many as have events.
    pub channels_known: bool,
    /// What they are called; empty where nobody says so.
    pub names: &'a [String],
    /// When it begins and ends, in microseconds.
    pub span_us: [Micros; 2],
    /// What was lost on the way; none where nobody knows it.
    pub dropped: Option<Dropped>,
    /// Whether that is known.
    pub dropped_known: bool,
    /// Records that are no events of a pixel.
    pub skipped: u64,
}

/// What a comparison begins with.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Headline {
    /// F1 within its window.
    #[serde(flatten)]
    pub point: Point,
    /// The time from frame to frame; none where events are on no frames.
    pub frame_interval_us: Option<Micros>,
    /// Frames a second, where somebody said it or a scene was shown.
    pub fps: Option<f64>,
    /// The change of the sensor's threshold that costs as much, where the sensor is known.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub equivalent: Option<Equivalent>,
}

/// F1 within one window, and whether that is less than the time from frame to frame.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Flagged {
    /// F1.
    #[serde(flatten)]
    pub point: Point,
    /// Whether a match says which frame an event is in, and not when it is.
    pub below_frame_interval: bool,
}

/// Every metric, and what it says of the identical packet, of a redraw and of a permutation.
#[derive(Clone, Debug)]
pub struct Ruler {
    /// At which scales.
    pub scales: Scales,
    /// Metric by metric.
    pub scores: Vec<Score>,
}

/// Judges `judged` against `reference`, each with its name; both know of each other's size already.
/// `equivalent` runs the sensor that made the reference, within the window of the headline.
///
/// # Errors
/// When the two are of different sensors, the frame rate is none, or `equivalent` says no.
pub fn answer<'a, E: From<ComparisonError>>(
    [reference, judged]: [(&'a Path, &'a Loaded); 2],
    asked: Asked,
    equivalent: impl FnOnce([&Packet; 2], Micros) -> Result<Option<Equivalent>, E>,
) -> Result<Answer<'a>, E> {
    let packets = [&reference.1.packet, &judged.1.packet];
    let [one, other] = packets;
    let pair = Pair::new(one, other).map_err(ComparisonError::from)?;
    let redraws = Redraws::new(&pair, asked.seed);
    asked.go_on()?;
    let mut headline = Headline::new(&pair, &redraws, asked)?;
    let within = headline.point.window_us;
    headline.equivalent = equivalent(packets, within)?;
    let curve = headline.curve(&pair, &redraws);
    let comparison = Comparison::of_loaded(&pair, within, [reference.1, judged.1]);
    let mut scales = Scales {
        bins: asked.bins,
        seed: asked.seed,
        stop: asked.stop,
        ..Scales::default()
    };
    scales.within.push(within);
    scales.within.sort_unstable();
    scales.within.dedup();
    let scores = scores_beside(&pair, &scales, &redraws);
    asked.go_on()?;
    Ok(Answer {
        reference: Side::new(reference),
        judged: Side::new(judged),
        warnings: Warning::of_comparison(packets, within, headline.point.floor),
        headline,
        curve,
        comparison,
        ruler: Ruler { scales, scores },
    })
}

impl Asked {
    fn go_on(self) -> Result<(), ComparisonError> {
        if self.stop.is_asked() {
            return Err(ComparisonError::Stopped);
        }
        Ok(())
    }
}

impl<'a> Side<'a> {
    fn new((file, loaded): (&'a Path, &'a Loaded)) -> Self {
        let packet = &loaded.packet;
        Self {
            file,
            size: packet.size,
            size_known: loaded.size_known,
            channels: packet.channels,
            channels_known: loaded.channels_known,
            names: &packet.names,
            span_us: [packet.span.0, packet.span.1],
            dropped: loaded.dropped_known.then_some(packet.dropped),
            dropped_known: loaded.dropped_known,
            skipped: loaded.skipped,
        }
    }
}

impl Headline {
    fn new(pair: &Pair, redraws: &Redraws, asked: Asked) -> Result<Self, ComparisonError> {
        let fps = match asked.frames {
            Frames::Unknown => None,
            Frames::Said(fps) | Frames::Shown(fps) if fps > 0.0 && fps.is_finite() => Some(fps),
            Frames::Said(fps) | Frames::Shown(fps) => {
                return Err(SceneError::BadRate { fps }.into());
            }
        };
        let interval = match (asked.frames, fps) {
            (Frames::Shown(fps), _) => {
                Some(window::interval(fps)).filter(|_| window::at_frames(pair, fps))
            }
            (_, Some(fps)) => Some(window::interval(fps)),
            (_, None) => window::frame_interval(pair),
        };
        let within = { asked.within }.unwrap_or_else(|| window::headline_of(interval));
        Ok(Self {
            point: Point::new(pair, redraws, within),
            frame_interval_us: interval,
            fps,
            equivalent: None,
        })
    }

    /// The curve of a pair.
    fn curve(&self, pair: &Pair, redraws: &Redraws) -> Vec<Flagged> {
        let interval = self.frame_interval_us.unwrap_or_default();
        { window::curve(pair, redraws).into_iter() }
            .map(|point| Flagged {
                point,
                below_frame_interval: point.window_us < interval,
            })
            .collect()
    }
}

impl Serialize for Ruler {
    /// `bins`, `seed`, and by the key of each metric what it is.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("bins", &self.scales.bins)?;
        map.serialize_entry("seed", &self.scales.seed)?;
        for score in &self.scores {
            map.serialize_entry(&score.metric.key(), &Ruled::new(score))?;
        }
        map.end()
    }
}

/// One metric for machines; a value that there is not is null.
#[derive(Serialize)]
struct Ruled {
    value: Option<f64>,
    identical: Option<f64>,
    redraw: Option<f64>,
    permuted: Option<f64>,
    lost: Option<f64>,
    symmetric: bool,
    blind_to: &'static str,
}

impl Ruled {
    fn new(score: &Score) -> Self {
        Self {
            value: score.value,
            identical: score.identical,
            redraw: score.redraw,
            permuted: score.permuted,
            lost: score.lost(),
            symmetric: score.metric.entry().symmetric,
            blind_to: score.metric.entry().blind_to,
        }
    }
}
