//! A kernel as a picture: a square a weight, coloured by sign and size, with its number.

use maud::{Markup, html};

use crate::{
    elementary,
    picture::{ink, ink::Ink, panel},
    plane::Plane,
};

/// Side of a square, and the largest kernel whose squares have room for a number.
const SQUARE: usize = 44;
const NUMBERED: usize = 9;

/// Weights times a scale, in colours that are full at `most`.
pub(super) fn picture(weights: &[Vec<f64>], scale: f64, most: f64, alt: &str) -> Markup {
    let (height, width) = (weights.len(), weights.first().map_or(0, Vec::len));
    let at = |y: usize, x: usize| weights.get(y).and_then(|row| row.get(x)).copied();
    let plane = Plane::from_shape_fn((height, width), |(y, x)| scale * at(y, x).unwrap_or(0.0));
    let colours = panel::weights(&plane, most);
    let numbered = width <= NUMBERED && height <= NUMBERED;
    let size = format!("0 0 {} {}", width * SQUARE, height * SQUARE);
    html! {
        svg.kernel viewBox=(size) role="img" aria-label=(alt) {
            @for ((y, x), weight) in plane.indexed_iter() {
                @let colour = *colours.get_pixel(x as u32, y as u32);
                rect x=(x * SQUARE) y=(y * SQUARE) width=(SQUARE - 1) height=(SQUARE - 1) fill=(ink::hex(colour)) {}
                @if numbered {
                    text x=(x * SQUARE + SQUARE / 2) y=(y * SQUARE + SQUARE / 2 + 4) text-anchor="middle" fill=(ink::hex(readable(colour))) { (short(*weight)) }
                }
            }
        }
    }
}

/// The largest weight in size.
pub(super) fn most(weights: &[Vec<f64>]) -> f64 {
    weights
        .iter()
        .flatten()
        .fold(0.0, |most, w| most.max(w.abs()))
}

/// Ink or paper, whichever stands out more.
fn readable(ground: Ink) -> Ink {
    let over = |ink: Ink| contrast(ground, ink);
    if over(ink::TEXT) >= over(ink::PAGE) {
        ink::TEXT
    } else {
        ink::PAGE
    }
}

/// The contrast ratio of WCAG 2, from 1 to 21.
fn contrast(a: Ink, b: Ink) -> f64 {
    let luminance = |ink: Ink| {
        let [r, g, b] = ink.0.map(|v| {
            let v = f64::from(v) / 255.0;
            if v <= 0.040_45 {
                v / 12.92
            } else {
                elementary::pow((v + 0.055) / 1.055, 2.4)
            }
        });
        0.2126 * r + 0.7152 * g + 0.0722 * b
    };
    let (a, b) = (luminance(a), luminance(b));
    (a.max(b) + 0.05) / (a.min(b) + 0.05)
}

/// At most three digits behind the point.
fn short(weight: f64) -> String {
    let decimals = if weight.abs() < 10.0 { 2 } else { 1 };
    let text = format!("{weight:.decimals$}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    match text {
        "-0" => "0".to_owned(),
        text => text.replace('-', "\u{2212}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::Rgb;

    #[test]
    fn numbers_stand_out_on_every_colour() {
        assert!((contrast(ink::PAGE, Rgb([0, 0, 0])) - 21.0).abs() < 1e-9);
        for step in 0..=20 {
            for sign in [-1.0, 1.0] {
                let weight = sign * f64::from(step) / 20.0;
                let ground = panel::weights(&Plane::from_elem((1, 1), weight), 1.0);
                let ground = *ground.get_pixel(0, 0);
                let ratio = contrast(ground, readable(ground));
                assert!(ratio >= 4.0, "{weight}: {ratio}");
            }
        }
    }

    #[test]
    fn a_kernel_has_a_square_and_a_number_for_each_weight() {
        let kernel = vec![vec![-0.5, 1.0, 0.0]];
        let svg = picture(&kernel, 2.0, 2.0, "three").into_string();
        assert_eq!(svg.matches("<rect").count(), 3);
        assert!(svg.contains(">\u{2212}1</text>") && svg.contains(">2</text>"));
        assert!(svg.contains("#f3f3f3") && svg.contains("#0072b2"));
        assert_eq!(most(&kernel), 1.0);
    }
}
