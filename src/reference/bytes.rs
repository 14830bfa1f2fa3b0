//! The memory that a sensor will need, computed before it is made, and what of it is its state.

use crate::{number::Number, plane::Size};

use super::{Description, MemoryRule, PolarityRule, Reference};

/// Bytes of a cell of one sheet: its modes, those of the signal, three planes of a step, the
/// surround, and room to transform them in.
const SHEET: usize = 96;

/// Bytes of a pixel of a low-pass: its state, the light and the signal of the frame before, and the
/// signals that are made of them.
const LOW_PASS: usize = 40;

/// Bytes of a pixel, of all its cells together, that must last from one frame to the next; what only a
/// report looks at is left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StateBytes {
    /// The memories; of a memory that steps its counts and the drive of the frame before, too.
    pub memory: usize,
    /// The pixel's signal when the cell last fired, where its sign is the pixel's own.
    pub sign: usize,
    /// When the cell last fired, under a refractory period.
    pub rest: usize,
    /// The state of the photoreceptor's low-pass.
    pub low_pass: usize,
    /// The states of the resistor sheets that take time to settle.
    pub sheets: usize,
}

impl StateBytes {
    /// Those of a sensor whose signals and memories take `held` bytes each.
    #[must_use]
    pub fn of(description: &Description, held: usize) -> Self {
        const COUNT: usize = size_of::<i32>();
        const REAL: usize = size_of::<f64>();
        let kinds = description.channels.len();
        let thresholds = || description.channels.iter().flat_map(|it| &it.thresholds);
        // ON and OFF steps are counted apart where they are of two sizes.
        let is_equal = thresholds().all(|it| it.on == it.off && it.sigma <= 0.0);
        let steps = if is_equal { COUNT } else { COUNT + REAL };
        let memory = match description.memory {
            MemoryRule::RawSnap if description.shared => held,
            MemoryRule::RawSnap | MemoryRule::FilteredSnap => kinds * held,
            MemoryRule::FilteredStep => kinds * (held + steps + held),
            MemoryRule::AuthorsPixelStep => kinds * (held + steps),
        };
        let sign = match (description.polarity, description.memory) {
            (PolarityRule::Pixel, MemoryRule::FilteredSnap) => kinds * held,
            // A memory of pixels is the signal itself, and one that steps has no such sign.
            (
                PolarityRule::Pixel,
                MemoryRule::RawSnap | MemoryRule::FilteredStep | MemoryRule::AuthorsPixelStep,
            )
            | (PolarityRule::Filtered, _) => 0,
        };
        let surrounds = description
            .channels
            .iter()
            .filter_map(|it| it.surrounds.as_ref());
        let sheets = surrounds.flat_map(|it| &it.sheets);
        Self {
            memory,
            sign,
            rest: kinds * REAL * usize::from(description.refractory.us > 0.0),
            low_pass: REAL * usize::from(description.noise.cutoff_hz > 0.0),
            sheets: REAL * sheets.filter(|it| it.tau > 0.0).count(),
        }
    }

    /// All of them.
    #[must_use]
    pub const fn sum(self) -> usize {
        let Self {
            memory,
            sign,
            rest,
            low_pass,
            sheets,
        } = self;
        memory + sign + rest + low_pass + sheets
    }
}

impl<N: Number> Reference<N> {
    /// Bytes that a sensor of this size holds while it watches, without its events.
    #[must_use]
    pub fn bytes(description: &Description, size: Size) -> u128 {
        let (held, real) = (size_of::<N::Held>(), size_of::<N::Real>());
        let kinds = description.channels.len();
        let StateBytes {
            memory,
            sign,
            rest,
            // Those that move are counted with all that is computed of them.
            low_pass: _,
            sheets: _,
        } = StateBytes::of(description, held);
        let beside = match description.memory {
            // A picture for the kernels, and each cell's distance from it at the frame before.
            MemoryRule::RawSnap if description.shared => held + kinds * held,
            MemoryRule::RawSnap | MemoryRule::AuthorsPixelStep => kinds * 2 * held,
            MemoryRule::FilteredSnap | MemoryRule::FilteredStep => 0,
        };
        let leaks = kinds * real * usize::from(description.noise.leak_hz > 0.0);
        let channels = description.channels.iter().map(|channel| {
            let mismatch = channel.thresholds.iter().any(|t| t.sigma > 0.0);
            let thresholds = if mismatch { 4 * real } else { 0 };
            let sheets = channel.surrounds.as_ref().map_or(0, |s| s.sheets.len());
            thresholds + SHEET * sheets
        });
        let low_pass = LOW_PASS * usize::from(description.noise.cutoff_hz > 0.0);
        let cells = memory + sign + rest + beside + leaks;
        let cell = cells + channels.sum::<usize>() + held + low_pass;
        // Rims, and rows that are padded to whole cache lines.
        let padded = (size.height as u128 + 64) * (size.width as u128 + 128);
        padded * cell as u128
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{event::Packet, number::F32, plane::Plane, scene::Frame, sensor::Sensor};

    /// What the cells of a sensor keep is what is said of them: by memory, sign, thresholds of one size
    /// or two, refractory period, kinds.
    #[test]
    fn cells_keep_what_is_said_of_them() {
        let size = Size::new(3, 5);
        let mut seen = Vec::new();
        for memory in [
            "raw-snap",
            "raw-snap\"\nshared = true #\"",
            "raw-snap\"\npolarity = \"pixel",
            "filtered-snap",
            "filtered-snap\"\npolarity = \"pixel",
            "filtered-step",
            "authors-pixel-step",
        ] {
            for (us, off, kinds) in [(0, 20, 1), (90, 20, 1), (0, 30, 1), (90, 30, 2)] {
                let authors = memory == "authors-pixel-step";
                let rule = if authors { "authors" } else { "dead-time" };
                let held = if authors { "memory-kernel = [[1]]" } else { "" };
                let kind = format!(
                    "\n[[channel]]\nkernel = [[1]]\n{held}\nthreshold = {{ on = 20, off = {off} }}"
                );
                let text = format!(
                    "response = \"identity\"\nmemory = \"{memory}\"\nrefractory = {{ us = {us}, rule = \"{rule}\" }}{}",
                    kind.repeat(kinds)
                );
                let none = |name: &str| Err(std::io::Error::other(name.to_owned()));
                let description = Description::parse("kept", &text, &none).unwrap();
                let mut sensor = Reference::with_number(F32, description.clone(), size, 0).unwrap();
                let frame = Frame {
                    index: 0,
                    seconds: 0.0,
                    light: Plane::from_elem(size.shape(), 1.0).into(),
                };
                let mut packet = Packet::new(size, kinds as u8);
                sensor.watch(&frame, &mut packet).unwrap();
                let state = StateBytes::of(&description, 4);
                assert_eq!(sensor.kept(), state.sum() * size.pixels(), "{text}");
                seen.push(state.sum());
            }
        }
        assert_eq!(seen[0..4], [4, 12, 4, 24]);
        // A pixel's own sign is another signal beside the memory of drives, and none beside pixels.
        assert_eq!(seen[4..8], [4, 12, 4, 20]);
        assert_eq!(seen[8..12], seen[0..4]);
        assert_eq!(seen[12..16], [4, 12, 4, 24]);
        assert_eq!(seen[16..20], [8, 16, 8, 32]);
        assert_eq!(seen[20..24], [12, 20, 20, 56]);
        assert_eq!(seen[24..28], [8, 16, 16, 48]);
    }
}
