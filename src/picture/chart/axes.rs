//! Axes: from values to places, with ticks at round numbers.

use super::{Anchor, Area, Drawing};
use crate::{
    elementary,
    picture::{
        ink,
        text::{LINE, Weight},
    },
};

/// One axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis<'a> {
    /// What is measured, with its unit.
    pub label: &'a str,
    pub from: f64,
    pub to: f64,
    pub scale: Scale,
}

/// How the values of an axis are labelled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scale {
    /// The values themselves.
    Plain,
    /// Absolute values: up and down from 0 are two directions, not two signs.
    Mirrored,
    /// Microseconds, of which the values are the logarithms to base 10.
    Decades,
    /// Numbers, of which the values are the logarithms to base 10.
    Powers,
}

impl Axis<'_> {
    /// The position of `value` along the axis: 0 at its beginning, 1 at its end.
    pub fn part(self, value: f64) -> f64 {
        if self.to > self.from {
            (value - self.from) / (self.to - self.from)
        } else {
            0.5
        }
    }

    /// Round values on the axis, at most about `most`, each with its label.
    fn ticks(self, most: usize) -> Vec<(f64, String)> {
        if !(self.to > self.from && self.from.is_finite() && self.to.is_finite()) {
            return Vec::new();
        }
        if self.scale == Scale::Powers {
            return self.powers(most);
        }
        let mut step = step((self.to - self.from) / most.max(1) as f64);
        if self.scale == Scale::Decades {
            step = step.max(1.0).round();
        }
        // Ticks start and end within a thousandth of a step of the ends, so that rounding hides
        // none.
        let ends = |step: f64| {
            let first = (self.from / step - 1e-3).ceil() as i64;
            (first, (self.to / step + 1e-3).floor() as i64)
        };
        // A zero alone is no scale.
        while self.scale != Scale::Decades && !reaches(ends(step)) {
            step = smaller(step);
        }
        let (first, last) = ends(step);
        let decimals = (-elementary::log10(step).floor()).max(0.0) as usize;
        (first..=last.min(first + 100))
            .map(|i| {
                let value = i as f64 * step;
                let text = match self.scale {
                    Scale::Plain => format!("{value:.decimals$}"),
                    Scale::Mirrored => format!("{:.decimals$}", value.abs()),
                    Scale::Decades | Scale::Powers => decade(value),
                };
                (value, text)
            })
            .collect()
    }

    /// Some digits of each decade, as many as there is room for.
    fn powers(self, most: usize) -> Vec<(f64, String)> {
        let decades = self.to - self.from;
        let digits: &[f64] = if decades * 3.0 > most as f64 {
            &[1.0]
        } else if decades * 5.0 > most as f64 {
            &[1.0, 2.0, 5.0]
        } else {
            &[1.0, 1.5, 2.0, 3.0, 4.0, 6.0]
        };
        let decades = self.from.floor() as i32..=self.to.ceil() as i32;
        let all = decades.flat_map(|decade| {
            let ten = elementary::pow(10_f64, f64::from(decade));
            digits.iter().map(move |digit| {
                let fraction = i32::from(digit.fract() > 0.0);
                let decimals = usize::try_from(fraction - decade).unwrap_or(0);
                let value = f64::from(decade) + elementary::log10(*digit);
                (value, format!("{:.decimals$}", digit * ten))
            })
        });
        all.filter(|(value, _)| (self.from..=self.to).contains(value))
            .collect()
    }
}

/// Whether one of these is not 0.
fn reaches((first, last): (i64, i64)) -> bool {
    first <= last && (first, last) != (0, 0)
}

/// The next below a step of 1, 2, 5, 10, ….
fn smaller(last: f64) -> f64 {
    step(last / 2.5)
}

/// The least of 1, 2, 5, 10, … that is at least `least`.
fn step(least: f64) -> f64 {
    let ten = elementary::pow(10_f64, elementary::log10(least).floor());
    [1.0, 2.0, 5.0]
        .into_iter()
        .map(|n| n * ten)
        .find(|s| *s >= least * (1.0 - 1e-9))
        .unwrap_or(10.0 * ten)
}

/// A power of ten microseconds, in a unit that makes it short.
fn decade(exponent: f64) -> String {
    let (unit, below) = match exponent {
        e if e < 3.0 => ("us", 0.0),
        e if e < 6.0 => ("ms", 3.0),
        _ => ("s", 6.0),
    };
    format!("{:.0} {unit}", elementary::pow(10_f64, exponent - below))
}

/// Length of a tick.
const TICK: f64 = 5.0;

/// Draws axes around an area: x below with its label, y at the left with its label above.
pub fn axes(drawing: &mut Drawing, area: Area, x: Axis<'_>, y: Axis<'_>) {
    let line = f64::from(LINE);
    for (value, text) in y.ticks((area.height / 45.0) as usize) {
        let at = area.bottom() - y.part(value) * area.height;
        if value > y.from {
            drawing.line((area.x, at), (area.right(), at), 1.0, ink::GRID);
        }
        drawing.line((area.x - TICK, at), (area.x, at), 1.0, ink::CAPTION);
        let place = (area.x - TICK - 3.0, at - line / 2.0 + 1.0);
        drawing.text(place, Anchor::End, Weight::Plain, ink::CAPTION, text);
    }
    for (value, text) in x.ticks((area.width / 85.0) as usize) {
        let at = area.x + x.part(value) * area.width;
        drawing.line(
            (at, area.bottom()),
            (at, area.bottom() + TICK),
            1.0,
            ink::CAPTION,
        );
        let place = (at, area.bottom() + TICK + 1.0);
        drawing.text(place, Anchor::Middle, Weight::Plain, ink::CAPTION, text);
    }
    drawing.line((area.x, area.y), (area.x, area.bottom()), 1.0, ink::CAPTION);
    let corner = (area.right(), area.bottom());
    drawing.line((area.x, area.bottom()), corner, 1.0, ink::CAPTION);
    let below = (area.x + area.width / 2.0, area.bottom() + TICK + line);
    drawing.text(below, Anchor::Middle, Weight::Plain, ink::TEXT, x.label);
    let above = (area.x, area.y - line - 4.0);
    drawing.text(above, Anchor::Start, Weight::Plain, ink::TEXT, y.label);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(from: f64, to: f64, most: usize, scale: Scale) -> Vec<String> {
        let axis = Axis {
            label: "",
            from,
            to,
            scale,
        };
        axis.ticks(most).into_iter().map(|(_, text)| text).collect()
    }

    #[test]
    fn ticks_are_round_numbers_within() {
        assert_eq!(
            texts(0.0, 10.0, 5, Scale::Plain),
            ["0", "2", "4", "6", "8", "10"]
        );
        assert_eq!(
            texts(0.13, 0.52, 4, Scale::Plain),
            ["0.2", "0.3", "0.4", "0.5"]
        );
        assert_eq!(
            texts(0.0, 1.9, 4, Scale::Plain),
            ["0.0", "0.5", "1.0", "1.5"]
        );
        assert_eq!(
            texts(0.0, 123_456.0, 3, Scale::Plain),
            ["0", "50000", "100000"]
        );
        assert_eq!(texts(-3.0, 3.0, 3, Scale::Plain), ["-2", "0", "2"]);
        assert_eq!(texts(-3.0, 3.0, 3, Scale::Mirrored), ["2", "0", "2"]);
        // A step of 5 lies beyond both ends.
        assert_eq!(
            texts(-4.9, 4.9, 2, Scale::Mirrored),
            ["4", "2", "0", "2", "4"]
        );
        assert_eq!(texts(0.13, 0.19, 1, Scale::Plain), ["0.15"]);
        assert_eq!(
            texts(2.0, 6.3, 9, Scale::Decades),
            ["100 us", "1 ms", "10 ms", "100 ms", "1 s"]
        );
        assert_eq!(
            texts(-0.4, 0.4, 6, Scale::Powers),
            ["0.4", "0.6", "1", "1.5", "2"]
        );
        assert_eq!(
            texts(-1.2, 0.4, 6, Scale::Powers),
            ["0.1", "0.2", "0.5", "1", "2"]
        );
        assert_eq!(
            texts(-2.0, 2.1, 6, Scale::Powers),
            ["0.01", "0.1", "1", "10", "100"]
        );
    }

    #[test]
    fn axes_without_extent_have_no_ticks() {
        for (from, to) in [
            (1.0, 1.0),
            (2.0, 1.0),
            (f64::NAN, 1.0),
            (0.0, f64::INFINITY),
        ] {
            assert!(texts(from, to, 5, Scale::Plain).is_empty());
        }
    }
}
