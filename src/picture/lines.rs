//! A quality over a cost, a line for each of several sensors, every run a dot.

use super::{
    chart::{
        Anchor, Area, Drawing, Point,
        axes::{Axis, Scale, axes},
    },
    ink::{self, Ink},
    text::{LINE, Weight},
};
use crate::{elementary, order::Order};

/// What a chart of lines is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct LinesShow<'a> {
    /// The line on top.
    pub title: &'a str,
    /// Lines below it.
    pub captions: &'a [String],
    /// What is across, with its unit; its axis is logarithmic.
    pub across: &'a str,
    /// What goes up, with its unit.
    pub up: &'a str,
    /// The lines.
    pub lines: Vec<Line>,
    /// Levels that go all the way across, with their names: sensors without a cost.
    pub levels: Vec<(String, f64)>,
}

/// A line of a chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// What it is called.
    pub name: String,
    /// Its corners in order of their cost: cost, above 0, and quality.
    pub corners: Vec<[f64; 2]>,
    /// The runs of which the corners are the means, likewise.
    pub dots: Vec<[f64; 2]>,
}

const PLOT: f64 = 640.0;
const HEIGHT: f64 = 380.0;
const LEFT: f64 = 72.0;
const NAMES: f64 = 220.0;
const MARGIN: f64 = 24.0;

/// The lines over the logarithm of their cost, their names beside them, the best at the end first.
#[must_use]
pub fn lines(show: &LinesShow<'_>) -> Drawing {
    let line = f64::from(LINE);
    let top = MARGIN + (show.captions.len() + 2) as f64 * line + 16.0;
    let area = Area {
        x: LEFT,
        y: top,
        width: PLOT,
        height: HEIGHT,
    };
    let rows = (show.lines.len() + show.levels.len()) as f64 * line;
    let bottom = area.bottom().max(top + rows) + 3.0 * line;
    let mut page = Drawing::new(area.right() + NAMES, bottom);
    let write = |page: &mut Drawing, at: Point, weight, ink, text: &str| {
        page.text(at, Anchor::Start, weight, ink, text);
    };
    write(
        &mut page,
        (MARGIN, MARGIN),
        Weight::Heading,
        ink::TEXT,
        show.title,
    );
    for (n, caption) in (1..).zip(show.captions) {
        let at = (MARGIN, MARGIN + f64::from(n) * line);
        write(&mut page, at, Weight::Plain, ink::CAPTION, caption);
    }
    let plot = Plot::new(area, show);
    axes(&mut page, area, plot.across, plot.up);
    for (_, level) in &show.levels {
        let y = plot.y(*level);
        page.line((area.x, y), (area.right(), y), 1.5, ink::MATCHED);
    }
    for (n, one) in show.lines.iter().enumerate() {
        let ink = colour(n);
        for dot in &one.dots {
            page.square(plot.at(*dot), 2.0, ink);
        }
        for pair in one.corners.windows(2) {
            if let [from, to] = pair {
                page.line(plot.at(*from), plot.at(*to), 2.0, ink);
            }
        }
        for corner in &one.corners {
            page.square(plot.at(*corner), 4.0, ink);
        }
    }
    // What is named, from above to below as at the end of the lines.
    let last = |one: &Line| {
        one.corners
            .last()
            .map_or(f64::NEG_INFINITY, |corner| corner[1])
    };
    let mut named: Vec<(f64, Ink, &str)> = { show.lines.iter().enumerate() }
        .map(|(n, one)| (last(one), colour(n), one.name.as_str()))
        .chain({ show.levels.iter() }.map(|(name, level)| (*level, ink::MATCHED, name.as_str())))
        .collect();
    named.order_by(|a, b| b.0.total_cmp(&a.0));
    for (n, (_, ink, name)) in (0..).zip(named) {
        let y = top + f64::from(n) * line;
        page.square((area.right() + 20.0, y + line / 2.0), 5.0, ink);
        write(
            &mut page,
            (area.right() + 32.0, y),
            Weight::Plain,
            ink::TEXT,
            name,
        );
    }
    page.fitted(MARGIN)
}

/// Places of values.
struct Plot<'a> {
    area: Area,
    across: Axis<'a>,
    up: Axis<'a>,
}

impl<'a> Plot<'a> {
    fn new(area: Area, show: &LinesShow<'a>) -> Self {
        let all = || { show.lines.iter() }.flat_map(|one| one.corners.iter().chain(&one.dots));
        let costs = all().map(|[cost, _]| log(*cost));
        let qualities = all().map(|[_, quality]| *quality);
        let levels = show.levels.iter().map(|(_, level)| *level);
        let axis = |label, (from, to): (f64, f64), scale| {
            let room = if to > from { 0.05 * (to - from) } else { 0.5 };
            Axis {
                label,
                from: from - room,
                to: to + room,
                scale,
            }
        };
        Self {
            area,
            across: axis(show.across, ends(costs), Scale::Powers),
            up: axis(show.up, ends(qualities.chain(levels)), Scale::Plain),
        }
    }

    fn y(&self, quality: f64) -> f64 {
        self.area.bottom() - self.up.part(quality) * self.area.height
    }

    fn at(&self, [cost, quality]: [f64; 2]) -> Point {
        let x = self.area.x + self.across.part(log(cost)) * self.area.width;
        (x, self.y(quality))
    }
}

fn log(cost: f64) -> f64 {
    elementary::log10(cost.max(f64::MIN_POSITIVE))
}

/// The least and the greatest.
fn ends(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for value in values {
        (low, high) = (low.min(value), high.max(value));
    }
    if low > high { (0.0, 1.0) } else { (low, high) }
}

fn colour(n: usize) -> Ink {
    ink::CAUSES[n % ink::CAUSES.len()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::raster;

    #[test]
    fn corners_lie_where_their_values_are() {
        let show = LinesShow {
            title: "two",
            captions: &["of them".to_owned()],
            across: "bits",
            up: "dB",
            lines: vec![
                Line {
                    name: "lower".to_owned(),
                    corners: vec![[1.0, 20.0], [10.0, 25.0], [100.0, 30.0]],
                    dots: Vec::new(),
                },
                Line {
                    name: "upper".to_owned(),
                    corners: vec![[1.0, 30.0], [100.0, 40.0]],
                    dots: vec![[10.0, 32.0]],
                },
            ],
            levels: vec![("level".to_owned(), 22.0)],
        };
        let drawing = lines(&show);
        let texts: Vec<&str> = drawing.texts().collect();
        let place = |name: &str| texts.iter().position(|text| *text == name).unwrap();
        assert!(place("upper") < place("lower") && place("lower") < place("level"));
        assert!(texts.contains(&"dB") && texts.contains(&"bits") && texts.contains(&"of them"));
        let picture = raster(&drawing, 1);
        let top = MARGIN + 3.0 * f64::from(LINE) + 16.0;
        let at = |part: f64, quality: f64| {
            let across = LEFT + PLOT * (0.05 + part) / 1.1;
            let up = top + HEIGHT * (1.0 - (quality - 19.0) / 22.0);
            *picture.get_pixel(across as u32, up as u32)
        };
        assert_eq!(at(0.5, 25.0), colour(0));
        assert_eq!(at(1.0, 40.0), colour(1));
        assert_eq!(at(0.5, 32.0), colour(1));
        assert_eq!(at(0.25, 38.0), ink::PAGE);
    }
}
