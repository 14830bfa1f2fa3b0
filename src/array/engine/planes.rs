//! Where planes lie among those of a [`Slab`](super::slab::Slab): registers first.

use super::super::Layout;
use crate::isa::Bit;

/// The copy of an analogue register.
pub(super) fn copy(layout: &Layout) -> usize {
    layout.analog.into()
}

/// The photodiodes.
pub(super) fn light(layout: &Layout) -> usize {
    copy(layout) + 1
}

/// How many analogue planes there are.
pub(super) fn count(layout: &Layout) -> usize {
    light(layout) + 1
}

/// The copy of a one-bit register, among the planes of bits.
pub(super) fn bit_copy(layout: &Layout) -> usize {
    layout.digital.into()
}

/// FLAG, among the planes of bits.
pub(super) fn flag(layout: &Layout) -> usize {
    bit_copy(layout) + 1
}

/// A one-bit operand; `None` where words cannot write it.
pub(super) fn bit(layout: &Layout, bit: Bit) -> Option<usize> {
    match bit {
        Bit::Register(register) => Some(register.0.into()),
        Bit::Flag => Some(flag(layout)),
        Bit::Select | Bit::Rect => None,
    }
}
