//! Error against cost: every sensor a dot, those that no other beats joined by a line.

use super::{
    chart::{
        Anchor, Area, Drawing,
        axes::{Axis, Scale, axes},
    },
    ink::{self, Ink},
    text::{LINE, Weight},
};

/// One sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct Dot {
    /// What it is called.
    pub name: String,
    /// Its cost, above zero.
    pub cost: f64,
    /// Its error, 0 to 1.
    pub error: f64,
    /// Whether another beats it.
    pub dominated: bool,
    /// Which side of the comparison it is on, 0 to 2: a colour of its own.
    pub side: usize,
}

/// Dots that are compared with each other.
#[derive(Clone, Debug, PartialEq)]
pub struct FrontShow<'a> {
    /// Above the chart.
    pub heading: String,
    /// What the cost is, with its unit.
    pub cost: &'a str,
    /// The cost is in seconds; else in units of its own.
    pub seconds: bool,
    /// Names of the sides.
    pub sides: [&'a str; 3],
    /// The dots.
    pub dots: Vec<Dot>,
}

/// Of each side.
const SIDES: [Ink; 3] = [ink::ON, ink::OFF, ink::EXTRA];

/// The page is so wide; the names of the front take the right part of it.
const WIDTH: f64 = 1120.0;
const PLOT: f64 = 620.0;
const HEIGHT: f64 = 330.0;
const TOP: f64 = 78.0;

/// Charts below each other, one for each group.
#[must_use]
pub fn fronts(shows: &[FrontShow<'_>]) -> Drawing {
    let line = f64::from(LINE);
    let height = |show: &FrontShow<'_>| {
        let named = show.dots.iter().filter(|dot| !dot.dominated).count();
        (named as f64 + 3.0)
            .mul_add(line, TOP)
            .max(TOP + HEIGHT + 60.0)
    };
    let all: f64 = shows.iter().map(height).sum();
    let mut drawing = Drawing::new(WIDTH, all.max(60.0));
    let mut top = 0.0;
    for show in shows {
        draw(&mut drawing, show, top);
        top += height(show);
    }
    drawing
}

fn draw(drawing: &mut Drawing, show: &FrontShow<'_>, top: f64) {
    let line = f64::from(LINE);
    drawing.text(
        (24.0, top + 12.0),
        Anchor::Start,
        Weight::Heading,
        ink::TEXT,
        show.heading.as_str(),
    );
    let area = Area {
        x: 64.0,
        y: top + TOP,
        width: PLOT - 64.0,
        height: HEIGHT,
    };
    // Axes of time count microseconds.
    let place = |cost: f64| {
        if show.seconds {
            (cost * 1e6).max(1e-3).log10()
        } else {
            cost
        }
    };
    let costs = || show.dots.iter().map(|dot| place(dot.cost));
    let (low, high) = (
        costs().fold(f64::INFINITY, f64::min),
        costs().fold(f64::NEG_INFINITY, f64::max),
    );
    let margin = if high > low { 0.06 * (high - low) } else { 0.5 };
    let (from, to) = if show.seconds {
        ((low - margin).floor(), (high + margin).ceil())
    } else {
        ((low - margin).max(0.0), high + margin)
    };
    let worst = show
        .dots
        .iter()
        .fold(0.0, |most: f64, dot| most.max(dot.error));
    let x = Axis {
        label: show.cost,
        from,
        to,
        scale: if show.seconds {
            Scale::Decades
        } else {
            Scale::Plain
        },
    };
    let y = Axis {
        label: "error: 1 - F1 against the f64 sensor",
        from: 0.0,
        to: if worst > 0.0 { worst * 1.08 } else { 1.0 },
        scale: Scale::Plain,
    };
    axes(drawing, area, x, y);
    let at = |dot: &Dot| {
        (
            area.x + x.part(place(dot.cost)) * area.width,
            area.bottom() - y.part(dot.error) * area.height,
        )
    };
    let mut front: Vec<&Dot> = show.dots.iter().filter(|dot| !dot.dominated).collect();
    front.sort_by(|a, b| a.cost.total_cmp(&b.cost).then(b.error.total_cmp(&a.error)));
    // Nothing better than these steps was found.
    for pair in front.windows(2) {
        if let [a, b] = pair {
            let (from, to) = (at(a), at(b));
            drawing.line(from, (to.0, from.1), 1.5, ink::MATCHED);
            drawing.line((to.0, from.1), to, 1.5, ink::MATCHED);
        }
    }
    let square = |drawing: &mut Drawing, (x, y): (f64, f64), half: f64, ink: Ink| {
        let side = 2.0 * half;
        let area = Area {
            x: x - half,
            y: y - half,
            width: side,
            height: side,
        };
        drawing.fill(area, ink);
    };
    let colour = |dot: &Dot| SIDES.get(dot.side).copied().unwrap_or(ink::BARS);
    for dot in show.dots.iter().filter(|dot| dot.dominated) {
        square(drawing, at(dot), 2.5, colour(dot));
    }
    let names = PLOT + 40.0;
    let heading = (names, top + TOP - line - 4.0);
    drawing.text(
        heading,
        Anchor::Start,
        Weight::Heading,
        ink::TEXT,
        "on the front, the cheapest first",
    );
    for (number, dot) in (1..).zip(&front) {
        let (px, py) = at(dot);
        square(drawing, (px, py), 5.0, colour(dot));
        let label = (px + 7.0, py - line);
        let own = format!("{number}");
        drawing.text(label, Anchor::Start, Weight::Plain, ink::TEXT, own);
        let row = top + TOP + f64::from(number - 1) * line;
        square(drawing, (names + 4.0, row + line / 2.0), 4.0, colour(dot));
        let text = format!("{number} {} ({:.4})", dot.name, dot.error);
        drawing.text(
            (names + 14.0, row),
            Anchor::Start,
            Weight::Plain,
            ink::TEXT,
            text,
        );
    }
    let mut left = 24.0;
    for (side, name) in show.sides.iter().enumerate() {
        if !show.dots.iter().any(|dot| dot.side == side) {
            continue;
        }
        let ink = SIDES.get(side).copied().unwrap_or(ink::BARS);
        square(drawing, (left + 4.0, top + 44.0), 4.0, ink);
        let text = (left + 14.0, top + 34.0);
        drawing.text(text, Anchor::Start, Weight::Plain, ink::CAPTION, *name);
        left += 30.0 + 9.0 * name.len() as f64;
    }
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
        };
        let drawing = fronts(&[show]);
        let texts: Vec<&str> = drawing.texts().collect();
        let named = |name: &str| texts.iter().any(|text| text.contains(name));
        assert!(named("1 fast") && named("2 slow") && !named("beaten"));
        assert!(named("reference") && !named("mesh"), "only sides with dots");
    }
}
