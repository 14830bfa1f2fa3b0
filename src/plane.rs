//! Two-dimensional helpers over [`ndarray`].
//!
//! Image coordinates everywhere: x to the right, y down, (0, 0) top left, arrays indexed
//! `[y, x]`. The chip's own addresses exist only at the readout door.

use std::fmt;

/// A picture, or a register over the whole array; indexed `[y, x]`.
pub type Plane<T> = ndarray::Array2<T>;

/// Height and width of a plane, in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
pub struct Size {
    /// Rows.
    pub height: usize,
    /// Columns.
    pub width: usize,
}

impl Size {
    /// The longest side of a sensor: what the 16 bits of an event's address hold.
    pub const LONGEST_SIDE: usize = crate::limit::ARRAY_SIDE;

    /// The most pixels of a sensor, and of a frame that it watches: 4096 times 4096.
    pub const MOST_PIXELS: usize = crate::limit::PIXELS;

    /// Whether a sensor can have this size: at least one pixel, within [`Size::LONGEST_SIDE`]
    /// and [`Size::MOST_PIXELS`].
    #[must_use]
    pub const fn is_possible(self) -> bool {
        let Self { height, width } = self;
        let sides = height <= Self::LONGEST_SIDE && width <= Self::LONGEST_SIDE;
        height > 0 && width > 0 && sides && height * width <= Self::MOST_PIXELS
    }

    /// A size of `height` rows and `width` columns.
    #[must_use]
    pub const fn new(height: usize, width: usize) -> Self {
        Self { height, width }
    }

    /// Reads `346x260`, width first, as it is displayed; none where it is no size.
    #[must_use]
    pub fn read(text: &str) -> Option<Self> {
        let (width, height) = text.split_once('x')?;
        Some(Self::new(height.parse().ok()?, width.parse().ok()?))
    }

    /// The size of a plane.
    #[must_use]
    pub fn of<T>(plane: &Plane<T>) -> Self {
        let (height, width) = plane.dim();
        Self { height, width }
    }

    /// Number of pixels; the largest number there is where they are more.
    #[must_use]
    pub const fn pixels(self) -> usize {
        self.height.saturating_mul(self.width)
    }

    /// `(height, width)`, the shape that ndarray takes.
    #[must_use]
    pub const fn shape(self) -> (usize, usize) {
        (self.height, self.width)
    }
}

impl fmt::Display for Size {
    /// Width first, as cameras are named: `346x260`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.width, self.height)
    }
}

/// One pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct At {
    /// Row, counted down from the top.
    pub y: usize,
    /// Column, counted right from the left.
    pub x: usize,
}
