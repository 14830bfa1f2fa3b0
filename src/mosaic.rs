//! Mosaics: some tiles of a plane, each with a halo of what lies round it, side by side in one
//! picture, so that one sensor sees them all.
//!
//! A cell of a mosaic knows its place in the whole plane. Random numbers are a hash of the place,
//! so a sensor that draws for the place gives the cells of a tile the chance that they have in the
//! whole sensor.

use crate::plane::{At, Plane, Size};

/// Some tiles of a plane as one picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mosaic {
    whole: Size,
    tile: Size,
    halo: usize,
    tiles: Vec<At>,
    across: usize,
}

/// What a mosaic shows of a halo that lies off the plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outside {
    /// The nearest pixel of the plane.
    Nearest,
    /// Nothing: 0.
    Dark,
}

impl Mosaic {
    /// Tiles of this size with their upper left corners at `tiles`, `across` of them in a row of
    /// the mosaic, each with a halo of so many pixels on all sides. A tile may reach beyond the
    /// end of the plane: what lies there is shown and not counted.
    #[must_use]
    pub fn new(whole: Size, tile: Size, halo: usize, tiles: Vec<At>, across: usize) -> Self {
        Self {
            across: across.clamp(1, tiles.len().max(1)),
            whole,
            tile,
            halo,
            tiles,
        }
    }

    /// The upper left corners of the tiles.
    #[must_use]
    pub fn tiles(&self) -> &[At] {
        &self.tiles
    }

    /// Size of the plane that the tiles are of.
    #[must_use]
    pub const fn whole(&self) -> Size {
        self.whole
    }

    /// Size of the picture.
    #[must_use]
    pub fn size(&self) -> Size {
        let Size { height, width } = self.block();
        Size::new(
            self.tiles.len().div_ceil(self.across) * height,
            self.across * width,
        )
    }

    /// Size of a tile with its halo.
    const fn block(&self) -> Size {
        Size::new(
            self.tile.height + 2 * self.halo,
            self.tile.width + 2 * self.halo,
        )
    }

    /// The number of the tile that a cell of the mosaic belongs to, and how far its place in the
    /// plane lies beyond the tile's upper left corner. What is left of the last row of the mosaic
    /// shows its last tile again.
    fn at(&self, y: usize, x: usize) -> (usize, isize, isize) {
        let block = self.block();
        // Tiles of no pixels have no cells: nobody asks for one of them, and if, it is a corner.
        let block = Size::new(block.height.max(1), block.width.max(1));
        let tile = y / block.height * self.across + x / block.width;
        let off = |at: usize, side: usize| (at % side).cast_signed() - self.halo.cast_signed();
        (tile, off(y, block.height), off(x, block.width))
    }

    /// The place of a cell of the mosaic in the plane; of what lies off it, the nearest.
    #[must_use]
    pub fn home(&self, y: usize, x: usize) -> At {
        let (y, x, _) = self.place(y, x);
        At { y, x }
    }

    /// The place of the plane that a cell of the mosaic shows, and whether it is its own: else it
    /// lies off the plane, and this is the nearest.
    #[must_use]
    pub fn shows(&self, y: usize, x: usize) -> (At, bool) {
        let (y, x, own) = self.place(y, x);
        (At { y, x }, own)
    }

    /// The nearest place in the plane, and whether it is the cell's own.
    fn place(&self, y: usize, x: usize) -> (usize, usize, bool) {
        let (tile, down, right) = self.at(y, x);
        let tile = self.tiles.get(tile).or(self.tiles.last());
        let corner = tile.copied().unwrap_or(At { y: 0, x: 0 });
        let inside = |corner: usize, by: isize, side: usize| {
            let at = corner.saturating_add_signed(by).min(side.saturating_sub(1));
            (at, corner.checked_add_signed(by) == Some(at))
        };
        let (y, own_y) = inside(corner.y, down, self.whole.height);
        let (x, own_x) = inside(corner.x, right, self.whole.width);
        (y, x, own_y && own_x)
    }

    /// The number of the tile of which a cell of the mosaic is a cell; none for a halo, and for
    /// what lies off the plane.
    #[must_use]
    pub fn tile(&self, y: usize, x: usize) -> Option<usize> {
        let (tile, down, right) = self.at(y, x);
        let within = |by: isize, side: usize| usize::try_from(by).is_ok_and(|by| by < side);
        let own = tile < self.tiles.len()
            && within(down, self.tile.height)
            && within(right, self.tile.width)
            && self.place(y, x).2;
        own.then_some(tile)
    }

    /// The rows and columns of the mosaic that a tile and its halo take, without what lies off the
    /// plane; and where the first of them lies in the plane.
    #[must_use]
    pub fn window(
        &self,
        tile: usize,
    ) -> Option<(std::ops::Range<usize>, std::ops::Range<usize>, At)> {
        let corner = self.tiles.get(tile)?;
        let block = self.block();
        let span = |first: usize, corner: usize, side: usize, whole: usize| {
            let before = self.halo.min(corner);
            let end = (corner + side + self.halo).min(whole);
            let start = first + self.halo - before;
            (
                start..start + (end + before).saturating_sub(corner),
                corner - before,
            )
        };
        let (rows, y) = span(
            tile / self.across * block.height,
            corner.y,
            self.tile.height,
            self.whole.height,
        );
        let (columns, x) = span(
            tile % self.across * block.width,
            corner.x,
            self.tile.width,
            self.whole.width,
        );
        Some((rows, columns, At { y, x }))
    }

    /// Whether a tile lies in the plane with all of its halo.
    #[must_use]
    pub fn is_inside(&self, tile: usize) -> bool {
        let Size { height, width } = self.block();
        let window = self.window(tile);
        window.is_some_and(|(rows, columns, _)| rows.len() == height && columns.len() == width)
    }

    /// A plane as a mosaic.
    ///
    /// # Panics
    /// When the plane is not of the size that the tiles lie in.
    #[must_use]
    pub fn shown(&self, plane: &Plane<f64>, outside: Outside) -> Plane<f64> {
        let (got, want) = (Size::of(plane), self.whole);
        assert!(
            got == want,
            "the plane is {got}, and the tiles lie in {want}"
        );
        Plane::from_shape_fn(self.size().shape(), |(y, x)| {
            let (y, x, own) = self.place(y, x);
            match outside {
                Outside::Dark if !own => 0.0,
                Outside::Dark | Outside::Nearest => plane[(y, x)],
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mosaic() -> Mosaic {
        let tiles = [(0, 0), (4, 8), (8, 12)].map(|(y, x)| At { y, x });
        Mosaic::new(Size::new(10, 14), Size::new(4, 4), 1, tiles.to_vec(), 2)
    }

    #[test]
    #[should_panic(expected = "the plane is 14x9, and the tiles lie in 14x10")]
    fn a_plane_of_another_size_is_no_mosaic() {
        let plane = Plane::zeros((9, 14));
        let _ = mosaic().shown(&plane, Outside::Nearest);
    }

    #[test]
    fn cells_know_their_place() {
        let mosaic = mosaic();
        assert_eq!(mosaic.size(), Size::new(12, 12));
        let plane = Plane::from_shape_fn((10, 14), |(y, x)| (100 * y + x) as f64);
        let near = mosaic.shown(&plane, Outside::Nearest);
        let dark = mosaic.shown(&plane, Outside::Dark);
        // The upper left corner of the halo of the first tile lies off the plane.
        assert_eq!(
            (near[(0, 0)], dark[(0, 0)], mosaic.tile(0, 0)),
            (0.0, 0.0, None)
        );
        assert_eq!((near[(1, 1)], mosaic.tile(1, 1)), (0.0, Some(0)));
        assert_eq!((near[(2, 3)], dark[(2, 3)]), (102.0, 102.0));
        assert_eq!((near[(1, 7)], mosaic.tile(1, 7)), (408.0, Some(1)));
        assert_eq!((near[(0, 6)], mosaic.tile(0, 6)), (307.0, None));
        assert_eq!(mosaic.home(4, 10), At { y: 7, x: 11 });
        // The third tile reaches beyond the plane on two sides.
        assert_eq!((near[(7, 1)], mosaic.tile(7, 1)), (812.0, Some(2)));
        assert_eq!(
            (near[(9, 3)], dark[(9, 3)], mosaic.tile(9, 3)),
            (913.0, 0.0, None)
        );
        // What is left of the last row.
        assert_eq!((near[(7, 7)], mosaic.tile(7, 7)), (812.0, None));
    }

    #[test]
    fn windows_are_what_lies_on_the_plane() {
        let mosaic = mosaic();
        assert_eq!(mosaic.window(0), Some((1..6, 1..6, At { y: 0, x: 0 })));
        assert_eq!(mosaic.window(1), Some((0..6, 6..12, At { y: 3, x: 7 })));
        assert_eq!(mosaic.window(2), Some((6..9, 0..3, At { y: 7, x: 11 })));
        assert_eq!(mosaic.window(3), None);
        for tile in 0..3 {
            let (rows, columns, at) = mosaic.window(tile).unwrap();
            assert_eq!(mosaic.home(rows.start, columns.start), at);
            let end = mosaic.home(rows.end - 1, columns.end - 1);
            assert_eq!(
                (end.y + 1 - at.y, end.x + 1 - at.x),
                (rows.len(), columns.len())
            );
        }
    }
}
