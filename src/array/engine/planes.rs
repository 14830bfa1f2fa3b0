//! Where planes lie among those of a [`Slab`](super::slab::Slab): registers first.

use super::super::Layout;

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

/// FLAG, among the planes of bits, behind the copy of a register.
pub(super) fn flag(layout: &Layout) -> usize {
    usize::from(layout.digital) + 1
}
