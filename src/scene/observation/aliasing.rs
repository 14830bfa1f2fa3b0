//! What a pattern cannot show as it is: it is finer than pixels, or faster than frames.

/// What a pattern draws finer than pixels or faster than frames, so that another pattern is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Alias {
    /// Blobs that are smaller than two pixels.
    Fine {
        /// Their size, pixels.
        grain: f64,
    },
    /// A texture that shrinks until a pixel has more of it than its centre shows.
    Shrunk {
        /// The exponent per second.
        growth: f64,
        /// How many pixels of the texture lie side by side in one at the end.
        pixels: f64,
    },
    /// Light that passes its middle at every frame, and so does not change.
    Still {
        /// Hertz.
        frequency: f64,
        /// Frames a second.
        fps: f64,
    },
    /// Light that goes up and down more often than every other frame.
    Fast {
        /// Hertz.
        frequency: f64,
        /// Frames a second.
        fps: f64,
    },
}
