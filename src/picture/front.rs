//! Error against cost: every sensor a dot, those that no other beats joined by a line.

use super::{
    chart::{
        Anchor, Area, Drawing, Point,
        axes::{Axis, Scale, axes},
        labels,
    },
    ink::{self, Ink},
    text::{Face, LINE, Weight},
};
use crate::{elementary, order::Order};

/// One sensor, a dot of the chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Dot {
    /// What it is called.
    pub name: String,
    /// Its cost, above zero, in the chart's unit.
    pub cost: f64,
    /// Its error, 0 to 1.
    pub error: f64,
    /// Whether another sensor is, or seems, better in both error and cost (it is not on the Pareto
    /// front).
    pub dominated: bool,
    /// Index of its group in [`FrontShow::sides`], 0 to 2; each group has a colour.
    pub side: usize,
}

/// One chart: sensors that are compared with each other.
#[derive(Clone, Debug, PartialEq)]
pub struct FrontShow<'a> {
    /// Above the chart.
    pub heading: String,
    /// What the cost is, with its unit.
    pub cost: &'a str,
    /// Whether the cost is in seconds, shown on a logarithmic axis in microseconds.
    pub seconds: bool,
    /// Names of the groups, such as float model and chip.
    pub sides: [&'a str; 3],
    /// The dots.
    pub dots: Vec<Dot>,
    /// Lines below the chart.
    pub notes: Vec<String>,
}

/// Colours of the groups.
const SIDES: [Ink; 3] = [ink::ON, ink::OFF, ink::EXTRA];

/// Least width of the page in points; the names of the front take the right part of it.
const WIDTH: f64 = 1120.0;
const MARGIN: f64 = 24.0;
const PLOT: f64 = 620.0;
const HEIGHT: f64 = 330.0;
const TOP: f64 = 78.0;
/// Where the names of the front begin.
const NAMES: f64 = PLOT + 40.0;

/// Charts below each other, one for each group.
#[must_use]
pub fn fronts(shows: &[FrontShow<'_>]) -> Drawing {
    let height =
        |show: &FrontShow<'_>| (show.notes.len() as f64).mul_add(f64::from(LINE), above(show));
    let all: f64 = shows.iter().map(height).sum();
    let width = shows.iter().map(width).fold(WIDTH, f64::max);
    let mut drawing = Drawing::new(width, all.max(60.0));
    let mut top = 0.0;
    for show in shows {
        draw(&mut drawing, show, top);
        top += height(show);
    }
    drawing
}

/// Width of a chart with all that is written.
fn width(show: &FrontShow<'_>) -> f64 {
    let face = Face::new(Weight::Plain, 1);
    let right = |left: f64, text: &str| left + f64::from(face.width(text)) + MARGIN;
    let notes = show.notes.iter().chain([&show.heading]);
    let notes = notes.map(|text| right(MARGIN, text));
    let front = show.dots.iter().filter(|dot| !dot.dominated);
    let names = front.map(|dot| right(NAMES + 14.0, &named(show.dots.len(), dot)));
    notes.chain(names).fold(0.0, f64::max)
}

/// Height of a chart and of the names beside it; its notes are below.
fn above(show: &FrontShow<'_>) -> f64 {
    let named = show.dots.iter().filter(|dot| !dot.dominated).count();
    (named as f64 + 3.0)
        .mul_add(f64::from(LINE), TOP)
        .max(TOP + HEIGHT + 60.0)
}

/// Where the dots of a chart lie on the page.
struct Plot<'a> {
    area: Area,
    x: Axis<'a>,
    y: Axis<'a>,
    seconds: bool,
}

impl<'a> Plot<'a> {
    fn new(show: &FrontShow<'a>, top: f64) -> Self {
        let costs = || show.dots.iter().map(|dot| along(dot.cost, show.seconds));
        let low = costs().fold(f64::INFINITY, f64::min);
        let high = costs().fold(f64::NEG_INFINITY, f64::max);
        let margin = if high > low { 0.06 * (high - low) } else { 0.5 };
        let (from, to, scale) = if show.seconds {
            let (from, to) = ((low - margin).floor(), (high + margin).ceil());
            (from, to, Scale::Decades)
        } else {
            ((low - margin).max(0.0), high + margin, Scale::Plain)
        };
        let errors = show.dots.iter().map(|dot| dot.error);
        let worst = errors.fold(0.0, f64::max);
        Self {
            area: Area {
                x: 64.0,
                y: top + TOP,
                width: PLOT - 64.0,
                height: HEIGHT,
            },
            x: Axis {
                label: show.cost,
                from,
                to,
                scale,
            },
            y: Axis {
                label: "error: 1 - kept, against the f64 sensor",
                from: 0.0,
                to: if worst > 0.0 { worst * 1.08 } else { 1.0 },
                scale: Scale::Plain,
            },
            seconds: show.seconds,
        }
    }

    fn at(&self, dot: &Dot) -> Point {
        let x = self.x.part(along(dot.cost, self.seconds));
        (
            self.area.x + x * self.area.width,
            self.area.bottom() - self.y.part(dot.error) * self.area.height,
        )
    }
}

/// The place of a cost on its axis; axes of time count decades of microseconds.
fn along(cost: f64, seconds: bool) -> f64 {
    if seconds {
        elementary::log10((cost * 1e6).max(1e-3))
    } else {
        cost
    }
}

fn draw(drawing: &mut Drawing, show: &FrontShow<'_>, top: f64) {
    let heading = (24.0, top + 12.0);
    write(drawing, heading, Weight::Heading, &show.heading);
    legend(drawing, show, top);
    let plot = Plot::new(show, top);
    axes(drawing, plot.area, plot.x, plot.y);
    let mut front: Vec<&Dot> = show.dots.iter().filter(|dot| !dot.dominated).collect();
    front.order_by(|a, b| {
        let by_cost = a.cost.total_cmp(&b.cost);
        by_cost.then(b.error.total_cmp(&a.error))
    });
    // Nothing better than these steps was found.
    for pair in front.windows(2) {
        if let [a, b] = pair {
            let (from, to) = (plot.at(a), plot.at(b));
            drawing.line(from, (to.0, from.1), 1.5, ink::MATCHED);
            drawing.line((to.0, from.1), to, 1.5, ink::MATCHED);
        }
    }
    for dot in show.dots.iter().filter(|dot| dot.dominated) {
        drawing.square(plot.at(dot), 2.5, colour(dot.side));
    }
    let line = f64::from(LINE);
    for (row, note) in (0..).zip(&show.notes) {
        let place = (24.0, f64::from(row).mul_add(line, top + above(show)));
        write(drawing, place, Weight::Plain, note);
    }
    let heading = (NAMES, top + TOP - line - 4.0);
    let what = "on the front, the cheapest first";
    write(drawing, heading, Weight::Heading, what);
    let places: Vec<Point> = front.iter().map(|dot| plot.at(dot)).collect();
    for (i, (dot, place)) in front.iter().zip(&places).enumerate() {
        drawing.square(*place, 5.0, colour(dot.side));
        let number = i + 1;
        let row = top + TOP + i as f64 * line;
        let mark = (NAMES + 4.0, row + line / 2.0);
        drawing.square(mark, 4.0, colour(dot.side));
        let text = named(number, dot);
        write(drawing, (NAMES + 14.0, row), Weight::Plain, &text);
    }
    let numbers = numbers(&places);
    let face = Face::new(Weight::Plain, 1);
    let labelled: Vec<(Point, f64)> = { numbers.iter() }
        .map(|(number, dot)| (*dot, f64::from(face.width(number))))
        .collect();
    let beaten = show.dots.iter().filter(|dot| dot.dominated);
    let others: Vec<Point> = beaten.map(|dot| plot.at(dot)).chain(places).collect();
    let labels = labels::labels(plot.area, &labelled, &others);
    for ((number, dot), label) in numbers.iter().zip(labels) {
        labels::leader(drawing, label, *dot);
        write(drawing, (label.x, label.y), Weight::Plain, number);
    }
}

/// A sensor of the front, as it is listed.
fn named(number: usize, dot: &Dot) -> String {
    format!("{number} {} ({:.4})", dot.name, dot.error)
}

/// Dots closer than this, in points, have one label.
const NEAR: f64 = 4.0;

/// The numbers of dots, from 1 on: of dots at one place together, as `1-6`, each with the first of its
/// dots.
fn numbers(dots: &[Point]) -> Vec<(String, Point)> {
    let is_near = |a: &Point, b: &Point| (a.0 - b.0).abs() < NEAR && (a.1 - b.1).abs() < NEAR;
    let mut first = 1;
    let mut numbers = Vec::new();
    for together in dots.chunk_by(is_near) {
        let last = first + together.len() - 1;
        let number = if last > first {
            format!("{first}-{last}")
        } else {
            first.to_string()
        };
        numbers.push((number, together[0]));
        first = last + 1;
    }
    numbers
}

/// The colours of the sides that have dots.
fn legend(drawing: &mut Drawing, show: &FrontShow<'_>, top: f64) {
    let mut left = 24.0;
    for (side, name) in show.sides.iter().enumerate() {
        if show.dots.iter().any(|dot| dot.side == side) {
            drawing.square((left + 4.0, top + 44.0), 4.0, colour(side));
            write(drawing, (left + 14.0, top + 34.0), Weight::Plain, name);
            left += 30.0 + 9.0 * name.len() as f64;
        }
    }
}

fn write(drawing: &mut Drawing, at: Point, weight: Weight, text: &str) {
    drawing.text(at, Anchor::Start, weight, ink::TEXT, text);
}

fn colour(side: usize) -> Ink {
    SIDES.get(side).copied().unwrap_or(ink::BARS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_is_named_and_the_rest_is_not() {
        let dot = |name: &str, cost, error, dominated| Dot {
            name: name.to_owned(),
            cost,
            error,
            dominated,
            side: 0,
        };
        let show = FrontShow {
            heading: "three".to_owned(),
            cost: "time per frame",
            seconds: true,
            sides: ["reference", "array", "mesh"],
            dots: vec![
                dot("slow", 1e-3, 0.0, false),
                dot("fast", 1e-4, 0.2, false),
                dot("beaten", 2e-3, 0.3, true),
            ],
            notes: vec!["a note".to_owned()],
        };
        let drawing = fronts(&[show]);
        let texts: Vec<&str> = drawing.texts().collect();
        let named = |name: &str| texts.iter().any(|text| text.contains(name));
        assert!(named("1 fast") && named("2 slow") && !named("beaten"));
        assert!(named("a note"));
        assert!(named("reference") && !named("mesh"), "only sides with dots");
    }

    #[test]
    fn dots_at_one_place_have_one_number() {
        let told = numbers(&[(10.0, 50.0), (10.0, 51.0), (16.0, 52.0), (300.0, 9.0)]);
        let names: Vec<&str> = told.iter().map(|(number, _)| number.as_str()).collect();
        assert_eq!(names, ["1-2", "3", "4"]);
        assert_eq!(told[2].1, (300.0, 9.0));
    }

    #[test]
    fn long_names_and_headings_widen_the_page() {
        let show = |name: &str, heading: &str| FrontShow {
            heading: heading.to_owned(),
            cost: "bits",
            seconds: false,
            sides: ["reference", "array", "mesh"],
            dots: vec![Dot {
                name: name.to_owned(),
                cost: 1.0,
                error: 4.7566,
                dominated: false,
                side: 0,
            }],
            notes: Vec::new(),
        };
        let long = "a sensor with a long name ".repeat(8);
        let wide = |name: &str, heading: &str| fronts(&[show(name, heading)]).size().0;
        assert_eq!(wide("short", "short"), WIDTH);
        let letters = f64::from(Face::new(Weight::Plain, 1).width(&long));
        assert!(wide(&long, "short") >= NAMES + letters);
        assert!(wide("short", &long) >= MARGIN + letters);
    }
}
