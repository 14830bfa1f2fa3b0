//! Rows of diffusion and of exposure, in vectors.

// What is not inlined is not compiled for the wide vectors.
#![allow(clippy::inline_always)]

use multiversion::multiversion;

use super::{
    super::{Place, RowOps, Share},
    runs::{Run, Runs, merge},
};

/// A row of the diffusion network.
pub(super) struct Links<'a, C> {
    /// What each pixel holds, and what its neighbours hold, in the order of the directions;
    /// beyond the border anything.
    pub(super) own: &'a [C],
    pub(super) beside: [&'a [C]; 4],
    /// Where the link to each neighbour conducts.
    pub(super) linked: [&'a [u64]; 4],
    /// A pixel's own cell against one link.
    pub(super) parts: i32,
}

/// Stores one step of diffusion along the row `place`, where FLAG is 1.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
pub(super) fn diffuse<D: RowOps>(
    domain: &D,
    links: &Links<'_, D::Cell>,
    flags: &[u64],
    place: Place,
    clip: bool,
    cells: &mut [D::Cell],
    block: &mut [D::Cell],
) {
    let share = Share {
        by: links.parts as u32,
        part: None,
    };
    let width = cells.len();
    let mut runs = Runs::new(flags, 0, width);
    while let Some(Run { from, to, all }) = runs.next() {
        let cells = &mut cells[from..to];
        let new = if all {
            &mut *cells
        } else {
            &mut block[..to - from]
        };
        for (i, cell) in (from..).zip(new) {
            let mut sum = domain.nothing();
            let mut own = links.parts;
            for (k, linked) in links.linked.iter().enumerate() {
                if linked[i / 64] >> (i % 64) & 1 == 1 {
                    // East and west are rows that begin one later or earlier.
                    let at = match k {
                        1 => (i + 1).min(width - 1),
                        3 => i.saturating_sub(1),
                        _ => i,
                    };
                    domain.add(&mut sum, &links.beside[k][at], 1);
                    own -= 1;
                }
            }
            domain.add(&mut sum, &links.own[i], own);
            let stored = domain.store(&sum, share, Place { x: i, ..place });
            *cell = domain.limited(stored, clip);
        }
        if !all {
            merge(domain, cells, &mut block[..to - from], runs.words());
        }
    }
}

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
