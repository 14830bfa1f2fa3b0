//! The entry of a metric in the list of metrics, and the pair that it is measured on.

use std::{any::Any, any::TypeId, cell::RefCell, collections::HashMap, fmt};

use super::{Pair, bins::Bins, window::Redraws};
use crate::unit::Micros;

/// The parameter of a metric.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// None, or bins that all metrics share.
    None,
    /// A matching window.
    Window,
    /// A time constant of van Rossum's distance.
    TimeConstant,
    /// A shift that costs as much as an event added, in Victor and Purpura's distance.
    Shift,
}

/// The entry of a metric: what is said of it, and how it is measured; one or more in each metric's
/// file.
#[derive(Debug)]
pub struct Entry {
    /// Name in files, before the scale: letters, digits and `_`.
    pub key: &'static str,
    /// Name in tables, before the scale.
    pub title: &'static str,
    /// Its parameter.
    pub scale: Scale,
    /// Its name and description in studies, where they may ask for it.
    pub study: Option<(&'static str, &'static str)>,
    /// What it cannot see; empty when it sees where, when and which sign.
    pub blind_to: &'static str,
    /// A redraw of the reference scores worse than the reference, by more than chance.
    pub knows_a_redraw: bool,
    /// Whether its value is the same with the two packets exchanged.
    pub symmetric: bool,
    /// Its value at a scale, 0 where it has none; none where there is no value.
    pub value: fn(&Measured<'_>, Micros) -> Option<f64>,
}

/// A pair that is being measured. Intermediate results that several metrics share are computed once
/// and kept (a memo).
pub struct Measured<'a> {
    /// The pair.
    pub pair: &'a Pair,
    /// The bins of voxel grids.
    pub(super) bins: Bins,
    /// Redraws of its reference.
    pub(super) redraws: &'a Redraws,
    /// The memo, by type and scale.
    shared: RefCell<HashMap<(TypeId, Micros), Box<dyn Any>>>,
}

impl fmt::Debug for Measured<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { pair, bins, .. } = self;
        f.debug_struct("Measured")
            .field("pair", pair)
            .field("bins", bins)
            .finish_non_exhaustive()
    }
}

impl<'a> Measured<'a> {
    /// A pair to be measured, with its voxels in these bins; what scores by chance is told by
    /// redraws of its reference.
    #[must_use]
    pub fn new(pair: &'a Pair, bins: Bins, redraws: &'a Redraws) -> Self {
        Self {
            pair,
            bins,
            redraws,
            shared: RefCell::default(),
        }
    }

    /// An intermediate result of several metrics at a scale (0 where it has none), computed when it
    /// is first asked for. `T` is a type of those metrics alone, and is the key: so no metric is
    /// named here, and one more is a file of its own.
    pub fn shared<T: Any + Copy>(&self, scale: Micros, make: impl FnOnce() -> T) -> T {
        let key = (TypeId::of::<T>(), scale);
        let known = self
            .shared
            .borrow()
            .get(&key)
            .and_then(|it| it.downcast_ref().copied());
        known.unwrap_or_else(|| {
            let made = make();
            self.shared.borrow_mut().insert(key, Box::new(made));
            made
        })
    }
}
