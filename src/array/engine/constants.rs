//! What every part of the array needs besides its own rows.

use super::{super::State, runs::PIECE};

/// What every part of the array needs besides its own rows.
#[derive(Clone, Debug)]
pub(super) struct Constants<C> {
    /// The number of the first word since power-on.
    pub(super) first: u64,
    /// What lies off the array.
    pub(super) edge: C,
    /// That, and then what the global input held, one after the other, each so often as is
    /// worked on at once.
    pub(super) inputs: Vec<Vec<C>>,
}

impl<C: Clone + PartialEq> Constants<C> {
    /// For an array as it was switched on.
    pub(super) fn new(state: &State<C>) -> Self {
        let cells = PIECE.min(state.layout.size.pixels());
        Self {
            first: 0,
            edge: state.edge.clone(),
            inputs: vec![vec![state.edge.clone(); cells]],
        }
    }

    /// The global input holds this as the `k`th of a block.
    pub(super) fn set_input(&mut self, k: usize, cell: &C) {
        let cells = self.inputs[0].len();
        match self.inputs.get_mut(1 + k) {
            Some(input) if input.first() == Some(cell) => {}
            Some(input) => input.fill(cell.clone()),
            None => self.inputs.push(vec![cell.clone(); cells]),
        }
    }
}
