//! A score over the window of its matches, between what chance scores and what the reference
//! itself does.

use super::{
    chart::{
        Anchor, Area, Drawing, Point,
        axes::{Axis, Scale, axes},
    },
    ink::{self, Ink},
    text::{LINE, Weight},
};
use crate::{elementary, unit::Micros};

/// What a curve is shown by.
#[derive(Clone, Debug)]
pub struct CurveShow<'a> {
    /// The line on top.
    pub title: &'a str,
    /// Lines below it.
    pub captions: &'a [String],
    /// The score in the legend, such as `F1`.
    pub score: &'a str,
    /// In order of their windows.
    pub points: &'a [CurvePoint],
    /// The window of the headline.
    pub headline: CurvePoint,
    /// The time from frame to frame, where there are frames: windows below it ask for the frame.
    pub frame_interval: Option<Micros>,
}

/// A score within one window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvePoint {
    /// The window, above 0.
    pub window: Micros,
    /// The score, 1 at most.
    pub score: f64,
    /// What chance scores.
    pub floor: f64,
}

const MARGIN: f64 = 24.0;
const PLOT: f64 = 640.0;
const HEIGHT: f64 = 320.0;
/// Room for the numbers at the left.
const LEFT: f64 = 64.0;
const SWATCH: f64 = 14.0;
const LETTER: f64 = 9.0;

/// Shades windows below the time from frame to frame.
const SHADE: Ink = ink::EMPTY;
const SCORE: Ink = ink::ON;
const FLOOR: Ink = ink::BARS;
const CEILING: Ink = ink::MATCHED;
const KEPT: Ink = ink::EXTRA;

/// The score, its floor and its ceiling over the logarithm of the window.
#[must_use]
pub fn curve(show: &CurveShow<'_>) -> Drawing {
    let line = f64::from(LINE);
    let legend = Legend::new(show);
    let top = MARGIN + (show.captions.len() + legend.rows() + 2) as f64 * line + 12.0;
    let area = Area {
        x: LEFT,
        y: top,
        width: PLOT,
        height: HEIGHT,
    };
    let mut page = Drawing::new(area.right() + 2.0 * MARGIN, area.bottom() + 3.0 * line);
    head(&mut page, show, &legend);
    let plot = Plot::new(area, show);
    if let Some(interval) = show.frame_interval {
        let right = plot.x(interval).clamp(area.x, area.right());
        let shade = Area {
            width: right - area.x,
            ..area
        };
        page.fill(shade, SHADE);
        page.line((right, area.y), (right, area.bottom()), 1.0, ink::BARS);
    }
    axes(&mut page, area, plot.across, plot.up);
    let ceiling = plot.y(1.0);
    page.line((area.x, ceiling), (area.right(), ceiling), 2.0, CEILING);
    let mut path = |of: fn(&CurvePoint) -> f64, width, ink| {
        let places: Vec<Point> = { show.points.iter() }
            .map(|point| (plot.x(point.window), plot.y(of(point))))
            .collect();
        for pair in places.windows(2) {
            if let [from, to] = pair {
                page.line(*from, *to, width, ink);
            }
        }
    };
    path(|point| point.floor, 2.0, FLOOR);
    path(|point| point.score, 3.0, SCORE);
    // What is kept is the way from the floor to the score.
    let CurvePoint {
        window,
        score,
        floor,
    } = show.headline;
    let x = plot.x(window);
    let (low, high) = (plot.y(floor), plot.y(score));
    page.line((x, low), (x, high), 3.0, KEPT);
    for y in [low, high] {
        page.line((x - 6.0, y), (x + 6.0, y), 3.0, KEPT);
    }
    page.fitted(MARGIN)
}

/// Places of values.
struct Plot {
    area: Area,
    across: Axis<'static>,
    up: Axis<'static>,
}

impl Plot {
    fn new(area: Area, show: &CurveShow<'_>) -> Self {
        let windows = show.points.iter().chain([&show.headline]);
        let (mut from, mut to) = (f64::INFINITY, f64::NEG_INFINITY);
        for window in windows.map(|point| decade(point.window)) {
            (from, to) = (from.min(window), to.max(window));
        }
        Self {
            area,
            across: Axis {
                label: "window: events match when their times differ by at most this",
                from,
                to,
                scale: Scale::Decades,
            },
            up: Axis {
                label: "",
                from: 0.0,
                to: 1.05,
                scale: Scale::Plain,
            },
        }
    }

    fn x(&self, window: Micros) -> f64 {
        self.area.x + self.across.part(decade(window)) * self.area.width
    }

    fn y(&self, score: f64) -> f64 {
        self.area.bottom() - self.up.part(score) * self.area.height
    }
}

fn decade(window: Micros) -> f64 {
    elementary::log10(window.0.max(1) as f64)
}

/// What each line is, in rows that fit the page.
struct Legend(Vec<Vec<(Ink, String)>>);

impl Legend {
    fn new(show: &CurveShow<'_>) -> Self {
        let mut rows = vec![
            vec![
                (SCORE, show.score.to_owned()),
                (CEILING, "ceiling: the reference itself".to_owned()),
            ],
            vec![
                (FLOOR, "floor: right places, times by chance".to_owned()),
                (KEPT, "kept: the way from the floor".to_owned()),
            ],
        ];
        if show.frame_interval.is_some() {
            let what = "below the time from frame to frame: says which frame, not when";
            rows.push(vec![(SHADE, what.to_owned())]);
        }
        Self(rows)
    }

    const fn rows(&self) -> usize {
        self.0.len()
    }
}

/// Title, captions and legend.
fn head(page: &mut Drawing, show: &CurveShow<'_>, legend: &Legend) {
    let line = f64::from(LINE);
    let mut y = MARGIN;
    let write = |page: &mut Drawing, x, y, weight, ink, text: &str| {
        page.text((x, y), Anchor::Start, weight, ink, text);
    };
    write(page, MARGIN, y, Weight::Heading, ink::TEXT, show.title);
    for caption in show.captions {
        y += line;
        write(page, MARGIN, y, Weight::Plain, ink::CAPTION, caption);
    }
    y += 0.4 * line;
    for row in &legend.0 {
        y += line;
        let mut x = MARGIN;
        for (ink, text) in row {
            let swatch = Area {
                x,
                y: y + 3.0,
                width: SWATCH,
                height: SWATCH,
            };
            page.fill(swatch, *ink);
            if *ink == SHADE {
                page.frame(swatch, 1.0, ink::BARS);
            }
            x += SWATCH + 6.0;
            write(page, x, y, Weight::Plain, ink::TEXT, text);
            x += LETTER * text.chars().count() as f64 + 20.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::raster;

    #[test]
    fn lines_lie_where_their_values_are() {
        let point = |window, score, floor| CurvePoint {
            window: Micros(window),
            score,
            floor,
        };
        let points = [
            point(1, 0.2, 0.1),
            point(1_000, 0.6, 0.3),
            point(1_000_000, 0.9, 0.8),
        ];
        let show = CurveShow {
            title: "one against the other",
            captions: &["kept 0.429 within 1ms".to_owned()],
            score: "F1",
            points: &points,
            headline: points[1],
            frame_interval: Some(Micros(1_000)),
        };
        let drawing = curve(&show);
        let texts: Vec<_> = drawing.texts().collect();
        for text in ["F1", "1 us", "1 ms", "1 s", "kept 0.429 within 1ms"] {
            assert!(texts.contains(&text), "{text} in {texts:?}");
        }
        assert!(
            texts
                .iter()
                .any(|text| text.contains("which frame, not when"))
        );
        let picture = raster(&drawing, 1);
        let top = MARGIN + 6.0 * f64::from(LINE) + 12.0;
        let up = |score: f64| (top + HEIGHT * (1.0 - score / 1.05)) as u32;
        // The headline lies in the middle of six decades; beside its bar is the shade's edge.
        let middle = (LEFT + PLOT / 2.0) as u32;
        assert_eq!(*picture.get_pixel(middle, up(0.45)), KEPT);
        assert_ne!(*picture.get_pixel(middle, up(0.2)), KEPT);
        assert_ne!(*picture.get_pixel(middle, up(0.7)), KEPT);
        assert_eq!(*picture.get_pixel(middle - 90, up(0.97)), SHADE);
        assert_eq!(*picture.get_pixel(middle + 90, up(0.97)), ink::PAGE);
        let quarter = (LEFT + PLOT / 4.0) as u32;
        // Edges of thin lines are blended with what is behind them.
        let near = |score: f64, ink: image::Rgb<u8>| {
            let got = picture.get_pixel(quarter, up(score));
            let off = got.0.iter().zip(ink.0).map(|(a, b)| a.abs_diff(b));
            assert!(off.max() <= Some(12), "{score}: {got:?} for {ink:?}");
        };
        near(0.4, SCORE);
        near(0.2, FLOOR);
        near(1.0, CEILING);

        let plain = CurveShow {
            frame_interval: None,
            ..show
        };
        let without = curve(&plain);
        assert!(!without.texts().any(|text| text.contains("which frame")));
    }
}
