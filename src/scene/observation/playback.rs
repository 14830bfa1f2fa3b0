//! How a player shows a clip that is shown otherwise here.

/// What a file says of how its pictures are shown, and what is not done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unlike {
    /// Its pixels are not square.
    Pixels {
        /// Their width, in parts of which `height` are their height.
        width: u32,
        /// Their height.
        height: u32,
    },
    /// Its pictures are turned by an angle that is no quarter of a turn, or sheared.
    Angle,
}

impl Unlike {
    /// Pixels of this shape, where it is known and no square.
    pub(in crate::scene) fn pixels(width: u32, height: u32) -> Option<Self> {
        let is_square = width == height || width == 0 || height == 0;
        (!is_square).then_some(Self::Pixels { width, height })
    }
}
