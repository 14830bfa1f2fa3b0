//! What registers hold, in few bytes.
//!
//! A plane of numbers becomes whole numbers of `1 / parts` LSB. The twin is told as the difference
//! of each pixel from its left neighbour, the chip as its difference from the twin, the chip
//! without noise as its difference from the chip: small numbers. Each difference is folded to a
//! natural number (0, -1, 1, -2, … to 0, 1, 2, 3, …) and told in four bytes, all first bytes of a
//! plane first. Bits are told eight in a byte. `page.js` reads it.

use std::io::{self, Write as _};

use flate2::{Compression, write::DeflateEncoder};

use super::{Trace, TraceVersion};
use crate::plane::Size;

/// All planes of a trace, after the description of its steps.
pub(super) fn pack(trace: &Trace, description: &str, parts: f64) -> io::Result<Vec<u8>> {
    let mut packed = DeflateEncoder::new(Vec::new(), Compression::default());
    let length = description.len() as u32;
    packed.write_all(&length.to_le_bytes())?;
    packed.write_all(description.as_bytes())?;
    for version in trace.steps.iter().flat_map(|step| &step.written) {
        let is_bit = trace
            .registers
            .get(version.register)
            .is_some_and(|register| register.is_bit);
        if is_bit {
            let planes = [
                Some(&version.twin),
                Some(&version.chip),
                version.quiet.as_ref(),
            ];
            for plane in planes.into_iter().flatten() {
                packed.write_all(&bits(plane))?;
            }
        } else {
            for plane in differences(version, trace.shown(), parts) {
                for byte in 0..4 {
                    let bytes: Vec<u8> = plane.iter().map(|it| (it >> (8 * byte)) as u8).collect();
                    packed.write_all(&bytes)?;
                }
            }
        }
    }
    packed.finish()
}

fn bits(plane: &[f64]) -> Vec<u8> {
    let byte = |bits: &[f64]| {
        let set = (0..).zip(bits).filter(|(_, bit)| **bit != 0.0);
        set.fold(0, |byte, (i, _): (u32, _)| byte | 1 << i)
    };
    plane.chunks(8).map(byte).collect()
}

fn differences(version: &TraceVersion, size: Size, parts: f64) -> Vec<Vec<u32>> {
    // `as` saturates, which is what is meant.
    let whole = |plane: &[f64]| -> Vec<i32> {
        plane
            .iter()
            .map(|value| (value * parts).round() as i32)
            .collect()
    };
    let folded = |a: i32, b: i32| {
        let apart = a.wrapping_sub(b);
        (apart << 1 ^ apart >> 31) as u32
    };
    let (twin, chip) = (whole(&version.twin), whole(&version.chip));
    let left = |i: usize| match (i % size.width.max(1), i) {
        (_, 0) => 0,
        (0, i) => twin[i - size.width],
        (_, i) => twin[i - 1],
    };
    let mut planes = vec![
        (0..twin.len()).map(|i| folded(twin[i], left(i))).collect(),
        chip.iter()
            .zip(&twin)
            .map(|(a, b)| folded(*a, *b))
            .collect(),
    ];
    if let Some(quiet) = version.quiet.as_deref().map(whole) {
        planes.push(
            quiet
                .iter()
                .zip(&chip)
                .map(|(a, b)| folded(*a, *b))
                .collect(),
        );
    }
    planes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_folded_and_small() {
        let version = TraceVersion {
            register: 0,
            twin: vec![1.0, 1.5, 0.0, 2.0],
            chip: vec![1.0, 1.0, 0.25, 2.0],
            quiet: None,
        };
        let planes = differences(&version, Size::new(2, 2), 4.0);
        assert_eq!(planes[0], [8, 4, 7, 16]);
        assert_eq!(planes[1], [0, 3, 2, 0]);
        assert_eq!(bits(&[1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]), [5, 1]);
    }
}
