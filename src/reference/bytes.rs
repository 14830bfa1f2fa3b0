//! The memory that a sensor will need, computed before it is made.

use crate::{number::Number, plane::Size};

use super::{Description, MemoryRule, PolarityRule, Reference};

/// Bytes of a cell of one sheet: its modes, those of the signal, three planes of a step, the
/// surround, and room to transform them in.
const SHEET: usize = 96;

impl<N: Number> Reference<N> {
    /// Bytes that a sensor of this size holds while it watches, without its events.
    #[must_use]
    pub fn bytes(description: &Description, size: Size) -> u128 {
        let (held, real) = (size_of::<N::Held>(), size_of::<N::Real>());
        let stepped = held + size_of::<i32>() + held;
        let memory = match description.memory {
            // The picture and its distance are there once.
            MemoryRule::RawSnap if description.shared => held,
            MemoryRule::RawSnap => 2 * held + held,
            MemoryRule::FilteredSnap => held,
            MemoryRule::FilteredStep => stepped,
            MemoryRule::AuthorsPixelStep => stepped + held,
        };
        let sign = match description.polarity {
            PolarityRule::Pixel => held,
            PolarityRule::Filtered => 0,
        };
        let rests = 8 * usize::from(description.refractory.us > 0.0);
        let leaks = real * usize::from(description.noise.leak_hz > 0.0);
        let channels = description.channels.iter().map(|channel| {
            let mismatch = channel.thresholds.iter().any(|t| t.sigma > 0.0);
            let thresholds = if mismatch { 4 * real + 8 } else { 0 };
            let sheets = channel.surrounds.as_ref().map_or(0, |s| s.sheets.len());
            memory + sign + rests + leaks + thresholds + SHEET * sheets
        });
        let low_pass = 40 * usize::from(description.noise.cutoff_hz > 0.0);
        let picture = if description.shared { 2 * held } else { 0 };
        let cell: usize = channels.sum::<usize>() + picture + held + low_pass;
        // Rims, and rows that are padded to whole cache lines.
        let padded = (size.height as u128 + 64) * (size.width as u128 + 128);
        padded * cell as u128
    }
}
