//! Rows and columns of the array.

use std::ops::Range;

use crate::plane::Size;

/// Rows and columns of the array.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Window {
    pub(super) y: Range<usize>,
    pub(super) x: Range<usize>,
}

impl Window {
    /// All of them.
    pub(super) const fn whole(size: Size) -> Self {
        Self {
            y: 0..size.height,
            x: 0..size.width,
        }
    }

    /// By so many rows and columns on each side, as far as the array goes.
    pub(super) fn grown(&self, [rows, columns]: [usize; 2], size: Size) -> Self {
        let along = |range: &Range<usize>, by: usize, end: usize| {
            range.start.saturating_sub(by)..range.end.saturating_add(by).min(end)
        };
        Self {
            y: along(&self.y, rows, size.height),
            x: along(&self.x, columns, size.width),
        }
    }

    /// The smallest that holds both.
    pub(super) fn with(&self, other: &Self) -> Self {
        let along = |a: &Range<usize>, b: &Range<usize>| a.start.min(b.start)..a.end.max(b.end);
        Self {
            y: along(&self.y, &other.y),
            x: along(&self.x, &other.x),
        }
    }

    /// What its pixels depend on, in rows of a multiple of `step` pixels, or in whole ones.
    pub(super) fn outer(&self, reach: [usize; 2], step: usize, size: Size) -> Self {
        let Self { y, x } = self.grown(reach, size);
        let width = x.len().next_multiple_of(step).min(size.width);
        let left = x.start.min(size.width - width);
        Self {
            y,
            x: left..left + width,
        }
    }

    pub(super) fn size(&self) -> Size {
        Size::new(self.y.len(), self.x.len())
    }

    pub(super) fn pixels(&self) -> usize {
        self.y.len() * self.x.len()
    }
}
