//! What a sensor, a program or a kernel is warned of.

use miette::Diagnostic as _;

use super::{About, Crowd, Warning};
use crate::{kernel::quantise::Erasure, rig::Larger, unit::counted};

impl Warning {
    /// A sensor that never fired; `frames` where they are known.
    #[must_use]
    pub fn no_events(subject: &str, frames: Option<u64>) -> Self {
        let lower = "lower the threshold, show a scene that moves, scale the light to 0 to 255 (--scale for an array), use a memory that steps, or on a chip halve less often";
        let (seen, why, change) = match frames {
            Some(frames @ 0..=1) => (
                format!("no event at all in {}", counted(frames, "frame")),
                "an event is a change between two frames",
                "show a scene of at least two frames",
            ),
            Some(frames) => (
                format!("no event at all in {}", counted(frames, "frame")),
                "the filtered signal never changes by a whole threshold: the light changes too little, or not at all",
                lower,
            ),
            None => (
                "no event at all".to_owned(),
                "this recording, or this part of it, is empty",
                "give a recording, or a part of one, that has events",
            ),
        };
        Self::new(About::NoEvents, subject, seen, why, change)
    }

    /// A program that never fired, since nobody gave it light.
    #[must_use]
    pub fn in_the_dark(subject: &str, frames: u64) -> Self {
        Self::new(
            About::NoEvents,
            subject,
            format!(
                "no event at all in {} of the dark",
                counted(frames, "frame")
            ),
            "no scene was given, and the program names none",
            "give --image SCENE: a clip, or a pattern such as pattern:disc",
        )
    }

    /// A sensor of which most cells fire in one frame.
    #[must_use]
    pub fn most_cells(subject: &str, crowd: &Crowd) -> Self {
        let share = 100.0 * crowd.most as f64 / crowd.cells as f64;
        // The first frame is what a memory begins with: cells fire in it only where there is none.
        let frames = crowd.frames - u64::from(crowd.first == 0 && crowd.frames > 1);
        let seen = format!(
            "{} of {} cells ({share:.0} %) fire in frame {}, and more than half in {} of {} frames",
            crowd.most, crowd.cells, crowd.frame, crowd.over, frames
        );
        Self::new(
            About::MostCells,
            subject,
            seen,
            "the threshold is lower than a change that all cells see: noise, flicker, a cut, or a memory that fires again",
            "raise the threshold, scale the light to what the sensor takes, use a memory that steps rather than snaps, or cut out the frames where the whole picture changes",
        )
    }

    /// A sensor whose memory is seen through another kernel than the light: how far off that first is,
    /// and the threshold that it reaches.
    #[must_use]
    pub fn still(subject: &str, [most, threshold]: [f64; 2]) -> Self {
        let shown = |number: f64| (number * 1e4).round() / 1e4;
        Self::new(
            About::Still,
            subject,
            "cells fire on a still scene: memory-kernel differs from kernel",
            format!(
                "the first comparison sees (W - W_m) * u, up to {} for light from 0 to 255, and the threshold is {}",
                shown(most),
                shown(threshold)
            ),
            "give memory-kernel the weights of kernel, or use memory = \"filtered-step\"; keep it to reproduce the released code",
        )
    }

    /// Thresholds whose standard deviation from cell to cell, `sigma`, is more than a third of the
    /// least threshold: some cells in a thousand are then at the floor of a threshold.
    #[must_use]
    pub fn spread(subject: &str, sigma: f64, threshold: f64) -> Option<Self> {
        (3.0 * sigma > threshold).then(|| {
            Self::new(
                About::Spread,
                subject,
                format!("threshold mismatch (sigma {sigma}) is more than a third of the threshold ({threshold})"),
                "some cells are clipped to the lowest threshold, a twentieth of it, fire twenty times as often and dominate the event count",
                "give a smaller sigma (in the sensor file, or run --sigma), or leave it out (--without mismatch)",
            )
        })
    }

    /// Events per pixel and second that were asked for, and those of the nearest threshold, where
    /// these are more than a tenth off.
    #[must_use]
    pub fn rate(subject: &str, asked: f64, nearest: f64) -> Option<Self> {
        ((nearest / asked - 1.0).abs() > 0.1).then(|| {
            Self::new(
                About::Rate,
                subject,
                format!(
                    "no threshold gives {asked} events per pixel and second; the nearest rate is {nearest:.4}"
                ),
                "the scene has few grey levels, so many cells change by the same amount and fire together or not at all",
                "ask for the nearest rate, give the threshold itself (--threshold), or show a scene with more grey levels",
            )
        })
    }

    /// What a kernel in few values has lost of its shape.
    #[must_use]
    pub fn erased(subject: &str, erasure: Erasure) -> Self {
        let (about, why, change) = match erasure {
            Erasure::Surround { .. } | Erasure::Sign { .. } => (
                About::Surround,
                "these weights are too small for so few levels",
                "use more levels (another --to)",
            ),
            Erasure::Lopsided { .. } => (
                About::Lopsided,
                "too few non-zero weights are left to meet the sum symmetrically",
                "use more levels (another --to), or leave the sum free",
            ),
            Erasure::Clipped { .. } => (
                About::Clipped,
                "fixed point has scale 1, which does not adapt to the kernel",
                "use more bits before the point, or int-B, whose scale fits the kernel",
            ),
        };
        Self::new(about, subject, erasure.to_string(), why, change)
    }

    /// Cells that are silent for less than a microsecond, the step of times of events: as where seconds
    /// are meant.
    #[must_use]
    pub fn refractory(subject: &str, us: f64) -> Option<Self> {
        (us > 0.0 && us < 1.0).then(|| {
            Self::new(
                About::Refractory,
                subject,
                format!("a refractory period of {us} us"),
                "it is shorter than the time resolution of 1 us, and suppresses hardly any event",
                "give the period in microseconds (1000 for 1 ms), or leave it out",
            )
        })
    }

    /// A program on an array that is larger than its chip's.
    #[must_use]
    pub fn larger(subject: &str, larger: &Larger) -> Self {
        let Larger {
            size,
            chip,
            rows,
            columns,
            ..
        } = larger;
        Self::new(
            About::Larger,
            subject,
            format!("an array of {size}, but {chip} has {columns}x{rows} processors"),
            "the run is larger than the chip, and times are those of the chip's own array",
            larger
                .help()
                .map_or_else(String::new, |help| help.to_string()),
        )
    }

    /// What is kept on the chip of a design that was taken, where it is less than `half`.
    #[must_use]
    pub fn kept(subject: &str, kept: f64, half: f64) -> Option<Self> {
        (kept < half).then(|| {
            Self::new(
                About::Kept,
                subject,
                format!("only {kept:.2} is kept on the chip"),
                "the chip loses more than half of what could be kept, and no better design was found or taken",
                "give higher thresholds or a lower rate, another quantiser (--to), a longer search (--effort), or other kernels",
            )
        })
    }
}
