//! What a metric says of itself, and the pair that it is measured on.

use std::{any::Any, any::TypeId, cell::RefCell, collections::HashMap, fmt};

use super::{Pair, bins::Bins, window::Redraws};
use crate::unit::Micros;

/// What a metric is measured at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Nothing, or bins that all metrics share.
    None,
    /// A window of matches.
    Window,
    /// A time constant of van Rossum's distance.
    TimeConstant,
    /// A shift that costs as much as an event added, in Victor and Purpura's distance.
    Shift,
}

/// What there is to say of a metric, and how it is measured: one or more in each metric's file.
#[derive(Debug)]
pub struct Entry {
    /// Name in files, before the scale: letters, digits and `_`.
    pub key: &'static str,
    /// Name in tables, before the scale.
    pub title: &'static str,
    /// What it is measured at.
    pub scale: Scale,
    /// Its name in studies and what it is there, where they may ask for it.
    pub study: Option<(&'static str, &'static str)>,
    /// What it cannot see; empty when it sees where, when and which sign.
    pub blind_to: &'static str,
    /// A redraw of the reference scores worse than the reference, by more than chance.
    pub knows_a_redraw: bool,
    /// Its value is the same with the two packets exchanged.
    pub symmetric: bool,
    /// Its value at a scale, 0 where it has none; none where there is no value.
    pub value: fn(&Measured<'_>, Micros) -> Option<f64>,
}

/// A pair that is being measured: what several metrics share is worked out once, when the first
/// asks for it.
pub struct Measured<'a> {
    /// The pair.
    pub pair: &'a Pair,
    /// The bins of voxel grids.
    pub(super) bins: Bins,
    /// Redraws of its reference.
    pub(super) redraws: &'a Redraws,
    /// What was worked out, by its type and scale.
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
    /// Of a pair, its voxels in these bins; what scores by accident is told by redraws of its
    /// reference.
    #[must_use]
    pub fn new(pair: &'a Pair, bins: Bins, redraws: &'a Redraws) -> Self {
        Self {
            pair,
            bins,
            redraws,
            shared: RefCell::default(),
        }
    }

    /// What several metrics are made of, at a scale (0 where it has none): made when it is first
    /// asked for. `T` is a type of those metrics alone, which stands for what is kept.
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
