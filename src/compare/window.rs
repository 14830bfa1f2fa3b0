//! F1 over the window of its matches, and what of it is more than chance.
//!
//! Which events match depends on the window, and so does what matches by chance. So F1 is told
//! for windows from 1 us to 1 s, with its **floor**: that of redraws of the reference, which have
//! the right places and rates and times by chance ([`baseline`]). The **ceiling** is 1, that of
//! the reference itself. What lies between is *kept*:
//!
//! ```text
//! kept = (F1 - floor) / (1 - floor)
//! ```
//!
//! 1 is a perfect packet, 0 one that knows the rates and nothing else; below 0 it knows less.
//!
//! Sensors that see frames say *in which frame*, and a window below the time from frame to frame
//! asks for the same frame: the more frames the same light is shown in, the less is matched. A
//! window of at least the frame interval does not: `docs/ruler.md` has the table.

use std::{
    collections::HashMap,
    sync::{Arc, Mutex, PoisonError},
};

use serde::Serialize;

use super::{
    Pair, baseline,
    entry::{Entry, Scale},
    matching,
};
use crate::unit::Micros;

/// What of F1 is more than chance, within a window.
pub static KEPT: Entry = Entry {
    key: "kept",
    title: "kept within",
    scale: Scale::Window,
    study: Some((
        "kept",
        "the part of F1 above chance, for each window: 1 at most, 0 for a redraw",
    )),
    blind_to: "",
    knows_a_redraw: true,
    symmetric: false,
    value: |of, within| {
        let [a, b] = of.pair.events();
        let f1 = matching::share(2 * of.matched(within), a + b);
        kept(f1, of.redraws.floor(within))
    },
};

/// Windows of the curve: 1, 2 and 5 of each decade from 1 us to 1 s.
pub const WINDOWS: [Micros; 19] = {
    let mut all = [Micros(0); 19];
    let (mut i, mut decade) = (0, 1);
    while i < all.len() {
        all[i] = Micros(decade * [1, 2, 5][i % 3]);
        if i % 3 == 2 {
            decade *= 10;
        }
        i += 1;
    }
    all
};

/// The window of headlines, unless frames are further apart: the frame interval of a clip of 10
/// frames a second.
pub const HEADLINE: Micros = Micros(100_000);

/// The window of a headline at this many frames a second: [`HEADLINE`], or the time from frame
/// to frame where that is longer.
#[must_use]
pub fn headline(fps: f64) -> Micros {
    headline_of(Some(interval(fps)))
}

/// The same where the time from frame to frame is known, or there are no frames.
#[must_use]
pub fn headline_of(interval: Option<Micros>) -> Micros {
    HEADLINE.max(interval.unwrap_or_default())
}

/// The time from frame to frame, rounded up.
#[must_use]
pub fn interval(fps: f64) -> Micros {
    // `as` saturates, which is what is meant.
    Micros((1e6 / fps).ceil() as u64)
}

/// Up to which floor of F1 a scene can judge: where chance alone scores more, a few events decide
/// what is left above it.
pub const CLEAR_FLOOR: f64 = 0.9;

/// Whether a scene with this floor of F1 can judge.
#[must_use]
pub fn can_judge(floor: f64) -> bool {
    floor <= CLEAR_FLOOR
}

/// What of a score is more than chance; the score is at most 1.
///
/// Where chance scores 1, a packet that scores 1 keeps all; of any other nothing can be said.
#[must_use]
pub fn kept(score: f64, floor: f64) -> Option<f64> {
    if floor < 1.0 {
        Some((score - floor) / (1.0 - floor))
    } else {
        (score >= 1.0).then_some(1.0)
    }
}

/// F1 within one window.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Point {
    /// The window, in microseconds.
    pub window_us: Micros,
    /// F1.
    pub f1: f64,
    /// F1 of a redraw of the reference, the mean of some.
    pub floor: f64,
    /// `(f1 - floor) / (1 - floor)`.
    pub kept: Option<f64>,
}

/// Redraws of a reference, as often as 200 000 events allow, at most 16 times: the floor of all
/// that is judged against it.
#[derive(Clone, Debug)]
pub struct Redraws {
    draws: Vec<Pair>,
    /// Floors that were asked for.
    floors: Arc<Mutex<HashMap<Micros, f64>>>,
}

impl Redraws {
    /// Of the reference of a pair.
    #[must_use]
    pub fn new(pair: &Pair, seed: u64) -> Self {
        let draw = |k| baseline::redraw(pair, seed.wrapping_add(k));
        Self {
            draws: (0..Self::number(pair)).map(draw).collect(),
            floors: Arc::default(),
        }
    }

    /// How often a reference is drawn anew.
    #[must_use]
    pub fn number(pair: &Pair) -> u64 {
        (200_000 / pair.events()[0].max(1)).clamp(1, 16)
    }

    /// F1 of a redraw within a window.
    #[must_use]
    pub fn floor(&self, within: Micros) -> f64 {
        let floors = || self.floors.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(floor) = floors().get(&within) {
            return *floor;
        }
        let sum: f64 = self.draws.iter().map(|draw| f1(draw, within)).sum();
        let floor = sum / self.draws.len() as f64;
        floors().insert(within, floor);
        floor
    }

    /// The reference, and a redraw in place of the judged packet, for each of them.
    pub(super) fn pairs(&self) -> &[Pair] {
        &self.draws
    }
}

impl Point {
    /// Of a pair within a window.
    #[must_use]
    pub fn new(pair: &Pair, redraws: &Redraws, within: Micros) -> Self {
        Self::above(f1(pair, within), redraws.floor(within), within)
    }

    /// Of a score and its floor.
    #[must_use]
    pub fn above(f1: f64, floor: f64, within: Micros) -> Self {
        Self {
            window_us: within,
            f1,
            floor,
            kept: kept(f1, floor),
        }
    }
}

/// F1 of a pair within each of the [`WINDOWS`].
#[must_use]
pub fn curve(pair: &Pair, redraws: &Redraws) -> Vec<Point> {
    let point = |within: &Micros| Point::new(pair, redraws, *within);
    WINDOWS.iter().map(point).collect()
}

/// F1 of a pair within a window.
#[must_use]
pub fn f1(pair: &Pair, within: Micros) -> f64 {
    let [a, b] = pair.events();
    matching::share(2 * matching::matched(pair, within), a + b)
}

/// The time from frame to frame by the times of the events: the longest of which the distances of
/// all of them from the first are whole multiples, to the rounding of a microsecond. Frames are
/// that far apart or a whole part of it, where events skip the same frames. None where times are
/// not those of frames. Of two packets with frames, the longer interval.
#[must_use]
pub fn frame_interval(pair: &Pair) -> Option<Micros> {
    pair.times()
        .into_iter()
        .filter_map(|times| grid(&times))
        .max()
}

/// Whether all events of either packet are at times of frames, so many a second.
#[must_use]
pub fn at_frames(pair: &Pair, fps: f64) -> bool {
    let interval = 1e6 / fps;
    pair.times().into_iter().any(|times| {
        times.iter().all(|t| {
            let far = (t - times[0]) as f64;
            // Both times are rounded to a microsecond.
            (far - (far / interval).round() * interval).abs() <= 1.5
        }) && !times.is_empty()
    })
}

/// Times closer than this are not those of frames.
const LEAST_INTERVAL_US: u64 = 10;

/// The longest interval of which all of these times, which ascend, are whole multiples from the
/// first on, to the rounding of a microsecond.
fn grid(times: &[u64]) -> Option<Micros> {
    let first = *times.first()?;
    let gaps = || times.windows(2).map(|two| two[1] - two[0]);
    let shortest = gaps().min().filter(|gap| *gap >= LEAST_INTERVAL_US)?;
    let parts = parts(shortest, gaps());
    // A time is rounded to a microsecond, so an interval that is known from `known` frames is
    // off by up to 1/known; every further time tells it more precisely.
    let (mut interval, mut known) = (shortest as f64 / parts, parts);
    for t in times {
        let far = (t - first) as f64;
        let frames = (far / interval).round();
        let rounding = 1.0 + frames / known;
        if (far - frames * interval).abs() > rounding || rounding > interval / 4.0 {
            return None;
        }
        if frames > known {
            (interval, known) = (far / frames, frames);
        }
    }
    Some(Micros(interval.round() as u64))
}

/// Parts of the shortest gap, at most.
const MOST_PARTS: f64 = 16.0;

/// Of how many intervals the shortest gap is, where events skip frames: by Euclid's algorithm on
/// gaps that are not much longer, whose rounding is far below a part.
fn parts(shortest: u64, gaps: impl Iterator<Item = u64>) -> f64 {
    let shortest = shortest as f64;
    let mut interval = shortest;
    for gap in gaps.map(|gap| gap as f64) {
        if gap > MOST_PARTS * shortest {
            continue;
        }
        let mut whole = gap;
        while interval >= shortest / (MOST_PARTS + 0.5) {
            let rest = (whole - (whole / interval).round() * interval).abs();
            if rest < shortest / (2.0 * MOST_PARTS) {
                break;
            }
            (whole, interval) = (interval, rest);
        }
        let parts = (shortest / interval).round();
        if parts > MOST_PARTS {
            return 1.0;
        }
        interval = shortest / parts;
    }
    (shortest / interval).round()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_are_one_two_and_five_of_each_decade() {
        assert_eq!(WINDOWS[0], Micros(1));
        assert_eq!(WINDOWS[4], Micros(20));
        assert_eq!(WINDOWS[18], Micros(1_000_000));
        assert!(WINDOWS.contains(&HEADLINE));
    }

    #[test]
    fn what_is_kept_lies_between_chance_and_all() {
        assert_eq!(kept(1.0, 0.4), Some(1.0));
        assert_eq!(kept(0.4, 0.4), Some(0.0));
        assert!((kept(0.7, 0.4).unwrap() - 0.5).abs() < 1e-12);
        assert!(kept(0.1, 0.4).unwrap() < 0.0);
        assert_eq!([kept(1.0, 1.0), kept(0.9, 1.0)], [Some(1.0), None]);
    }

    #[test]
    fn frames_are_told_from_times_that_are_not_on_any() {
        let frames = |fps: f64, n: u32| -> Vec<u64> {
            { 0..n }
                .map(|i| Micros::from_seconds(f64::from(i) / fps).0)
                .collect()
        };
        for fps in [7.0, 10.0, 30.0, 1000.0 / 3.0, 9999.0] {
            let all = frames(fps, 500);
            let told = grid(&all).unwrap_or_else(|| panic!("{fps} frames/s"));
            assert!(told.0.abs_diff((1e6 / fps).round() as u64) <= 1, "{fps}");
            // Frames in which nothing happened are no other interval.
            let some: Vec<u64> = all
                .iter()
                .enumerate()
                .filter(|(i, _)| i % 7 != 3)
                .map(|(_, t)| *t)
                .collect();
            assert_eq!(grid(&some), Some(told), "{fps}");
            // No two events are in neighbouring frames.
            if fps < 1000.0 {
                let skip = [2, 5, 7, 10, 12, 15, 21, 24, 100, 400].map(|i| all[i]);
                assert_eq!(grid(&skip), Some(told), "{fps}");
            }
        }
        assert_eq!(grid(&[0, 100_000, 150_301, 233_333]), None);
        assert_eq!(grid(&[0, 40_000, 80_000, 200_000]), Some(Micros(40_000)));
        assert_eq!(grid(&[0, 1, 2, 3]), None);
        assert_eq!(grid(&[5]), None);
        assert_eq!(headline(30.0), HEADLINE);
        assert_eq!(headline(4.0), Micros(250_000));
    }
}
