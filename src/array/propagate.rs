//! One-bit registers of the whole array: written by the host, and spreading.

use std::ops::Range;

use super::{BitPlane, Propagation, State, bits};
use crate::{
    isa::{Digital, Direction},
    plane::Size,
};

/// Writes a one-bit register; R12 only where R0 is 1.
pub(super) fn write<C: Clone>(state: &mut State<C>, target: Digital, new: &BitPlane) {
    if target == state.layout.roles.propagated {
        let [mask, spreads] = mask_and_spreads(state);
        bits::assign_where(spreads.words_mut(), new.words(), mask.words());
    } else {
        let words = state.digital_mut(target).words_mut();
        words.copy_from_slice(new.words());
    }
}

/// R0 and R12, to read the one while the other is written.
fn mask_and_spreads<C>(state: &mut State<C>) -> [&mut BitPlane; 2] {
    let roles = state.layout.roles;
    let both = [roles.mask, roles.propagated].map(|register| usize::from(register.0));
    // The check before the run refuses a chip where they are one.
    state.digital.get_disjoint_mut(both).expect("two registers")
}

/// R12 spreads, from row to row until nothing changes or it has gone as far as it can.
pub(super) fn propagate<C: Clone>(state: &mut State<C>, how_far: Propagation, boundary: bool) {
    let steps = match how_far {
        Propagation::Settled => u32::MAX,
        Propagation::Steps(steps) => steps,
    };
    let Size { height, width } = state.layout.size;
    let roles = state.layout.roles;
    let enabled = Direction::ALL.map(|direction| state.digital(roles.enables(direction)).clone());
    let mut seen = BitPlane::zeros(state.layout.size);
    // Only what lies beside a row that changed can change.
    let mut active = 0..height;
    for _ in 0..steps {
        let [mask, spreads] = mask_and_spreads(state);
        for y in active.clone() {
            let new = seen.row_mut(y);
            new.fill(0);
            for (direction, enabled) in Direction::ALL.into_iter().zip(&enabled) {
                let to = y.wrapping_add_signed(direction.step().0);
                let there = (to < height).then(|| spreads.row(to));
                bits::or_seen(new, there, direction, width, boundary, enabled.row(y));
            }
        }
        let mut changed: Option<Range<usize>> = None;
        for y in active {
            let (new, mask) = (seen.row(y), mask.row(y));
            let mut any = 0;
            for ((word, new), mask) in spreads.row_mut(y).iter_mut().zip(new).zip(mask) {
                let more = new & mask & !*word;
                any |= more;
                *word |= more;
            }
            if any != 0 {
                changed.get_or_insert(y..y).end = y + 1;
            }
        }
        let Some(changed) = changed else { break };
        active = changed.start.saturating_sub(1)..(changed.end + 1).min(height);
    }
}
