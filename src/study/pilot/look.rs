//! The look: what goes on in each tile, from one pass over the light that is cheap beside any
//! sensor.

use std::ops::Range;

use super::{levels::Levels, value::Value};
use crate::{
    plane::{At, Size},
    rng::Hash,
    scene::kept::{Kept, Pixels},
};

/// The tiles of a sensor: squares from its upper left corner on, the last ones cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    /// Of the sensor.
    pub size: Size,
    /// Pixels along a side; even.
    pub side: usize,
}

/// The even side of a tile: large enough that its halo is not most of it.
#[must_use]
pub fn side(halo: usize) -> usize {
    (3 * halo).next_power_of_two().clamp(4, 64)
}

impl Grid {
    /// The tiles of a sensor, for what sees so far round a pixel.
    #[must_use]
    pub fn new(size: Size, halo: usize) -> Self {
        let side = side(halo);
        Self { size, side }
    }

    /// Tiles in a row.
    const fn across(self) -> usize {
        self.size.width.div_ceil(self.side)
    }

    /// How many.
    #[must_use]
    pub const fn tiles(self) -> usize {
        self.across() * self.size.height.div_ceil(self.side)
    }

    /// The upper left corner of a tile.
    #[must_use]
    pub const fn corner(self, tile: usize) -> At {
        At {
            y: tile / self.across() * self.side,
            x: tile % self.across() * self.side,
        }
    }

    const fn tile(self, pixel: usize) -> usize {
        let (y, x) = (pixel / self.size.width, pixel % self.size.width);
        y / self.side * self.across() + x / self.side
    }
}

/// What was seen of the light.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// The tiles.
    pub grid: Grid,
    /// How much the light of each changes, all frames together; below 0 where it never does.
    pub activity: Vec<f64>,
    /// Tiles of the darkest and the brightest light and of the largest change: numbers saturate
    /// and sensors fail there first. And the tile in which most changes between the fewest levels:
    /// rounding may decide there and nowhere else.
    pub extremes: Vec<usize>,
    /// The least and the most light.
    pub range: (f64, f64),
    /// The largest change of a pixel from one frame to the next, per second.
    pub steepest: f64,
    /// From the first frame to the last, in seconds.
    pub seconds: f64,
    /// Rows and columns outside of which no pixel ever changes; empty where none does.
    pub changing: (Range<usize>, Range<usize>),
}

/// The most extremes: the darkest, the brightest, the steepest, and that of the fewest levels.
pub const EXTREMES: usize = 4;

/// How much is looked at for activity, about: so many pixels of all frames together. Rows are left
/// out, not frames: each tile is looked at in every frame.
const LOOKED_AT: usize = 1 << 22;

impl Look {
    /// Looks at a scene in tiles. `relative`: a change counts for what it is of the light, as
    /// for a logarithmic response.
    #[must_use]
    pub fn new(kept: &Kept, grid: Grid, relative: bool) -> Self {
        Self::of_first(kept.len(), kept, grid, relative)
    }

    /// The same of the first so many frames.
    #[must_use]
    pub fn of_first(frames: usize, kept: &Kept, grid: Grid, relative: bool) -> Self {
        let mut look = Self {
            activity: vec![-1.0; grid.tiles()],
            extremes: Vec::new(),
            range: (f64::INFINITY, f64::NEG_INFINITY),
            steepest: 0.0,
            seconds: 0.0,
            changing: (0..0, 0..0),
            grid,
        };
        let mut places = [0; EXTREMES - 1];
        let mut levels = Levels::new(grid.size, kept.len());
        let pairs = kept.len().saturating_sub(1);
        let skip = (grid.size.pixels() * pairs / LOOKED_AT).clamp(1, grid.side);
        for n in 0..frames.min(kept.len()) {
            let Some((_, seconds, now)) = kept.frame(n) else {
                break;
            };
            look.extent(now, &mut places);
            let Some((_, start, before)) = n.checked_sub(1).and_then(|n| kept.frame(n)) else {
                continue;
            };
            look.seconds += seconds - start;
            let how = How {
                dt: seconds - start,
                rows: Rows { frame: n, skip },
                relative,
            };
            match (before, now) {
                (Pixels::Bytes(a), Pixels::Bytes(b)) => {
                    look.compare(a, b, how, &mut places[2]);
                    levels.see(n, a, b);
                }
                (Pixels::Numbers(a), Pixels::Numbers(b)) => {
                    look.compare(a, b, how, &mut places[2]);
                    levels.see(n, a, b);
                }
                (a, b) => {
                    let all = |pixels: Pixels<'_>| -> Vec<f64> {
                        (0..grid.size.pixels())
                            .map(|pixel| pixels.at(pixel))
                            .collect()
                    };
                    let (a, b) = (all(a), all(b));
                    look.compare(&a, &b, how, &mut places[2]);
                    levels.see(n, &a, &b);
                }
            }
        }
        let places = places.into_iter().chain(levels.fewest());
        look.extremes = places.map(|pixel| grid.tile(pixel)).collect();
        look.extremes.dedup();
        look.bounds();
        look
    }

    fn extent(&mut self, pixels: Pixels<'_>, places: &mut [usize; EXTREMES - 1]) {
        match pixels {
            Pixels::Bytes(bytes) => self.extent_of(bytes, places),
            Pixels::Numbers(numbers) => self.extent_of(numbers, places),
        }
    }

    fn extent_of<T: Value>(&mut self, pixels: &[T], places: &mut [usize; EXTREMES - 1]) {
        let Some(first) = pixels.first() else { return };
        let less = |a: T, b: T| if b < a { b } else { a };
        let more = |a: T, b: T| if b > a { b } else { a };
        // In lanes, so that this runs in vectors.
        let (mut low, mut high) = ([*first; LANES], [*first; LANES]);
        let (blocks, rest) = pixels.as_chunks::<LANES>();
        for block in blocks {
            for (lane, light) in block.iter().enumerate() {
                low[lane] = less(low[lane], *light);
                high[lane] = more(high[lane], *light);
            }
        }
        let least = low.iter().chain(rest).fold(*first, |a, b| less(a, *b));
        let most = high.iter().chain(rest).fold(*first, |a, b| more(a, *b));
        let place = |of: T| pixels.iter().position(|light| *light == of).unwrap_or(0);
        if least.light() < self.range.0 {
            (self.range.0, places[0]) = (least.light(), place(least));
        }
        if most.light() > self.range.1 {
            (self.range.1, places[1]) = (most.light(), place(most));
        }
    }

    fn compare<T: Value>(&mut self, before: &[T], now: &[T], how: How, place: &mut usize) {
        let (width, side) = (self.grid.size.width, self.grid.side);
        let rows = before.chunks(width).zip(now.chunks(width)).enumerate();
        for (y, (a, b)) in rows.filter(|(_, (a, b))| a != b) {
            let change = |(a, b): (&T, &T)| (b.light() - a.light()).abs();
            let most = largest_change(a, b) / how.dt;
            if most > self.steepest {
                self.steepest = most;
                let at = { a.iter().zip(b) }.position(|pair| change(pair) / how.dt >= most);
                *place = y * width + at.unwrap_or(0);
            }
            let first = y / side * self.grid.across();
            let counts = how.rows.count(y / side, y % side);
            let tiles = a.chunks(side).zip(b.chunks(side));
            for ((a, b), activity) in tiles.zip(&mut self.activity[first..]) {
                if *activity < 0.0 && a != b {
                    *activity = 0.0;
                }
                if counts {
                    let sum: f64 = a.iter().zip(b).map(change).sum();
                    let light: f64 = a.iter().map(|a| a.light().max(0.0)).sum();
                    let of = if how.relative {
                        light / a.len() as f64 + 1.0
                    } else {
                        1.0
                    };
                    if sum > 0.0 {
                        *activity += sum / of;
                    }
                }
            }
        }
    }

    /// The rows and columns of all tiles that change.
    fn bounds(&mut self) {
        let Grid { size, side } = self.grid;
        let changed = { self.activity.iter().enumerate() }.filter(|(_, a)| **a >= 0.0);
        let corners: Vec<At> = changed.map(|(tile, _)| self.grid.corner(tile)).collect();
        let span = |of: fn(&At) -> usize, most: usize| {
            let start = corners.iter().map(of).min().unwrap_or(0);
            let end = corners.iter().map(|at| of(at) + side).max().unwrap_or(0);
            start..end.min(most)
        };
        self.changing = (span(|at| at.y, size.height), span(|at| at.x, size.width));
    }

    /// The activity of tiles that see so far beyond their own pixels: a tile is still where all
    /// that it sees is.
    #[must_use]
    pub fn seen_from(&self, halo: usize) -> Vec<f64> {
        let reach = halo.div_ceil(self.grid.side);
        let (across, tiles) = (self.grid.across(), self.grid.tiles());
        let down = tiles / across.max(1);
        let sees = |tile: usize| {
            let (y, x) = (tile / across, tile % across);
            let near = |at: usize, end: usize| at.saturating_sub(reach)..(at + reach + 1).min(end);
            near(y, down).any(|y| near(x, across).any(|x| self.activity[y * across + x] >= 0.0))
        };
        let own = |(tile, activity): (usize, &f64)| {
            if *activity < 0.0 && sees(tile) {
                0.0
            } else {
                *activity
            }
        };
        self.activity.iter().enumerate().map(own).collect()
    }
}

/// Values that are worked on side by side.
const LANES: usize = 16;

/// The largest difference of two rows.
fn largest_change<T: Value>(a: &[T], b: &[T]) -> f64 {
    let more = |most: f64, a: &T, b: &T| {
        let change = (b.light() - a.light()).abs();
        if change > most { change } else { most }
    };
    let mut most = [0.0; LANES];
    let ((a, rest_a), (b, rest_b)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    for (a, b) in a.iter().zip(b) {
        for (lane, most) in most.iter_mut().enumerate() {
            *most = more(*most, &a[lane], &b[lane]);
        }
    }
    let rest = rest_a.iter().zip(rest_b);
    let most = most.into_iter().fold(0.0, f64::max);
    rest.fold(most, |most, (a, b)| more(most, a, b))
}

/// How two frames are compared.
#[derive(Clone, Copy)]
struct How {
    dt: f64,
    rows: Rows,
    relative: bool,
}

/// The rows of tiles that are looked at in a frame, one in so many.
#[derive(Clone, Copy)]
struct Rows {
    frame: usize,
    skip: usize,
}

impl Rows {
    /// Whether a row of the tiles that lie side by side counts: by chance, so that nothing that comes
    /// again and again falls between them.
    fn count(self, tiles: usize, row: usize) -> bool {
        let offset = || Hash::new(self.frame as u64).with(tiles as u64).bits() as usize;
        self.skip == 1 || (row + offset() % self.skip).is_multiple_of(self.skip)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        plane::Plane,
        scene::{Frame, held::Held},
    };

    #[test]
    fn a_look_finds_where_something_goes_on() {
        let size = Size::new(10, 12);
        let frames: Vec<Frame> = (0..5u64)
            .map(|index| Frame {
                index,
                seconds: index as f64 * 0.5,
                light: Plane::from_shape_fn(size.shape(), |(y, x)| match (y, x) {
                    (5, 9) => 10.0 * index as f64,
                    (9, 0) if index == 3 => 200.0,
                    _ => 7.0,
                })
                .into(),
            })
            .collect();
        let mut scene = Held::new(frames, size, 2.0);
        let kept = Kept::new(&mut scene, 1 << 20).unwrap().unwrap();
        let look = Look::new(&kept, Grid { size, side: 4 }, false);
        let mut want = vec![-1.0; 9];
        (want[5], want[6]) = (40.0, 386.0);
        assert_eq!(look.activity, want);
        assert_eq!(look.range, (0.0, 200.0));
        assert_eq!((look.steepest, look.seconds), (386.0, 2.0));
        assert_eq!(look.changing, (4..10, 0..12));
        assert_eq!(look.extremes, [5, 6]);
        let seen = look.seen_from(2);
        let still: Vec<usize> = (0..9).filter(|tile| seen[*tile] < 0.0).collect();
        assert_eq!(still, [0]);
        assert_eq!(look.seen_from(0), look.activity);
    }

    /// Long scenes are looked at in part; what moves in every other frame is not missed by that.
    #[test]
    fn what_comes_again_and_again_is_seen() {
        let size = Size::new(64, 64);
        for phase in 0..2 {
            // Square 0 moves in these frames, square 1 in the others.
            let mut square = [0.0; 2];
            let frames: Vec<Frame> = (0..2200u64)
                .map(|index| {
                    square[usize::from(index % 2 == phase)] = index as f64 % 97.0;
                    let light = |(y, x)| match (y / 16, x / 16) {
                        (1, 1) => square[0],
                        (2, 2) => square[1],
                        _ => 7.0,
                    };
                    Frame {
                        index,
                        seconds: index as f64 * 0.01,
                        light: Plane::from_shape_fn(size.shape(), light).into(),
                    }
                })
                .collect();
            let mut scene = Held::new(frames, size, 100.0);
            let kept = Kept::new(&mut scene, 1 << 30).unwrap().unwrap();
            let look = Look::new(&kept, Grid { size, side: 16 }, false);
            let (a, b) = (look.activity[5], look.activity[10]);
            assert!(a > 0.0 && b > 0.0 && (a / b - 1.0).abs() < 0.2, "{a} {b}");
        }
    }
}
