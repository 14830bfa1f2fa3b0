//! Clips that are made once.

use std::sync::{Arc, OnceLock};

use amacrine::rng::Hash;
use ndarray::Array3;

use super::clip::{Clip, Flow};

/// So many different clips, each made when it is first asked for.
#[derive(Debug)]
pub(super) struct Kept {
    pub(super) places: Vec<OnceLock<Whole>>,
    /// Whether their flow is kept.
    pub(super) flow: bool,
}

/// A clip whose light is as it is: whole, 0 to 255.
#[derive(Debug)]
pub(super) struct Whole {
    light: Box<[u8]>,
    flow: Option<Flow>,
    name: Arc<str>,
}

/// Bytes of the place of a clip that is kept, before it is made.
pub const PLACE: usize = size_of::<OnceLock<Whole>>();

impl Kept {
    pub(super) fn new(different: u64, flow: bool) -> Self {
        Self {
            places: (0..different).map(|_| OnceLock::new()).collect(),
            flow,
        }
    }

    /// The clip that a hash draws, of shape (frames, rows, columns).
    pub(super) fn clip(
        &self,
        draw: Hash,
        shape: (usize, usize, usize),
        make: impl FnOnce(u64) -> Clip,
    ) -> Clip {
        let number = draw.bits() % self.places.len() as u64;
        let whole = self.places[number as usize].get_or_init(|| {
            let clip = make(number);
            Whole {
                light: clip.light.iter().map(|light| *light as u8).collect(),
                flow: clip.flow.filter(|_| self.flow),
                name: clip.name,
            }
        });
        let light = |(frame, y, x): (usize, usize, usize)| {
            f32::from(whole.light[(frame * shape.1 + y) * shape.2 + x])
        };
        Clip {
            light: Array3::from_shape_fn(shape, light),
            flow: whole.flow.clone(),
            name: Arc::clone(&whole.name),
        }
    }
}
