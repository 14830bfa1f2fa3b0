//! Scenes that are larger than a chip's array.

use crate::{
    isa::{Device, Figure},
    plane::Size,
};

/// A scene with more rows or columns than a chip has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("{scene} is {size}, and {chip} has {columns}x{rows} processors")]
#[diagnostic(help(
    "show a part of it or larger pixels (--crop {columns}x{rows}, --resize {columns}x{rows}), or take a chip with as many (--chip)"
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
