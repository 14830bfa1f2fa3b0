//! What a sensor, a program or a kernel is warned of.

use miette::Diagnostic as _;

use super::{About, Crowd, Warning};
use crate::{kernel::quantise::Erasure, rig::Larger, unit::counted};

impl Warning {
    /// A sensor that never fired; `frames` where they are known.
    #[must_use]
    pub fn no_events(subject: &str, frames: Option<u64>) -> Self {
        let lower = "lower the threshold, give light on the scale of the sensor (0 to 255; --scale for an array), use a memory that steps, halve less often on a chip, or show a scene that moves";
        let (seen, why, change) = match frames {
            Some(frames @ 0..=1) => (
                format!("no event at all in {}", counted(frames, "frame")),
                "events happen between frames, and there are not two",
                "show a scene of two frames at least",
            ),
            Some(frames) => (
                format!("no event at all in {}", counted(frames, "frame")),
                "what its cells see never moves by a threshold: the light is small against it, or it does not change",
                lower,
            ),
            None => (
                "no event at all".to_owned(),
                "nothing happens in this recording, or in this part of it",
                "give a recording, or a part of it, in which something does",
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
            "no light was given, and the program names none of its own",
            "give --image SCENE, a clip or a pattern such as pattern:disc",
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
            "the threshold is below what changes everywhere: noise, flicker, a cut, or a memory that fires again",
            "raise the threshold, give light on the scale of the sensor, use a memory that steps rather than snaps, or leave out the frames at which the whole picture changes",
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
            "a still scene fires: memory-kernel is not the kernel",
            format!(
                "the first distance is (W - W_m) * u, which light from 0 to 255 brings to {}, and a threshold is {}",
                shown(most),
                shown(threshold)
            ),
            "give memory-kernel the weights of kernel, or use memory = \"filtered-step\"; as it is, it does what the released code does",
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
                format!("the spread of its thresholds (sigma {sigma}) is more than a third of a threshold ({threshold})"),
                "a cell whose threshold would fall below a twentieth of that has a twentieth, and fires twenty times as often: such cells decide how many events there are",
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
                    "no threshold gives {asked} events per pixel and second: {nearest:.4} is the nearest"
                ),
                "many cells change by the same amount (few levels of light), and fire together or not at all",
                "take a rate that there is, give the threshold itself (--threshold), or show a scene of more levels",
            )
        })
    }

    /// What a kernel in few values has lost of its shape.
    #[must_use]
    pub fn erased(subject: &str, erasure: Erasure) -> Self {
        let (about, why, change) = match erasure {
            Erasure::Surround { .. } | Erasure::Sign { .. } => (
                About::Surround,
                "its weights are too small for so few values",
                "take more values (another --to)",
            ),
            Erasure::Lopsided { .. } => (
                About::Lopsided,
                "too few weights are left to keep the sum evenly",
                "take more values (another --to), or leave the sum free",
            ),
            Erasure::Clipped { .. } => (
                About::Clipped,
                "the scale of fixed point is 1, whatever the kernel's is",
                "take more bits before the point, or int-B, whose scale fits the kernel",
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
                "times of events are whole microseconds, and it is less than one: hardly any event is lost to it",
                "give microseconds, of which 1000 are a millisecond, or leave it out",
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
            format!("an array of {size}, and {chip} has {columns}x{rows} processors"),
            "no chip runs what is shown here, and times are those of the smaller array",
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
                format!("{kept:.2} is kept on the chip"),
                "most of its events are not what the kernels say, and it is the best that was found or taken",
                "give higher thresholds or a lower rate, other few values (--to), a longer search (--effort), or other kernels",
            )
        })
    }
}
