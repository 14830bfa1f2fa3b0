//! Labels of dots: beside them, where they cover neither each other nor a dot.

use super::{Area, Drawing, Point};
use crate::{
    order::Order,
    picture::{ink, text::LINE},
};

/// Half the side of the square around a dot that labels keep free.
const HALF: f64 = 5.0;

/// A dot whose label stands further away is joined to it by a line.
const FAR: f64 = 12.0;

/// Steps to either side that are tried, and up and down, in half lines.
const STEPS: (i32, i32) = (8, 40);

/// Where the labels of `dots` stand, each so wide, inside the axes: the nearest free place, with
/// `others` in the way too.
pub fn labels(inside: Area, dots: &[(Point, f64)], others: &[Point]) -> Vec<Area> {
    let line = f64::from(LINE);
    let all = dots.iter().map(|(dot, _)| dot).chain(others);
    let squares: Vec<Area> = all.map(|dot| square(*dot)).collect();
    let (across, down) = STEPS;
    let mut steps: Vec<(f64, f64)> = (0..=across)
        .flat_map(|x| (-down..=down).map(move |y| (x, y)))
        .map(|(x, y)| (0.5 * line * f64::from(x), 0.5 * line * f64::from(y)))
        .collect();
    steps.order_by(|a, b| length(*a).total_cmp(&length(*b)));
    let mut taken: Vec<Area> = Vec::new();
    for (dot, width) in dots {
        let place = |x: f64, y: f64| Area {
            x,
            y,
            width: *width,
            height: line,
        };
        // Its foot is beside the dot.
        let first = dot.1 - line + 2.0;
        let (right, left) = (dot.0 + HALF + 2.0, dot.0 - HALF - 2.0 - width);
        let mut places = steps.iter().flat_map(|(x, y)| {
            let y = first + y;
            [place(right + x, y), place(left - x, y)]
        });
        let is_free = |place: &Area| {
            let is_inside = place.x >= inside.x
                && place.right() <= inside.right()
                && place.y >= inside.y
                && place.bottom() <= inside.bottom();
            is_inside
                && !taken.iter().any(|other| overlap(*place, *other))
                && !squares.iter().any(|dot| overlap(letters(*place), *dot))
        };
        let free = places.find(is_free);
        taken.push(free.unwrap_or_else(|| place(right, first)));
    }
    taken
}

/// Draws a line from a dot to its label, where that is not beside it.
pub fn leader(page: &mut Drawing, label: Area, dot: Point) {
    let ink = letters(label);
    let end = (
        dot.0.clamp(ink.x - 1.0, ink.right() + 1.0),
        dot.1.clamp(ink.y, ink.bottom()),
    );
    let (x, y) = (end.0 - dot.0, end.1 - dot.1);
    let far = length((x, y));
    if far > FAR {
        let rim = HALF / far;
        let begin = (rim.mul_add(x, dot.0), rim.mul_add(y, dot.1));
        page.line(begin, end, 0.75, ink::CAPTION);
    }
}

/// Of a line of text the upper and the lower pixels are empty.
pub fn letters(label: Area) -> Area {
    Area {
        y: label.y + 4.0,
        height: label.height - 8.0,
        ..label
    }
}

/// Whether two rectangles cover each other, or stand less than two points side by side.
pub fn overlap(a: Area, b: Area) -> bool {
    let is_beside = a.x >= b.right() + 2.0 || b.x >= a.right() + 2.0;
    !is_beside && a.y < b.bottom() && b.y < a.bottom()
}

fn square((x, y): Point) -> Area {
    Area {
        x: x - HALF,
        y: y - HALF,
        width: 2.0 * HALF,
        height: 2.0 * HALF,
    }
}

fn length((x, y): Point) -> f64 {
    x.mul_add(x, y * y).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_of_a_crowd_cover_nothing_and_stay_near() {
        let inside = Area {
            x: 0.0,
            y: 0.0,
            width: 600.0,
            height: 400.0,
        };
        let dots: Vec<(Point, f64)> = (0..14)
            .map(|n| ((10.0 + 3.0 * f64::from(n), 200.0), 16.0))
            .collect();
        let others: Vec<Point> = (0..6)
            .map(|n| (60.0, 150.0 + 20.0 * f64::from(n)))
            .collect();
        let places = labels(inside, &dots, &others);
        for (n, place) in places.iter().enumerate() {
            assert!(
                !places[..n].iter().any(|other| overlap(*place, *other)),
                "{places:?}"
            );
            let covered = { dots.iter() }
                .map(|(dot, _)| dot)
                .chain(&others)
                .filter(|dot| overlap(letters(*place), square(**dot)));
            assert_eq!(covered.count(), 0, "{n}: {places:?}");
            let (dot, _) = dots[n];
            assert!(
                (place.y - dot.1).abs() < 100.0 && place.x >= 0.0,
                "{n}: {places:?}"
            );
        }
        // What has no label stands in the way.
        let lone = [((100.0, 100.0), 8.0)];
        let free = labels(inside, &lone, &[])[0];
        assert_eq!((free.x, free.y), (107.0, 100.0 - f64::from(LINE) + 2.0));
        let pushed = labels(inside, &lone, &[(110.0, 92.0)])[0];
        assert!(pushed != free && pushed.right() < 100.0, "{pushed:?}");
    }
}
