//! The part of an array that is left where all else never fires.

use crate::{
    event::Event,
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

    /// Its rows and columns.
    #[must_use]
    pub fn size(&self) -> Size {
        self.mosaic.size()
    }

    /// Where its first cell is in the whole.
    #[must_use]
    pub const fn corner(&self) -> At {
        self.corner
    }

    /// The sensor of this part.
    ///
    /// # Errors
    /// As [`Reference::in_format`].
    pub fn sensor(
        &self,
        format: Format,
        description: Description,
        seed: u64,
    ) -> Result<Box<dyn AnyReference>, SensorError> {
        Reference::on_tiles_in_format(format, description, &self.mosaic, seed)
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

    /// Puts its events where they are in the whole.
    pub fn place(&self, events: &mut [Event]) {
        for event in events {
            event.x += self.corner.x as u16;
            event.y += self.corner.y as u16;
        }
    }
}
