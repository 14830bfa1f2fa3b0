//! The colours, and why these.
//!
//! ON is blue and OFF is vermilion, as the field has it, in the shades of Okabe and Ito's
//! palette (<https://jfly.uni-koeln.de/color/>), which people with any kind of colour
//! blindness can tell apart. All that is neither event nor difference is gray.

use image::Rgb;

/// A colour.
pub type Ink = Rgb<u8>;

/// A colour as SVG and HTML have it: `#rrggbb`.
#[must_use]
pub fn hex(ink: Ink) -> String {
    let [r, g, b] = ink.0;
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// An ON event.
pub const ON: Ink = Rgb([0, 114, 178]);
/// An OFF event.
pub const OFF: Ink = Rgb([213, 94, 0]);
/// Both sensors have it.
pub const MATCHED: Ink = Rgb([190, 190, 190]);
/// The reference has it, the other has not.
pub const MISSING: Ink = Rgb([230, 60, 160]);
/// The other has it, the reference has not.
pub const EXTRA: Ink = Rgb([0, 120, 60]);
/// One missing and one extra at one pixel: of another sign or kind.
pub const SWAPPED: Ink = Rgb([20, 20, 20]);

/// Both sensors have it, at different times.
pub const MISTIMED: Ink = Rgb([240, 200, 60]);

/// What the causes of a waterfall take, in their order: the shades of the palette and of gray,
/// light and dark in turn, since no eleven inks are told apart by their hue.
pub const CAUSES: [Ink; 11] = [
    Rgb([86, 180, 233]),
    Rgb([0, 114, 178]),
    Rgb([0, 158, 115]),
    Rgb([150, 210, 190]),
    Rgb([240, 228, 66]),
    Rgb([20, 20, 20]),
    Rgb([230, 159, 0]),
    Rgb([213, 94, 0]),
    Rgb([204, 121, 167]),
    Rgb([120, 60, 20]),
    Rgb([100, 60, 150]),
];

/// All that are not gray.
pub const COLOURED: [Ink; 4] = [ON, OFF, MISSING, EXTRA];

/// Paper.
pub const PAGE: Ink = Rgb([255, 255, 255]);
/// Empty panels.
pub const EMPTY: Ink = Rgb([243, 243, 243]);
/// Bars that are neither ON nor OFF.
pub const BARS: Ink = Rgb([120, 120, 120]);
/// Lines behind a plot.
pub const GRID: Ink = Rgb([228, 228, 228]);
/// Headings.
pub const TEXT: Ink = Rgb([34, 34, 34]);
/// Captions.
pub const CAPTION: Ink = Rgb([96, 96, 96]);

#[cfg(test)]
mod tests {
    use super::*;

    /// What dichromats see, in linear RGB (Viénot, Brettel and Mollon 1999).
    const PROTAN: [[f64; 3]; 3] = [
        [0.109, 0.891, 0.0],
        [0.109, 0.891, 0.0],
        [0.0045, -0.0045, 1.0],
    ];
    const DEUTAN: [[f64; 3]; 3] = [
        [0.290, 0.710, 0.0],
        [0.290, 0.710, 0.0],
        [-0.022, 0.022, 1.0],
    ];

    fn seen(ink: Ink, by: [[f64; 3]; 3]) -> [f64; 3] {
        let linear = ink.0.map(|v| (f64::from(v) / 255.0).powf(2.2));
        by.map(|row| {
            let sum: f64 = row.iter().zip(linear).map(|(m, v)| m * v).sum();
            sum.clamp(0.0, 1.0).powf(1.0 / 2.2) * 255.0
        })
    }

    #[test]
    fn the_colour_blind_can_tell_the_inks_apart() {
        let together = [
            vec![ON, OFF, EMPTY],
            vec![MATCHED, MISSING, EXTRA, SWAPPED, MISTIMED, EMPTY],
        ];
        for eye in [PROTAN, DEUTAN] {
            for inks in &together {
                for (i, a) in inks.iter().enumerate() {
                    for b in &inks[i + 1..] {
                        let (a, b) = (seen(*a, eye), seen(*b, eye));
                        let far = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
                        assert!(far.sqrt() > 60.0, "{a:?} {b:?}");
                    }
                }
            }
        }
    }
}
