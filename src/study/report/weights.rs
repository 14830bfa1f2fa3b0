//! A kernel as a picture: a square a weight, coloured by sign and size, with its number in a power
//! of ten that gives it room.

use maud::{Markup, html};

use image::Rgb;

use super::number::minus;
use crate::{
    elementary,
    picture::{ink, ink::Ink, panel},
    plane::Plane,
    unit::fixed,
};

/// Side of a square, and the largest kernel whose squares have room for a number.
const SQUARE: usize = 44;
const NUMBERED: usize = 9;

/// The most letters that a square has room for, a sign and a point among them.
const LETTERS: usize = 5;

/// Weights times a scale, in colours that are full at `most`; the numbers are parts of
/// [`told_in`] `most`.
pub(super) fn picture(weights: &[Vec<f64>], scale: f64, most: f64, alt: &str) -> Markup {
    let (height, width) = (weights.len(), weights.first().map_or(0, Vec::len));
    let at = |y: usize, x: usize| weights.get(y).and_then(|row| row.get(x)).copied();
    let plane = Plane::from_shape_fn((height, width), |(y, x)| scale * at(y, x).unwrap_or(0.0));
    let colours = panel::weights(&plane, most);
    let numbered = is_numbered(weights);
    let power = power(most);
    let size = format!("0 0 {} {}", width * SQUARE, height * SQUARE);
    html! {
        svg.kernel viewBox=(size) role="img" aria-label=(alt) {
            @for ((y, x), weight) in plane.indexed_iter() {
                @let colour = *colours.get_pixel(x as u32, y as u32);
                rect x=(x * SQUARE) y=(y * SQUARE) width=(SQUARE - 1) height=(SQUARE - 1) fill=(ink::hex(colour)) {}
                @if numbered {
                    text x=(x * SQUARE + SQUARE / 2) y=(y * SQUARE + SQUARE / 2 + 4) text-anchor="middle" fill=(ink::hex(readable(colour))) { (short(weight / tens(power))) }
                }
            }
        }
    }
}

/// Whether squares have their numbers.
fn is_numbered(weights: &[Vec<f64>]) -> bool {
    weights.len() <= NUMBERED && weights.iter().all(|row| row.len() <= NUMBERED)
}

/// What stands below such a picture where its numbers are not the weights themselves.
pub(super) fn told_in(weights: &[Vec<f64>], most: f64) -> Markup {
    let power = power(most);
    html! {
        @if power != 0 && is_numbered(weights) { ", in parts of 10" sup { (minus(&power.to_string())) } }
    }
}

/// The power of ten in which numbers up to `most` have three digits that count.
fn power(most: f64) -> i32 {
    if most == 0.0 || (0.5..100.0).contains(&most) {
        0
    } else {
        elementary::log10(most).floor() as i32
    }
}

fn tens(power: i32) -> f64 {
    elementary::pow(10.0, f64::from(power))
}

/// The largest weight in size.
pub(super) fn most(weights: &[Vec<f64>]) -> f64 {
    weights
        .iter()
        .flatten()
        .fold(0.0, |most, w| most.max(w.abs()))
}

/// Black or paper, whichever stands out more: one of the two has a contrast of 4.5 on any ground.
fn readable(ground: Ink) -> Ink {
    const BLACK: Ink = Rgb([0, 0, 0]);
    let over = |ink: Ink| contrast(ground, ink);
    if over(BLACK) >= over(ink::PAGE) {
        BLACK
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

/// Two digits behind the point, fewer where there is no room.
fn short(number: f64) -> String {
    let with = |decimals: usize| {
        let text = fixed(number, decimals);
        match text.split_once('.') {
            Some(_) => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
            None => text,
        }
    };
    let mut all = [2, 1, 0].into_iter().map(with);
    let fits = all.find(|text| text.len() <= LETTERS);
    minus(&fits.unwrap_or_else(|| with(0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stand_out_on_every_colour() {
        assert!((contrast(ink::PAGE, Rgb([0, 0, 0])) - 21.0).abs() < 1e-9);
        for step in 0..=20 {
            for sign in [-1.0, 1.0] {
                let weight = sign * f64::from(step) / 20.0;
                let ground = panel::weights(&Plane::from_elem((1, 1), weight), 1.0);
                let ground = *ground.get_pixel(0, 0);
                let ratio = contrast(ground, readable(ground));
                assert!(ratio >= 4.5, "{weight}: {ratio}");
            }
        }
    }

    #[test]
    fn numbers_have_three_digits_that_count_and_room() {
        let told = |most: f64, weight: f64| short(weight / tens(power(most)));
        for (most, weight, text) in [
            (5e-4, -1e-4, "\u{2212}1"),
            (0.1, -0.0069, "\u{2212}0.07"),
            (0.0128, -0.0037, "\u{2212}0.37"),
            (1000.25, -250.1, "\u{2212}0.25"),
            (1.05, 1.05, "1.05"),
            (62.5, -62.25, "\u{2212}62.2"),
            (99.96, -99.96, "\u{2212}100"),
            (31.0, 20.0, "20"),
            (1.0, -0.001, "0"),
            (0.0, 0.0, "0"),
        ] {
            assert_eq!(told(most, weight), text, "{weight} of {most}");
            assert!(text.chars().count() <= LETTERS);
        }
        let row = [vec![5e-4]];
        assert_eq!(
            told_in(&row, 5e-4).into_string(),
            ", in parts of 10<sup>\u{2212}4</sup>"
        );
        assert_eq!(told_in(&row, 2.0).into_string(), "");
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
