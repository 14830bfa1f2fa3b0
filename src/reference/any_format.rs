//! The sensor in a number format that is known only when the program runs.
//!
//! Compiled here, once for each format: what goes through this door, as the command line and the
//! Python package do, does not compile the model again.

use super::{
    counts::Counts, description::Description, firing::Firing, list::EventList, report::Report,
    sensor::Reference, tally::Tally, voxel::VoxelGrid,
};
use crate::{
    mosaic::Mosaic,
    number::{Format, Number, Visitor},
    plane::Size,
    scene::Frame,
    sensor::{Sensor, SensorError},
};

/// Where the trains of a frame pair go: to each that is there.
#[derive(Debug, Default)]
pub struct Sinks<'a, 'p> {
    /// Events of each kind.
    pub tally: Option<&'a mut Tally>,
    /// Cells that fire.
    pub firing: Option<&'a mut Firing>,
    /// The events themselves.
    pub list: Option<&'a mut EventList<'p>>,
    /// Signed counts of each cell.
    pub counts: Option<&'a mut Counts>,
    /// Shares of the two frames' bins.
    pub voxels: Option<&'a mut VoxelGrid>,
}

/// A [`Reference`] in some number format.
pub trait AnyReference: Sensor + Send {
    /// Watches one frame, as [`Reference::watch_into`].
    ///
    /// # Errors
    /// As there.
    fn watch_into_sinks(&mut self, frame: &Frame, sinks: Sinks<'_, '_>) -> Result<(), SensorError>;

    /// What it has to say of the run, as [`Reference::report`].
    fn report(&self) -> Report;
}

impl<N: Number> AnyReference for Reference<N> {
    fn watch_into_sinks(&mut self, frame: &Frame, sinks: Sinks<'_, '_>) -> Result<(), SensorError> {
        let Sinks {
            tally,
            firing,
            list,
            counts,
            voxels,
        } = sinks;
        self.watch_into(frame, &mut (((tally, firing), list), (counts, voxels)))
    }

    fn report(&self) -> Report {
        Self::report(self)
    }
}

impl Reference {
    /// A sensor whose signals, weights and memory are held in this format.
    ///
    /// # Errors
    /// As [`Reference::new`].
    pub fn in_format(
        format: Format,
        description: Description,
        size: Size,
        seed: u64,
    ) -> Result<Box<dyn AnyReference>, SensorError> {
        struct Make(Description, Size, u64);
        impl Visitor for Make {
            type Output = Result<Box<dyn AnyReference>, SensorError>;
            fn visit<N: Number>(self, number: N) -> Self::Output {
                let made = Reference::with_number(number, self.0, self.1, self.2)?;
                Ok(Box::new(made))
            }
        }
        format.visit(Make(description, size, seed))
    }

    /// [`Reference::on_tiles`] in this format.
    ///
    /// # Errors
    /// As [`Reference::new`].
    pub fn on_tiles_in_format(
        format: Format,
        description: Description,
        mosaic: &Mosaic,
        seed: u64,
    ) -> Result<Box<dyn AnyReference>, SensorError> {
        struct Make<'a>(Description, &'a Mosaic, u64);
        impl Visitor for Make<'_> {
            type Output = Result<Box<dyn AnyReference>, SensorError>;
            fn visit<N: Number>(self, number: N) -> Self::Output {
                let made = Reference::on_tiles(number, self.0, self.1, self.2)?;
                Ok(Box::new(made))
            }
        }
        format.visit(Make(description, mosaic, seed))
    }

    /// [`Reference::bytes`] in this format.
    #[must_use]
    pub fn bytes_in(format: Format, description: &Description, size: Size) -> u128 {
        struct Bytes<'a>(&'a Description, Size);
        impl Visitor for Bytes<'_> {
            type Output = u128;
            fn visit<N: Number>(self, _: N) -> u128 {
                Reference::<N>::bytes(self.0, self.1)
            }
        }
        format.visit(Bytes(description, size))
    }
}
