//! The part of an array that is left where all else never fires.

use crate::{
    mosaic::Mosaic,
    number::Format,
    plane::{At, Size},
    reference::{AnyReference, Description, Reference},
    scene::Frame,
    sensor::SensorError,
};

use super::plan::Crop;

/// Rows and columns of an array: its cells are those of the whole, in the same places.
#[derive(Clone, Debug)]
pub struct Part {
    /// Of one tile.
    mosaic: Mosaic,
    corner: At,
}

impl Part {
    /// These rows and columns.
    #[must_use]
    pub fn new(whole: Size, (rows, columns): &Crop) -> Self {
        let corner = At {
            y: rows.start,
            x: columns.start,
        };
        let tile = Size::new(rows.len(), columns.len());
        Self {
            mosaic: Mosaic::new(whole, tile, 0, vec![corner], 1),
            corner,
        }
    }

    /// Where its first cell is in the whole.
    #[must_use]
    pub const fn corner(&self) -> At {
        self.corner
    }

    /// The sensor of a part, or else of the whole.
    ///
    /// # Errors
    /// As [`Reference::in_format`].
    pub fn sensor(
        part: Option<&Self>,
        whole: Size,
        (format, description, seed): (Format, Description, u64),
    ) -> Result<Box<dyn AnyReference>, SensorError> {
        match part {
            Some(part) => Reference::on_tiles_in_format(format, description, &part.mosaic, seed),
            None => Reference::in_format(format, description, whole, seed),
        }
    }

    /// What of a frame it sees.
    #[must_use]
    pub fn of(&self, frame: &Frame) -> Frame {
        let Size { height, width } = self.mosaic.size();
        let At { y, x } = self.corner;
        let part = ndarray::s![y..y + height, x..x + width];
        let light = frame.light.slice(part).to_owned().into();
        Frame { light, ..*frame }
    }
}
