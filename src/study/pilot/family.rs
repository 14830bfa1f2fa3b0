//! A family: models of one sensor that a pilot can run on tiles, from the full one down.

use std::fmt::Debug;

use crate::{
    mosaic::{Mosaic, Outside},
    plane::Size,
    sensor::{Sensor, SensorError},
};

use super::{estimate::Unseen, look::Look};

/// The models of a sensor.
pub trait Family: Sync {
    /// One of them.
    type Model: Clone + PartialEq + Debug + Send + Sync;

    /// The one that all others are measured against.
    fn full(&self) -> Self::Model;

    /// How far the pixels lie that a cell's events can depend on, an even number.
    ///
    /// # Errors
    /// Why there is no such distance: the events of a tile are not those of the whole sensor, and
    /// nothing is measured.
    fn halo(&self) -> Result<usize, &'static str>;

    /// What lies off the sensor.
    fn outside(&self) -> Outside {
        Outside::Nearest
    }

    /// Whether a change of light counts for what it is of the light.
    fn is_relative(&self) -> bool {
        false
    }

    /// Whether cells that see nothing change may fire.
    fn fires_alone(&self) -> bool;

    /// Whether a model sees the frames that are inserted between those of the scene.
    fn sees_inserted(&self, model: &Self::Model) -> bool;

    /// A model on tiles, as a sensor that watches mosaics.
    ///
    /// # Errors
    /// When it cannot be made.
    fn on_tiles(
        &self,
        model: &Self::Model,
        mosaic: &Mosaic,
    ) -> Result<Box<dyn Sensor + Send>, SensorError>;

    /// How large a change may be that the sample did not show.
    fn unseen(&self, model: &Self::Model, look: &Look) -> Unseen;

    /// What several models leave out, together; none where that is no model.
    fn together(&self, models: &[Self::Model]) -> Option<Self::Model>;

    /// A model on the whole sensor.
    ///
    /// # Errors
    /// When it cannot be made.
    fn whole(&self, model: &Self::Model, size: Size)
    -> Result<Box<dyn Sensor + Send>, SensorError>;

    /// A model on the whole sensor, where that is to tell what it costs: a few frames of it, since
    /// tiles cost more than their share. None where they do not.
    fn on_the_whole(
        &self,
        _model: &Self::Model,
        _size: Size,
    ) -> Option<Result<Box<dyn Sensor + Send>, SensorError>> {
        None
    }

    /// Why tiles do not show which events of the whole sensor are read, where they do not.
    fn loses(&self, _size: Size) -> Option<&'static str> {
        None
    }

    /// Into how many parts a sensor of this size is cut for several threads.
    fn parts(&self, size: Size) -> usize;
}
