//! The state of a channel's cells after the first frame.

use std::ops::Range;

use crate::{
    number::{Number, Real},
    reference::{
        description::{MemoryRule, PolarityRule},
        drive::log_temporal,
        memory::{Memory, Stepped},
        noise::Noise,
        report::Report,
        sheets::{self, Sheets},
        signal::Padded,
    },
};

use super::{Cells, Plan, Scratch};
use crate::aligned::Aligned;

impl<N: Number> Cells<N> {
    pub(super) fn settle(
        plan: &Plan<N>,
        rows: &Range<usize>,
        (signal, most, sheets): (&Padded<N::Held>, f64, Option<&Sheets>),
        scratch: &mut Scratch<N>,
        report: &mut Report,
    ) -> Self {
        let (number, description) = (&plan.number, &plan.description);
        let (width, channels) = (scratch.drive.len(), plan.weights.len());
        let cells = rows.len() * channels * width;
        // A memory of pixels has no use for the first drive.
        let follows = !description.memory.holds_pixels();
        // The memory is what the cells see of the first frame, so that a still scene is silent.
        let mut filtered = Vec::with_capacity(cells);
        let mut pixels = Vec::with_capacity(cells);
        for (y, channel) in rows
            .clone()
            .flat_map(|y| (0..channels).map(move |k| (y, k)))
        {
            let Scratch { drive, parts, .. } = scratch;
            sheets::row(number, sheets, (channel, y), drive, |drive| {
                plan.weights[channel].row(number, signal, y, drive, parts);
            });
            if follows {
                let at = ((channel, y), (signal, most, sheets));
                report.overflowed += plan.overflowed(at.0, at.1, &scratch.drive);
            }
            if description.channels[channel].log_temporal {
                log_temporal(number, &mut scratch.drive, 0.0);
            }
            filtered.extend_from_slice(&scratch.drive);
            pixels.extend_from_slice(signal.inner(y));
        }
        let before = if description.memory.crosses_levels() {
            Aligned::from_slice(5, &filtered)
        } else {
            Aligned::default()
        };
        let noise = description.noise;
        // Channel, row and column.
        let at = |cell: usize| {
            let row = cell / width;
            (row % channels, rows.start + row / channels, cell % width)
        };
        let place = |cell: usize| {
            let (channel, y, x) = at(cell);
            plan.place(channel, y, x)
        };
        let on = |cell: usize| {
            let (channel, y, x) = at(cell);
            plan.thresholds[channel].row(y).0[x]
        };
        // Each cell has leaked for a random part of its first leak interval, so that the leak's
        // events do not come in step.
        if noise.leak_hz > 0.0 {
            for (cell, memory) in filtered.iter_mut().enumerate() {
                let fallen = N::Real::from_f64(Noise::leaked(place(cell))) * on(cell);
                *memory = number.hold_real(number.real(*memory) - fallen);
            }
        }
        let equal = plan.thresholds.iter().all(|thresholds| thresholds.equal);
        let memory = match description.memory {
            MemoryRule::RawSnap => Memory::RawSnap {
                pixels: if description.shared {
                    Vec::new()
                } else {
                    pixels
                },
                before: vec![N::ZERO; cells],
            },
            MemoryRule::FilteredSnap => Memory::FilteredSnap {
                filtered,
                pixels: (description.polarity == PolarityRule::Pixel).then_some(pixels),
            },
            MemoryRule::FilteredStep => Memory::FilteredStep(Stepped::new(&filtered, equal)),
            MemoryRule::AuthorsPixelStep => Memory::PixelStep(Stepped::new(&pixels, equal)),
        };
        let refractory = plan.refractory();
        // A cell that has never fired is not refractory.
        let fired = if refractory > 0.0 {
            vec![f64::NEG_INFINITY; cells]
        } else {
            Vec::new()
        };
        let leak = if noise.leak_hz > 0.0 {
            let leak = |cell| N::Real::from_f64(noise.leak(place(cell), on(cell).to_f64()));
            (0..cells).map(leak).collect()
        } else {
            Vec::new()
        };
        Self {
            memory,
            before,
            fired,
            leak,
        }
    }
}
