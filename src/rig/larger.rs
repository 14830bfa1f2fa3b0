//! Scenes that are larger than a chip's array.

use crate::{
    isa::{Device, Figure},
    plane::Size,
};

/// A scene with more rows or columns than a chip has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("{scene} is {size}, and {chip} has {columns}x{rows} processors")]
#[diagnostic(help(
    "crop the scene or reduce it to larger pixels (--crop {}, --resize {}), or take a chip with enough processors (--chip)",
    self.part(),
    self.shrunk()
))]
pub struct Larger {
    /// What the scene is called.
    pub scene: String,
    /// Its size, in pixels.
    pub size: Size,
    /// The name of the chip.
    pub chip: String,
    /// Rows of the chip's array.
    pub rows: u64,
    /// Columns of the chip's array.
    pub columns: u64,
}

impl Larger {
    /// The largest part of its pictures that the array takes.
    fn part(&self) -> Size {
        let least = |side: usize, most: u64| side.min(usize::try_from(most).unwrap_or(side));
        Size::new(
            least(self.size.height, self.rows),
            least(self.size.width, self.columns),
        )
    }

    /// The largest size of the same shape that the array takes, rounded to pixels.
    fn shrunk(&self) -> Size {
        let Size { height, width } = self.size;
        let part = self.part();
        // Whichever side is cut more says the scale.
        let scaled = |side: usize, (to, of): (usize, usize)| {
            let (side, to, of) = (side as u128, to as u128, of.max(1) as u128);
            usize::try_from((side * to + of / 2) / of).map_or(1, |side| side.max(1))
        };
        if (part.height as u128) * (width as u128) < (part.width as u128) * (height as u128) {
            Size::new(part.height, scaled(width, (part.height, height)))
        } else {
            Size::new(scaled(height, (part.width, width)), part.width)
        }
    }

    /// Refuses a scene of this size that is larger than the chip's array.
    ///
    /// # Errors
    /// When it is.
    pub fn check(scene: &str, size: Size, device: &Device) -> Result<(), Self> {
        // Sides are whole numbers.
        let [rows, columns] = [Figure::Height, Figure::Width].map(|of| device.value(of) as u64);
        if size.height as u64 <= rows && size.width as u64 <= columns {
            return Ok(());
        }
        Err(Self {
            scene: scene.to_owned(),
            size,
            chip: device.name().to_owned(),
            rows,
            columns,
        })
    }
}
