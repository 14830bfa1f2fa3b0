//! The light of the last exposure, and where the next is another.

// What is not inlined is not compiled for the wide vectors.
#![allow(clippy::inline_always)]

use multiversion::multiversion;

use super::{
    Domain, Settings, rows,
    tiles::{TILE, Tiles},
    window::Window,
};
use crate::{aligned::Aligned, plane::Size};

/// What fell on the photodiodes last, and what they hold of it.
#[derive(Clone, Debug)]
pub(super) struct Light<C> {
    size: Size,
    /// None before the first exposure.
    fell: Vec<f64>,
    cells: Aligned<C>,
    /// Whether no frame has seen it.
    unseen: bool,
}

impl<C: Clone> Light<C> {
    pub(super) fn new(size: Size) -> Self {
        Self {
            size,
            fell: Vec::new(),
            cells: Aligned::default(),
            unseen: false,
        }
    }

    /// What the photodiodes hold after the last exposure.
    pub(super) fn cells(&self) -> &[C] {
        &self.cells
    }

    pub(super) const fn is_unseen(&self) -> bool {
        self.unseen
    }

    /// A frame has seen it.
    pub(super) const fn see(&mut self) {
        self.unseen = false;
    }

    /// Another exposure; tiles in which it is not as the last was are marked.
    pub(super) fn fall<D: Domain<Cell = C>>(
        &mut self,
        domain: &D,
        settings: &Settings,
        light: &[f64],
        tiles: &mut Tiles,
    ) {
        self.unseen = true;
        if self.fell.len() == light.len() {
            let (fell, cells) = (&mut self.fell, &mut self.cells);
            fall(domain, settings, self.size.width, light, fell, cells, tiles);
            return;
        }
        self.fell = light.to_vec();
        let Settings {
            gain, reset_level, ..
        } = *settings;
        let level = domain.hold(reset_level);
        self.cells = Aligned::new(0, level, light.len());
        rows::expose(domain, reset_level, gain, light, &mut self.cells);
        tiles.mark_all();
    }
}

/// Brings the last light and its cells to the next, tile by tile where they are not the same.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn fall<D: Domain>(
    domain: &D,
    settings: &Settings,
    width: usize,
    light: &[f64],
    fell: &mut [f64],
    cells: &mut [D::Cell],
    tiles: &mut Tiles,
) {
    let mut differences = vec![[0; LANES]; width.div_ceil(TILE)];
    let bands = light.chunks(TILE * width);
    let bands = bands.zip(
        fell.chunks_mut(TILE * width)
            .zip(cells.chunks_mut(TILE * width)),
    );
    for (k, (light, (fell, cells))) in bands.enumerate() {
        differences.fill([0; LANES]);
        for (new, old) in light.chunks_exact(width).zip(fell.chunks_exact(width)) {
            differ(new, old, &mut differences);
        }
        let mut left = 0;
        // Tiles beside each other together.
        for run in differences.chunk_by(|one, other| changed(one) == changed(other)) {
            let columns = left * TILE..((left + run.len()) * TILE).min(width);
            left += run.len();
            if !changed(&run[0]) {
                continue;
            }
            let rows = fell
                .chunks_exact_mut(width)
                .zip(cells.chunks_exact_mut(width));
            for (new, (old, cells)) in light.chunks_exact(width).zip(rows) {
                let (new, cells) = (&new[columns.clone()], &mut cells[columns.clone()]);
                old[columns.clone()].copy_from_slice(new);
                domain.hold_row(settings.reset_level, settings.gain, new, cells);
            }
            let y = k * TILE..k * TILE + light.len() / width;
            for left in columns.clone().step_by(TILE) {
                let x = left..(left + TILE).min(columns.end);
                tiles.mark(Window { y: y.clone(), x });
            }
        }
    }
}

/// Bits that differ are gathered in so many words.
const LANES: usize = 4;

fn changed(differences: &[u64; LANES]) -> bool {
    differences.iter().any(|difference| *difference != 0)
}

/// Gathers the bits in which two rows differ, tile by tile.
#[inline(always)]
fn differ(new: &[f64], old: &[f64], differences: &mut [[u64; LANES]]) {
    let (new, new_last) = new.as_chunks::<TILE>();
    let (old, old_last) = old.as_chunks::<TILE>();
    for ((new, old), differences) in new.iter().zip(old).zip(&mut *differences) {
        for k in (0..TILE).step_by(LANES) {
            for lane in 0..LANES {
                differences[lane] |= new[k + lane].to_bits() ^ old[k + lane].to_bits();
            }
        }
    }
    if let Some([last, ..]) = differences.last_mut() {
        for (new, old) in new_last.iter().zip(old_last) {
            *last |= new.to_bits() ^ old.to_bits();
        }
    }
}
