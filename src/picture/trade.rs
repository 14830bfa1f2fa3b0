//! Error against seconds: every model a dot, with what it took to know it, and the front.

use super::{
    chart::{
        Anchor, Area, Drawing, Point,
        axes::{Axis, Scale, axes},
        labels,
    },
    ink::{self, Ink},
    text::{LINE, Weight},
};
use crate::elementary;

/// A model, a dot of the chart.
#[derive(Clone, Debug, PartialEq)]
pub struct TradeDot {
    /// What it is called.
    pub name: String,
    /// Seconds of a run.
    pub run: f64,
    /// The least and the most seconds of the measurements in the middle.
    pub range: [f64; 2],
    /// Seconds that it took to know its error.
    pub planning: f64,
    /// The share of changed events, about.
    pub share: f64,
    /// The upper confidence limit of the share (95 %).
    pub limit: f64,
    /// Whether nothing beats it.
    pub on_front: bool,
    /// Whether it is the knee.
    pub is_knee: bool,
}

/// What a trade is shown by.
#[derive(Clone, Debug)]
pub struct TradeShow<'a> {
    /// The line on top.
    pub title: &'a str,
    /// Whether all was run on the whole scene, so that shares are what was measured.
    pub is_whole: bool,
    /// Lines below it.
    pub captions: &'a [String],
    /// The dots, in the order of their seconds with planning.
    pub dots: Vec<TradeDot>,
    /// The command of the knee, in lines; below the chart.
    pub knee: &'a [String],
}

const MARGIN: f64 = 24.0;
const LEFT: f64 = 78.0;
const PLOT: f64 = 560.0;
const HEIGHT: f64 = 380.0;
/// Room at the right for what stands before a name, at least; and a letter's.
const NAMES: f64 = 318.0;
const LETTER: f64 = 8.0;

/// Half the side of a dot of the front.
const HALF: f64 = 5.0;

const FRONT: Ink = ink::ON;
const KNEE: Ink = ink::OFF;
const BEATEN: Ink = ink::BARS;

/// The least share that has a place of its own, as a power of ten in per cent. What is below it is
/// drawn at 0, half a decade below.
const LEAST: f64 = -3.0;
const ZERO: f64 = LEAST - 0.5;

/// The chart: seconds to the right, changed events up, both as logarithms.
#[must_use]
pub fn trade(show: &TradeShow<'_>) -> Drawing {
    let line = f64::from(LINE);
    let top = MARGIN + (show.captions.len() as f64 + 5.0) * line;
    let area = Area {
        x: LEFT,
        y: top,
        width: PLOT,
        height: HEIGHT,
    };
    let rows = show.dots.len() as f64 + 3.0;
    let bottom = (area.bottom() + 3.0 * line).max(rows.mul_add(line, top));
    let bottom = bottom + (show.knee.len() as f64 + 1.0) * line;
    let mut page = Drawing::new(area.right() + NAMES, bottom + MARGIN);
    let mut y = MARGIN;
    write(
        &mut page,
        (MARGIN, y),
        Weight::Heading,
        ink::TEXT,
        show.title,
    );
    for caption in show.captions {
        y += line;
        write(&mut page, (MARGIN, y), Weight::Plain, ink::CAPTION, caption);
    }
    legend(&mut page, y + 1.5 * line, show);
    let plot = Plot::new(area, &show.dots);
    axes(&mut page, area, plot.across, plot.up);
    let zero = plot.y(0.0);
    page.line((area.x, zero), (area.right(), zero), 1.0, ink::GRID);
    let place = (area.x - 8.0, zero - line / 2.0 + 1.0);
    page.text(place, Anchor::End, Weight::Plain, ink::CAPTION, "0");
    plot.front(&mut page, &show.dots);
    // The front lies over the rest.
    for dot in show.dots.iter().filter(|dot| !dot.on_front) {
        plot.dot(&mut page, dot);
    }
    for dot in show.dots.iter().filter(|dot| dot.on_front) {
        plot.dot(&mut page, dot);
    }
    let numbered = (1..).zip(&show.dots).zip(plot.numbers(&show.dots));
    for ((number, dot), (label, at)) in numbered {
        labels::leader(&mut page, label, at);
        let place = (label.x, label.y);
        let ink = if dot.on_front {
            ink::TEXT
        } else {
            ink::CAPTION
        };
        write(&mut page, place, Weight::Plain, ink, &number.to_string());
    }
    names(&mut page, area, show);
    let mut y = bottom - (show.knee.len() as f64 + 1.0) * line + line;
    for (n, text) in show.knee.iter().enumerate() {
        let weight = if n == 0 {
            Weight::Heading
        } else {
            Weight::Plain
        };
        write(&mut page, (MARGIN, y), weight, ink::TEXT, text);
        y += line;
    }
    page.fitted(MARGIN)
}

/// Where the dots lie.
struct Plot {
    area: Area,
    across: Axis<'static>,
    up: Axis<'static>,
}

fn log10(value: f64) -> f64 {
    elementary::log10(value)
}

/// Per cent as they are placed: with a floor, on which lies what changes nothing.
fn percent(share: f64) -> f64 {
    let percent = log10((100.0 * share).max(1e-9));
    if percent < LEAST { ZERO } else { percent }
}

impl Plot {
    fn new(area: Area, dots: &[TradeDot]) -> Self {
        let ends = |values: &mut dyn Iterator<Item = f64>| {
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                (low.min(value), high.max(value))
            })
        };
        let ends_of = |dot: &TradeDot| {
            let [least, most] = dot.range.map(|seconds| seconds + dot.planning);
            [dot.run, least.min(dot.run + dot.planning), most]
        };
        let mut seconds = { dots.iter() }.flat_map(ends_of);
        let (low, high) = ends(&mut seconds);
        let (low, high) = (log10(low.max(1e-9)), log10(high.max(1e-9)));
        let margin = (0.08 * (high - low)).max(0.06);
        let mut shares = { dots.iter() }.map(|dot| percent(dot.limit));
        let (_, most) = ends(&mut shares);
        Self {
            area,
            across: Axis {
                label: "seconds: a run, and before it what it takes to know its error",
                from: low - margin,
                to: high + margin,
                scale: Scale::Powers,
            },
            up: Axis {
                label: "events that change, %",
                from: ZERO - 0.2,
                to: most.max(0.0) + 0.2,
                scale: Scale::Powers,
            },
        }
    }

    fn x(&self, seconds: f64) -> f64 {
        self.area.x + self.across.part(log10(seconds.max(1e-9))) * self.area.width
    }

    fn y(&self, share: f64) -> f64 {
        self.area.bottom() - self.up.part(percent(share)) * self.area.height
    }

    /// Nothing better than these steps was found.
    fn front(&self, page: &mut Drawing, dots: &[TradeDot]) {
        let front: Vec<Point> = { dots.iter() }
            .filter(|dot| dot.on_front)
            .map(|dot| (self.x(dot.run + dot.planning), self.y(dot.limit)))
            .collect();
        for pair in front.windows(2) {
            if let [from, to] = pair {
                let corner = (to.0, from.1);
                page.line(*from, corner, 1.5, ink::MATCHED);
                page.line(corner, *to, 1.5, ink::MATCHED);
            }
        }
    }

    /// Where the dots' numbers stand, and the dots.
    fn numbers(&self, dots: &[TradeDot]) -> Vec<(Area, Point)> {
        let dot_at = |dot: &TradeDot| (self.x(dot.run + dot.planning), self.y(dot.limit));
        let numbered = (1..).zip(dots);
        let labelled: Vec<(Point, f64)> = numbered
            .map(|(number, dot)| (dot_at(dot), LETTER * digits(number)))
            .collect();
        let places = labels::labels(self.area, &labelled, &[]).into_iter();
        places.zip(labelled.iter().map(|(dot, _)| *dot)).collect()
    }

    fn dot(&self, page: &mut Drawing, dot: &TradeDot) {
        let ink = colour(dot);
        let half = if dot.on_front { HALF } else { 3.0 };
        let (x, y) = (self.x(dot.run + dot.planning), self.y(dot.limit));
        // What it took to know, and from the estimate to its limit.
        page.line((self.x(dot.run), y), (x, y), 1.5, ink);
        page.line((x, self.y(dot.share)), (x, y), 1.5, ink);
        // What was measured, from end to end.
        let [least, most] = dot.range.map(|seconds| self.x(seconds + dot.planning));
        page.line((least, y), (most, y), 0.75, ink);
        for end in [least, most] {
            page.line((end, y - 3.0), (end, y + 3.0), 0.75, ink);
        }
        page.square((x, y), half, ink);
    }
}

/// Digits of a number of a list.
fn digits(number: usize) -> f64 {
    f64::from(number.checked_ilog10().unwrap_or(0) + 1)
}

const fn colour(dot: &TradeDot) -> Ink {
    if dot.is_knee {
        KNEE
    } else if dot.on_front {
        FRONT
    } else {
        BEATEN
    }
}

/// What the colours of the dots mean, and their lines.
fn legend(page: &mut Drawing, y: f64, show: &TradeShow<'_>) {
    let mut x = MARGIN;
    let all = [
        (FRONT, "on the front: nothing is quicker and changes less"),
        (KNEE, "its knee"),
        (BEATEN, "beaten"),
    ];
    let is_drawn = |ink: Ink| show.dots.iter().any(|dot| colour(dot) == ink);
    for (ink, text) in all.into_iter().filter(|(ink, _)| is_drawn(*ink)) {
        page.square((x + 4.0, y + 10.0), 4.0, ink);
        write(page, (x + 16.0, y), Weight::Plain, ink::TEXT, text);
        x += 40.0 + LETTER * text.chars().count() as f64;
    }
    let lines = if show.is_whole {
        "squares: measured on the whole scene, and the seconds with the plan; lines: left to a run alone, and thin ones with ends what was measured"
    } else {
        "squares: the limit, and the seconds with the plan; lines: down to what was estimated, left to a run alone, and thin ones with ends what was measured"
    };
    let place = (MARGIN, y + f64::from(LINE));
    write(page, place, Weight::Plain, ink::CAPTION, lines);
}

/// Every model with its number: seconds with planning, and its share of changed events.
fn names(page: &mut Drawing, area: Area, show: &TradeShow<'_>) {
    let line = f64::from(LINE);
    let left = area.right() + MARGIN;
    let share_is = if show.is_whole { "changed" } else { "at most" };
    let heading = format!("    seconds     ±  {share_is}  model");
    write(
        page,
        (left, area.y - line),
        Weight::Heading,
        ink::TEXT,
        &heading,
    );
    for (number, dot) in (1..).zip(&show.dots) {
        let y = area.y + f64::from(number - 1) * line;
        page.square((left + 4.0, y + line / 2.0), 4.0, colour(dot));
        let text = format!(
            "{number:>2} {:>8} {:>5} {:>8}  {}",
            seconds(dot.run + dot.planning),
            half_range(dot),
            share(dot.limit),
            dot.name
        );
        let ink = if dot.on_front {
            ink::TEXT
        } else {
            ink::CAPTION
        };
        let weight = if dot.is_knee {
            Weight::Heading
        } else {
            Weight::Plain
        };
        write(page, (left + 14.0, y), weight, ink, &text);
    }
}

/// With two figures at least, down to microseconds.
fn seconds(seconds: f64) -> String {
    let decimals = match seconds {
        s if s >= 10.0 => 1.0,
        s if s > 0.0 => (1.0 - log10(s).floor()).clamp(3.0, 6.0),
        _ => 3.0,
    };
    let decimals = decimals as usize;
    format!("{seconds:.decimals$}")
}

/// Half of what the least and the most are apart, as a part of what is shown.
fn half_range(dot: &TradeDot) -> String {
    let [least, most] = dot.range;
    let part = (most - least) / (2.0 * (dot.run + dot.planning).max(1e-9));
    format!("{:.0} %", (100.0 * part).min(999.0))
}

fn share(share: f64) -> String {
    let percent = 100.0 * share;
    if percent == 0.0 {
        "0 %".to_owned()
    } else if percent < 0.001 {
        "<0.001 %".to_owned()
    } else if percent < 10.0 {
        format!("{percent:.3} %")
    } else {
        format!("{percent:.0} %")
    }
}

fn write(page: &mut Drawing, at: Point, weight: Weight, ink: Ink, text: &str) {
    page.text(at, Anchor::Start, weight, ink, text);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::raster;

    #[test]
    fn dots_lie_where_their_values_are() {
        let dot = |name: &str, run, planning, limit, on_front| TradeDot {
            name: name.to_owned(),
            run,
            range: [run, 1.02 * run],
            planning,
            share: limit,
            limit,
            on_front,
            is_knee: name == "f32",
        };
        let dots = vec![
            dot("f32", 0.4, 0.1, 0.01, true),
            dot("all", 5.0, 0.0, 0.0, true),
            dot("slow", 50.0, 0.0, 0.1, false),
        ];
        let mut show = TradeShow {
            title: "a scene",
            is_whole: false,
            captions: &["two of ten tiles".to_owned()],
            dots: dots.clone(),
            knee: &["the knee".to_owned(), "amacrine run".to_owned()],
        };
        let drawing = trade(&show);
        let texts: Vec<&str> = drawing.texts().collect();
        for text in [
            "a scene",
            "the knee",
            "amacrine run",
            "0.01",
            "0.1",
            "1",
            "10",
        ] {
            assert!(texts.contains(&text), "{text} in {texts:?}");
        }
        assert!(
            texts
                .iter()
                .any(|text| text.contains("0.500   1 %  1.000 %  f32"))
        );
        show.is_whole = true;
        let whole = trade(&show);
        for (drawing, heading, legend) in [
            (&drawing, "at most", "squares: the limit"),
            (&whole, "changed", "squares: measured on the whole scene"),
        ] {
            let has = |part: &str| drawing.texts().any(|text| text.contains(part));
            assert!(has(heading) && has(legend), "{heading}");
        }
        let picture = raster(&drawing, 1);
        let area = Area {
            x: LEFT,
            y: MARGIN + 6.0 * f64::from(LINE),
            width: PLOT,
            height: HEIGHT,
        };
        let plot = Plot::new(area, &dots);
        let at = |seconds, share| {
            let (x, y) = (plot.x(seconds), plot.y(share));
            *picture.get_pixel(x as u32, y as u32)
        };
        assert_eq!(at(0.5, 0.01), KNEE);
        // Its edges are soft, and the page is white.
        let bar = at(0.45, 0.01);
        assert!(bar.0[2] < 128, "a bar of planning: {bar:?}");
        assert_eq!(at(5.0, 0.0), FRONT);
        assert_eq!(at(50.0, 0.1), BEATEN);
        assert_eq!(at(0.6, 0.05), ink::PAGE);
    }
}
