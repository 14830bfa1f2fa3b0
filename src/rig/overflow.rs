//! What a format with ends cannot hold of a run: signals, and the drives that they make.

use super::{
    guard::{About, Warning},
    saturation::{from_to, share},
};
use crate::{number::Format, photoreceptor::Response, scene::Frame, sensor::Overflowed};

/// Counts the signals that a format with ends cannot hold.
#[derive(Clone, Debug)]
pub struct Overflow {
    format: Format,
    response: Response,
    signals: Overflowed,
}

impl Overflow {
    /// Nothing seen yet of signals of this response, held in this format.
    #[must_use]
    pub const fn new(format: Format, response: Response) -> Self {
        Self {
            format,
            response,
            signals: Overflowed { at: 0, of: 0 },
        }
    }

    /// Looks at a frame.
    pub fn see(&mut self, frame: &Frame) {
        let Some([low, high]) = self.format.ends() else {
            return;
        };
        let beyond = |light: &f64| {
            let signal = self.response.apply(*light);
            signal.is_ok_and(|signal| signal < low || signal >= high)
        };
        self.signals.of += frame.light.size().pixels() as u64;
        // More light is never less signal: nearly always both ends of the light are within.
        let ends = frame.light.extent();
        if ends.is_none_or(|(low, high)| !beyond(&low) && !beyond(&high)) {
            return;
        }
        self.signals.at += frame.light.iter().filter(|light| beyond(light)).count() as u64;
    }

    /// That signals of this sensor lie at the end of its numbers, or drives beyond it, where some do.
    #[must_use]
    pub fn warning(&self, subject: &str, drives: Overflowed) -> Option<Warning> {
        let format = self.format;
        format.ends()?;
        let (low, high) = format.limits();
        let ends = from_to([low, high]);
        let signals = self.signals;
        let becomes = if format.wraps() {
            "wrap around"
        } else {
            "are clipped"
        };
        let why = format!("values beyond it {becomes}");
        let of_signals = (signals.at > 0).then(|| {
            let counted = share("value", (signals.at, signals.of));
            format!("{counted} in the signals lie at the end of the range of {format}, {ends}")
        });
        let of_drives = (drives.at > 0).then(|| {
            let counted = share("value", (drives.at, drives.of));
            format!(
                "{counted} of the drives (kernel times signal) and their differences from the memory leave the range of {format}, {ends}"
            )
        });
        let (seen, change) = match (of_signals, of_drives) {
            (Some(signals), None) => (signals, "reduce light or gain, or use a wider format"),
            (None, Some(drives)) => (
                drives,
                "use more bits before the point, or scale thresholds down together with the weights (gain) or with the response",
            ),
            (Some(signals), Some(drives)) => (
                format!("{signals}; {drives}"),
                "use more bits before the point, or scale response, weights and thresholds down together",
            ),
            (None, None) => return None,
        };
        Some(Warning::new(About::Saturation, subject, seen, why, change))
    }
}
