//! The photodiodes, set from light.

use multiversion::multiversion;

use super::super::RowOps;

/// Sets pixels from light, as one exposure does.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
pub(in crate::array) fn expose<D: RowOps>(
    domain: &D,
    reset_level: f64,
    gain: f64,
    light: &[f64],
    cells: &mut [D::Cell],
) {
    domain.hold_row(reset_level, gain, light, cells);
}
