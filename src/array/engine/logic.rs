//! One-bit words, row by row, 64 pixels at a time.

use std::ops::Range;

use super::super::bits;
use super::slab::Slab;
use crate::{
    isa::{Bit, Digital, Direction},
    plane::Size,
};

/// `words := [kept words or] any of the sources`, `own` excepted.
pub(super) fn any<C>(
    slab: &Slab<'_, C>,
    words: &mut [u64],
    rows: Range<usize>,
    sources: &[Bit],
    own: Bit,
    (kept, not): (bool, bool),
) {
    bits::or(words, [], kept, not);
    for bit in sources.iter().filter(|bit| **bit != own) {
        let other = &slab.bits(*bit, false)[rows.clone()];
        // Not of all is not of each and of each.
        if not {
            bits::clear_where(words, other);
        } else {
            bits::or(words, [other], true, false);
        }
    }
    if not {
        bits::cut(words, slab.layout.size.width);
    }
}

/// `target := [not] any source`.
pub(super) fn logic<C>(
    slab: &mut Slab<'_, C>,
    target: Digital,
    sources: &[Bit],
    not: bool,
    rows: Range<usize>,
) {
    let own = Bit::Register(target);
    let kept = sources.contains(&own);
    let words = slab.row_words(rows.clone());
    let bits = slab.take_bits(target);
    if target == slab.layout.roles.propagated {
        // A row at a time, by way of a row of its own.
        let mut new = std::mem::take(&mut slab.bits);
        for y in rows {
            let words = slab.row_words(y..y + 1);
            let old = &mut bits[words.clone()];
            new.copy_from_slice(old);
            any(slab, &mut new, words.clone(), sources, own, (kept, not));
            bits::assign_where(old, &new, &slab.digital(slab.layout.roles.mask)[words]);
        }
        slab.bits = new;
    } else {
        any(
            slab,
            &mut bits[words.clone()],
            words,
            sources,
            own,
            (kept, not),
        );
    }
    slab.put_bits(target, bits);
}

/// Sets or clears registers; R12 only where R0 is 1.
pub(super) fn fill<C>(
    slab: &mut Slab<'_, C>,
    targets: &[Digital],
    value: bool,
    rows: Range<usize>,
) {
    let width = slab.layout.size.width;
    let words = slab.row_words(rows);
    let roles = slab.layout.roles;
    // R12 first: it goes by R0 as it was before this word.
    if targets.contains(&roles.propagated) {
        let bits = slab.take_bits(roles.propagated);
        let mask = &slab.digital(roles.mask)[words.clone()];
        let old = &mut bits[words.clone()];
        if value {
            bits::or(old, [mask], true, false);
        } else {
            bits::clear_where(old, mask);
        }
        slab.put_bits(roles.propagated, bits);
    }
    for target in targets.iter().filter(|target| **target != roles.propagated) {
        let bits = slab.take_bits(*target);
        bits::fill(&mut bits[words.clone()], width, value);
        slab.put_bits(*target, bits);
    }
}

/// `target := OR over the directions that are enabled in the reading pixel`.
pub(super) fn dnews<C>(
    slab: &mut Slab<'_, C>,
    target: Digital,
    source: Bit,
    boundary: bool,
    rows: Range<usize>,
) {
    let copied = source == Bit::Register(target);
    let mut new = std::mem::take(&mut slab.bits);
    for y in rows {
        let words = slab.row_words(y..y + 1);
        let Size { height, width } = slab.layout.size;
        let source = slab.bits(source, copied);
        new.fill(0);
        for direction in Direction::ALL {
            let to = y.wrapping_add_signed(direction.step().0);
            let there = (to < height).then(|| &source[slab.row_words(to..to + 1)]);
            let enabled = &slab.digital(slab.layout.roles.enables(direction))[words.clone()];
            bits::or_seen(&mut new, there, direction, width, boundary, enabled);
        }
        let roles = slab.layout.roles;
        let bits = slab.take_bits(target);
        let old = &mut bits[words.clone()];
        if target == roles.propagated {
            bits::assign_where(old, &new, &slab.digital(roles.mask)[words]);
        } else {
            old.copy_from_slice(&new);
        }
        slab.put_bits(target, bits);
    }
    slab.bits = new;
}
