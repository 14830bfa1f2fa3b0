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
    /// Of each, row by row, the smallest window that holds all pixels that have changed.
    changed: Vec<Option<Window>>,
}

impl Tiles {
    /// All of them have changed.
    pub(super) fn new(size: Size) -> Self {
        let tiles = size.height.div_ceil(TILE) * size.width.div_ceil(TILE);
        let mut all = Self {
            size,
            changed: vec![None; tiles],
        };
        all.mark_all();
        all
    }

    /// All have changed.
    pub(super) fn mark_all(&mut self) {
        let across = self.size.width.div_ceil(TILE);
        for (i, changed) in self.changed.iter_mut().enumerate() {
            let (y, x) = (i / across * TILE, i % across * TILE);
            *changed = Some(Window {
                y: y..(y + TILE).min(self.size.height),
                x: x..(x + TILE).min(self.size.width),
            });
        }
    }

    /// None has.
    pub(super) fn clear(&mut self) {
        self.changed.fill(None);
    }

    /// Pixels of one tile have changed.
    pub(super) fn mark(&mut self, window: Window) {
        let across = self.size.width.div_ceil(TILE);
        let tile = &mut self.changed[window.y.start / TILE * across + window.x.start / TILE];
        *tile = Some(match tile {
            Some(before) => before.with(&window),
            None => window,
        });
    }

    /// Rectangles that hold all pixels within `reach` of one that has changed. Each is worked on in a
    /// [copy](Window::outer) whose width is a multiple of `step`.
    pub(super) fn windows(&self, reach: [usize; 2], step: usize) -> Vec<Window> {
        let cost = |window: &Window| window.outer(reach, step, self.size).pixels();
        // One costs less than two.
        let joined = |one: &Window, other: &Window| {
            let both = one.with(other);
            (cost(&both) <= cost(one) + cost(other)).then_some(both)
        };
        let mut windows: Vec<Window> = Vec::new();
        for tile in self.changed.iter().flatten() {
            let window = tile.grown(reach, self.size);
            // The last is beside it, if any is.
            let with = |other: &mut Window| joined(other, &window).map(|both| *other = both);
            if windows.iter_mut().rev().find_map(with).is_none() {
                windows.push(window);
            }
            if windows.len() > WINDOWS {
                break;
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
