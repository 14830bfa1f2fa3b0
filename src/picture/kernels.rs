//! Kernels side by side, each below its name.

use image::{RgbImage, imageops};

use super::{
    ink::{PAGE, TEXT},
    panel,
    text::{Face, LINE, Weight, write},
};
use crate::plane::Plane;

/// Pixels of a weight.
const CELL: u32 = 24;
/// Pixels between panels.
const GAP: u32 = 12;

/// Each kernel below its name, all in the same colours: those of the largest weight of all.
#[must_use]
pub fn kernels(named: &[(String, &Plane<f64>)]) -> RgbImage {
    let weights = named.iter().flat_map(|(_, plane)| plane.iter());
    let most = weights.fold(0.0, |most: f64, w| most.max(w.abs()));
    let face = Face::new(Weight::Plain, 1);
    let panels: Vec<(&str, u32, RgbImage)> = { named.iter() }
        .map(|(name, plane)| {
            let panel = panel::enlarged(&panel::weights(plane, most), CELL);
            let width = panel.width().max(face.width(name));
            (name.as_str(), width, panel)
        })
        .collect();
    let height = { panels.iter().map(|(_, _, panel)| panel.height()) }
        .max()
        .unwrap_or(0);
    let width = GAP + panels.iter().map(|(_, width, _)| width + GAP).sum::<u32>();
    let mut page = RgbImage::from_pixel(width, height + LINE + 2 * GAP, PAGE);
    let mut left = GAP;
    for (name, width, panel) in &panels {
        write(&mut page, (left, GAP), name, Weight::Plain, TEXT);
        imageops::replace(&mut page, panel, left.into(), (GAP + LINE).into());
        left += width + GAP;
    }
    page
}
