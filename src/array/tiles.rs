//! Squares of pixels, and which of them have changed.

use super::window::Window;
use crate::plane::Size;

/// Rows and columns of a tile.
pub(super) const TILE: usize = 16;

/// With more windows than this, all is one.
const WINDOWS: usize = 64;

/// All tiles of an array.
#[derive(Clone, Debug)]
pub(super) struct Tiles {
    size: Size,
    /// Row by row.
    changed: Vec<bool>,
}

impl Tiles {
    /// All of them have changed.
    pub(super) fn new(size: Size) -> Self {
        let tiles = size.height.div_ceil(TILE) * size.width.div_ceil(TILE);
        Self {
            size,
            changed: vec![true; tiles],
        }
    }

    /// Says the same of all.
    pub(super) fn fill(&mut self, changed: bool) {
        self.changed.fill(changed);
    }

    /// Those in which the pixels of a row lie, from the left.
    pub(super) fn row_mut(&mut self, y: usize) -> &mut [bool] {
        let across = self.size.width.div_ceil(TILE);
        &mut self.changed[y / TILE * across..][..across]
    }

    /// Rectangles that hold all pixels within `reach` of a changed tile. Each is worked on in a
    /// [copy](Window::outer) whose width is a multiple of `step`.
    pub(super) fn windows(&self, reach: [usize; 2], step: usize) -> Vec<Window> {
        let cost = |window: &Window| window.outer(reach, step, self.size).pixels();
        // One costs less than two.
        let joined = |one: &Window, other: &Window| {
            let both = one.with(other);
            (cost(&both) <= cost(one) + cost(other)).then_some(both)
        };
        let mut windows: Vec<Window> = Vec::new();
        'tiles: for (y, row) in (0..).zip(self.changed.chunks(self.size.width.div_ceil(TILE))) {
            let mut x = 0;
            for run in row.chunk_by(|one, other| one == other) {
                let from = x;
                x += run.len();
                if !run[0] {
                    continue;
                }
                let window = Window {
                    y: y * TILE..((y + 1) * TILE).min(self.size.height),
                    x: from * TILE..(x * TILE).min(self.size.width),
                }
                .grown(reach, self.size);
                let with = |other: &mut Window| joined(other, &window).map(|both| *other = both);
                if windows.iter_mut().find_map(with).is_none() {
                    windows.push(window);
                }
                if windows.len() > WINDOWS {
                    break 'tiles;
                }
            }
        }
        let mut k = 0;
        while k < windows.len() {
            let others = (0..windows.len()).filter(|other| *other != k);
            let with = |other: usize| Some((other, joined(&windows[other], &windows[k])?));
            match { others }.find_map(with) {
                Some((other, both)) => {
                    windows[other] = both;
                    windows.swap_remove(k);
                    k = 0;
                }
                None => k += 1,
            }
        }
        let all: usize = windows.iter().map(cost).sum();
        if windows.len() > WINDOWS || 2 * all > self.size.pixels() {
            return vec![Window::whole(self.size)];
        }
        windows
    }
}
