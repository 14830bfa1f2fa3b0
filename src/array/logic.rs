//! One-bit words, row by row, 64 pixels at a time.

use std::ops::Range;

use super::{BitPlane, Propagation, State, band::Band, bits};
use crate::{
    isa::{Bit, Digital, Direction},
    plane::Size,
};

/// `words := [kept words or] any of the sources`, `own` excepted.
pub(super) fn any<C>(
    band: &Band<'_, C>,
    words: &mut [u64],
    rows: Range<usize>,
    sources: &[Bit],
    own: Bit,
    (kept, not): (bool, bool),
) {
    bits::or(words, [], kept, not);
    for bit in sources.iter().filter(|bit| **bit != own) {
        let other = &band.bits(*bit, false)[rows.clone()];
        // Not of all is not of each and of each.
        if not {
            bits::clear_where(words, other);
        } else {
            bits::or(words, [other], true, false);
        }
    }
    if not {
        bits::cut(words, band.layout.size.width);
    }
}

/// `target := [not] any source`.
pub(super) fn logic<C>(
    band: &mut Band<'_, C>,
    target: Digital,
    sources: &[Bit],
    not: bool,
    rows: Range<usize>,
) {
    let own = Bit::Register(target);
    let kept = sources.contains(&own);
    let words = band.row_words(rows.clone());
    let bits = band.take_bits(target);
    if target == band.layout.roles.propagated {
        // A row at a time, by way of a row of its own.
        let mut new = std::mem::take(&mut band.bits);
        for y in rows {
            let words = band.row_words(y..y + 1);
            let old = &mut bits[words.clone()];
            new.copy_from_slice(old);
            any(band, &mut new, words.clone(), sources, own, (kept, not));
            bits::assign_where(old, &new, &band.digital(band.layout.roles.mask)[words]);
        }
        band.bits = new;
    } else {
        any(
            band,
            &mut bits[words.clone()],
            words,
            sources,
            own,
            (kept, not),
        );
    }
    band.put_bits(target, bits);
}

/// Sets or clears registers; R12 only where R0 is 1.
pub(super) fn fill<C>(
    band: &mut Band<'_, C>,
    targets: &[Digital],
    value: bool,
    rows: Range<usize>,
) {
    let width = band.layout.size.width;
    let words = band.row_words(rows);
    let roles = band.layout.roles;
    // R12 first: it goes by R0 as it was before this word.
    if targets.contains(&roles.propagated) {
        let bits = band.take_bits(roles.propagated);
        let mask = &band.digital(roles.mask)[words.clone()];
        let old = &mut bits[words.clone()];
        if value {
            bits::or(old, [mask], true, false);
        } else {
            bits::clear_where(old, mask);
        }
        band.put_bits(roles.propagated, bits);
    }
    for target in targets.iter().filter(|target| **target != roles.propagated) {
        let bits = band.take_bits(*target);
        bits::fill(&mut bits[words.clone()], width, value);
        band.put_bits(*target, bits);
    }
}

/// `target := OR over the directions that are enabled in the reading pixel`.
pub(super) fn dnews<C>(
    band: &mut Band<'_, C>,
    target: Digital,
    source: Bit,
    boundary: bool,
    rows: Range<usize>,
) {
    let copied = source == Bit::Register(target);
    let mut new = std::mem::take(&mut band.bits);
    for y in rows {
        let words = band.row_words(y..y + 1);
        let Size { height, width } = band.layout.size;
        let source = band.bits(source, copied);
        new.fill(0);
        for direction in Direction::ALL {
            let to = y.wrapping_add_signed(direction.step().0);
            let there = (to < height).then(|| &source[band.row_words(to..to + 1)]);
            let enabled = &band.digital(band.layout.roles.enables(direction))[words.clone()];
            bits::or_seen(&mut new, there, direction, width, boundary, enabled);
        }
        let roles = band.layout.roles;
        let bits = band.take_bits(target);
        let old = &mut bits[words.clone()];
        if target == roles.propagated {
            bits::assign_where(old, &new, &band.digital(roles.mask)[words]);
        } else {
            old.copy_from_slice(&new);
        }
        band.put_bits(target, bits);
    }
    band.bits = new;
}

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
