//! One panel: a frame, the events of a moment, or how two packets differ in it.
//!
//! Panels have the sensor's size, a pixel each; [`enlarged`] makes small ones larger by a
//! whole number, so that a pixel stays a square.

use std::collections::HashMap;

use image::{Rgb, RgbImage};

use super::ink::{self, Ink};
use crate::{
    event::{Event, Polarity},
    plane::{Plane, Size},
};

/// Light as gray: `black` and below is black, `white` and above is white.
#[must_use]
pub fn frame(light: &Plane<f64>, black: f64, white: f64) -> RgbImage {
    let mut panel = blank(Size::of(light), ink::PAGE);
    let scale = if white > black {
        255.0 / (white - black)
    } else {
        0.0
    };
    for ((y, x), value) in light.indexed_iter() {
        // `as` saturates, and makes black of what is no number.
        let gray = ((value - black) * scale).round() as u8;
        set(&mut panel, x, y, Rgb([gray; 3]));
    }
    panel
}

/// A frame so pale that events stand out on it.
#[must_use]
pub fn pale(frame: &RgbImage) -> RgbImage {
    let mut panel = frame.clone();
    for pixel in panel.pixels_mut() {
        *pixel = Rgb(pixel.0.map(|v| 176 + v / 4));
    }
    panel
}

/// Events in ink on `ground`; a pixel with several events shows its last.
#[must_use]
pub fn events(ground: RgbImage, events: &[Event]) -> RgbImage {
    let mut panel = ground;
    for e in events {
        let ink = match e.polarity {
            Polarity::On => ink::ON,
            Polarity::Off => ink::OFF,
        };
        set(&mut panel, e.x.into(), e.y.into(), ink);
    }
    panel
}

/// How the events of one moment differ: counted by pixel, sign and kind, without regard to
/// their times within the moment.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Difference {
    /// Events that both have.
    pub matched: u64,
    /// Events that only the reference has.
    pub missing: u64,
    /// Events that only the other has.
    pub extra: u64,
    /// Pixel by pixel `(x, y)`: matched, missing, extra.
    pixels: HashMap<(u16, u16), [u64; 3]>,
}

impl Difference {
    /// Counts the events of one moment.
    #[must_use]
    pub fn new(reference: &[Event], other: &[Event]) -> Self {
        let mut cells: HashMap<_, [u64; 2]> = HashMap::new();
        for (side, events) in [reference, other].into_iter().enumerate() {
            for e in events {
                cells.entry((e.x, e.y, e.polarity, e.channel)).or_default()[side] += 1;
            }
        }
        let mut difference = Self::default();
        for ((x, y, _, _), [a, b]) in cells {
            let counts = [a.min(b), a.saturating_sub(b), b.saturating_sub(a)];
            difference.matched += counts[0];
            difference.missing += counts[1];
            difference.extra += counts[2];
            let pixel = difference.pixels.entry((x, y)).or_default();
            for (sum, count) in pixel.iter_mut().zip(counts) {
                *sum += count;
            }
        }
        difference
    }

    /// Draws it on an empty panel.
    #[must_use]
    pub fn panel(&self, size: Size) -> RgbImage {
        let mut panel = blank(size, ink::EMPTY);
        for ((x, y), counts) in &self.pixels {
            let ink = match counts {
                [_, 0, 0] => ink::MATCHED,
                [_, _, 0] => ink::MISSING,
                [_, 0, _] => ink::EXTRA,
                _ => ink::SWAPPED,
            };
            set(&mut panel, (*x).into(), (*y).into(), ink);
        }
        panel
    }
}

/// The weights of a kernel: ON's colour above 0, OFF's below, from pale to full at magnitude
/// `most`.
#[must_use]
pub fn weights(weights: &Plane<f64>, most: f64) -> RgbImage {
    let (height, width) = weights.dim();
    RgbImage::from_fn(width as u32, height as u32, |x, y| {
        let weight = weights[[y as usize, x as usize]];
        let full = if weight < 0.0 { ink::OFF } else { ink::ON };
        let part = if most > 0.0 {
            (weight.abs() / most).min(1.0)
        } else {
            0.0
        };
        let mixed =
            |empty: u8, full: u8| f64::from(empty) + part * (f64::from(full) - f64::from(empty));
        Rgb(std::array::from_fn(|i| {
            mixed(ink::EMPTY.0[i], full.0[i]).round() as u8
        }))
    })
}

/// Every pixel as a square of `times` by `times`.
#[must_use]
pub fn enlarged(panel: &RgbImage, times: u32) -> RgbImage {
    let (width, height) = panel.dimensions();
    RgbImage::from_fn(width * times, height * times, |x, y| {
        *panel.get_pixel(x / times, y / times)
    })
}

fn blank(size: Size, ink: Ink) -> RgbImage {
    RgbImage::from_pixel(size.width as u32, size.height as u32, ink)
}

/// Sets a pixel; places outside the panel are ignored.
fn set(panel: &mut RgbImage, x: usize, y: usize, ink: Ink) {
    if let Some(pixel) = panel.get_pixel_mut_checked(x as u32, y as u32) {
        *pixel = ink;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::unit::Micros;

    fn event(x: u16, polarity: Polarity) -> Event {
        Event {
            t: Micros(5),
            x,
            y: 0,
            polarity,
            channel: 0,
        }
    }

    #[test]
    fn each_difference_has_its_ink() {
        let (on, off) = (Polarity::On, Polarity::Off);
        let reference = [event(0, on), event(1, on), event(3, on), event(4, on)];
        let other = [
            event(0, on),
            event(2, off),
            event(3, off),
            event(4, on),
            event(4, on),
        ];
        let difference = Difference::new(&reference, &other);
        let Difference {
            matched,
            missing,
            extra,
            ..
        } = difference;
        assert_eq!((matched, missing, extra), (2, 2, 3));
        let panel = difference.panel(Size::new(1, 6));
        let inks: Vec<Ink> = panel.pixels().copied().collect();
        assert_eq!(
            inks,
            [
                ink::MATCHED,
                ink::MISSING,
                ink::EXTRA,
                ink::SWAPPED,
                ink::EXTRA,
                ink::EMPTY
            ]
        );
    }

    #[test]
    fn gray_runs_from_black_to_white() {
        let light = ndarray::arr2(&[[-1.0, 10.0, 20.0, 30.0, 99.0, f64::NAN]]);
        let panel = frame(&light, 10.0, 30.0);
        let grays: Vec<u8> = panel.pixels().map(|p| p.0[0]).collect();
        assert_eq!(grays, [0, 0, 128, 255, 255, 0]);
    }

    #[test]
    fn the_last_event_of_a_pixel_shows_and_none_off_the_panel() {
        let ground = blank(Size::new(1, 2), ink::PAGE);
        let seen = events(
            ground,
            &[
                event(0, Polarity::On),
                event(0, Polarity::Off),
                event(7, Polarity::On),
            ],
        );
        assert_eq!(
            seen.pixels().copied().collect::<Vec<_>>(),
            [ink::OFF, ink::PAGE]
        );
        assert_eq!(enlarged(&seen, 3).dimensions(), (6, 3));
        assert_eq!(*enlarged(&seen, 3).get_pixel(2, 2), ink::OFF);
    }
}
