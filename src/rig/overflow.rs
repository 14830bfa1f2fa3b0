//! Signals that a fixed-point format cannot hold.

use super::guard::Warning;
use crate::{number::Format, photoreceptor::Response, scene::Frame};

/// Counts the signals that a fixed-point format cannot hold.
#[derive(Clone, Debug)]
pub struct Overflow {
    /// The ends of the format.
    ends: Option<[f64; 2]>,
    format: Format,
    response: Response,
    at: u64,
    all: u64,
}

impl Overflow {
    /// Nothing seen yet of signals of this response, held in this format.
    #[must_use]
    pub fn new(format: Format, response: Response) -> Self {
        let ends = match format {
            Format::Fixed(fixed) => Some(fixed.ends()),
            _ => None,
        };
        Self {
            ends,
            format,
            response,
            at: 0,
            all: 0,
        }
    }

    /// Looks at a frame.
    pub fn see(&mut self, frame: &Frame) {
        let Some([low, high]) = self.ends else {
            return;
        };
        let beyond = |light: &f64| {
            let signal = self.response.apply(*light);
            signal.is_ok_and(|signal| signal < low || signal >= high)
        };
        self.all += frame.light.size().pixels() as u64;
        // More light is never less signal: nearly always both ends of the light are within.
        let ends = frame.light.extent();
        if ends.is_none_or(|(low, high)| !beyond(&low) && !beyond(&high)) {
            return;
        }
        self.at += frame.light.iter().filter(|light| beyond(light)).count() as u64;
    }

    /// That signals of this sensor lie at the end of its numbers, where some do.
    #[must_use]
    pub fn warning(&self, subject: &str) -> Option<Warning> {
        let place = format!("the signals, held in {}", self.format);
        let ends = self.ends.filter(|_| self.at > 0)?;
        let counted = (self.at, self.all);
        Some(Warning::saturation(subject, &place, counted, ends))
    }
}
