//! The part of a scene on which many sensors are run: a stretch of time, and some tiles.
//!
//! The tiles are blocks of a grid. The blocks are put in order of how many events the float
//! sensor has there, the order is cut into as many strata of equal size as there are tiles, and
//! of each stratum the block is taken whose events are nearest to the stratum's mean. So every
//! tile stands for as large a part of the sensor, still parts included, where events that noise
//! makes matter.
//!
//! All tiles are shown as one picture, a mosaic: side by side, each with a halo of what lies
//! round it, and only events of the tiles themselves count. A cell of the mosaic is a cell of
//! the chip, though not the one of that place: its mismatch is another draw of the same spread.

use serde::Serialize;

use crate::{
    event::{Event, Packet},
    mosaic::{Mosaic, Outside},
    plane::{At, Size},
    scene::Frame,
};

/// Side of a tile, in pixels.
const SIDE: usize = 16;

/// What is looked at.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sample {
    /// When the stretch begins, in seconds of the scene.
    pub from_seconds: f64,
    /// How long it is.
    pub seconds: f64,
    /// Frames of the scene in it.
    pub source_frames: u64,
    /// The upper left corner of each tile.
    pub tiles: Vec<Tile>,
    /// Columns of a tile.
    pub width: usize,
    /// Rows of a tile.
    pub height: usize,
    /// Pixels round each tile that are shown and not counted.
    pub halo: usize,
    /// Pixels of all tiles.
    pub pixels: usize,
    /// Pixels of the sensor.
    pub pixels_of: usize,
    #[serde(skip)]
    mosaic: Mosaic,
}

/// The upper left corner of a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Tile {
    /// Column.
    pub x: usize,
    /// Row.
    pub y: usize,
}

/// Pixels of a mosaic that a tile takes, its halo included.
pub(super) const fn pixels_of_tile(halo: usize) -> usize {
    (SIDE + 2 * halo) * (SIDE + 2 * halo)
}

impl Sample {
    /// `count` tiles of a sensor; all of it where that is no larger. `events` are the float
    /// sensor's in the stretch, which is `(from, seconds, frames)`.
    pub(super) fn new(
        size: Size,
        halo: usize,
        count: usize,
        events: &[Event],
        stretch: (f64, f64, u64),
    ) -> Self {
        let (from_seconds, seconds, source_frames) = stretch;
        let blocks = Blocks::new(size, halo);
        let whole = size.pixels() <= count * pixels_of_tile(halo) || blocks.count() < count;
        let (tiles, width, height, halo) = if whole {
            (vec![Tile { x: 0, y: 0 }], size.width, size.height, 0)
        } else {
            (blocks.chosen(count, events), SIDE, SIDE, halo)
        };
        let corners: Vec<At> = tiles
            .iter()
            .map(|tile| At {
                y: tile.y,
                x: tile.x,
            })
            .collect();
        let across = corners.len();
        Self {
            mosaic: Mosaic::new(size, Size::new(height, width), halo, corners, across),
            from_seconds,
            seconds,
            source_frames,
            pixels: tiles.len() * width * height,
            pixels_of: size.pixels(),
            tiles,
            width,
            height,
            halo,
        }
    }

    /// Size of the mosaic.
    pub(super) fn size(&self) -> Size {
        self.mosaic.size()
    }

    /// A frame of the scene as a mosaic.
    pub(super) fn shown(&self, frame: &Frame) -> Frame {
        // Tiles of a grid begin at least a halo from the edge.
        let light = self.mosaic.shown(&frame.light, Outside::Nearest).into();
        Frame { light, ..*frame }
    }

    /// The events of the tiles themselves.
    pub(super) fn within(&self, mut packet: Packet) -> Packet {
        if self.halo > 0 {
            let own = |event: &Event| self.mosaic.tile(event.y.into(), event.x.into());
            packet.events.retain(|event| own(event).is_some());
        }
        packet
    }

    /// How many parts the sample has: tiles, or the whole sensor.
    pub(super) fn parts(&self) -> usize {
        self.tiles.len()
    }

    /// The tile of which a cell of the mosaic is a cell; none for a halo.
    pub(super) fn part_of(&self, x: u16, y: u16) -> Option<usize> {
        self.mosaic.tile(y.into(), x.into())
    }

    /// What of the sensor is looked at.
    pub(super) fn part(&self) -> f64 {
        self.pixels as f64 / self.pixels_of as f64
    }
}

/// A grid of blocks that have a halo within the sensor.
struct Blocks {
    across: usize,
    down: usize,
    halo: usize,
}

impl Blocks {
    fn new(size: Size, halo: usize) -> Self {
        let fit = |side: usize| side.saturating_sub(2 * halo) / SIDE;
        Self {
            across: fit(size.width),
            down: fit(size.height),
            halo,
        }
    }

    const fn count(&self) -> usize {
        self.across * self.down
    }

    /// A block of each stratum.
    fn chosen(&self, count: usize, events: &[Event]) -> Vec<Tile> {
        let mut blocks: Vec<(u64, usize)> = (0..self.count()).map(|block| (0, block)).collect();
        for event in events {
            let at = |side: u16| usize::from(side).checked_sub(self.halo).map(|d| d / SIDE);
            if let (Some(x), Some(y)) = (at(event.x), at(event.y))
                && x < self.across
                && y < self.down
                && let Some((events, _)) = blocks.get_mut(y * self.across + x)
            {
                *events += 1;
            }
        }
        blocks.sort_unstable();
        let mut tiles: Vec<usize> = (0..count)
            .filter_map(|i| {
                let stratum = blocks.get(i * blocks.len() / count..(i + 1) * blocks.len() / count);
                nearest_to_mean(stratum?)
            })
            .collect();
        // As they lie in the picture.
        tiles.sort_unstable();
        { tiles.into_iter() }
            .map(|block| Tile {
                x: self.halo + block % self.across * SIDE,
                y: self.halo + block / self.across * SIDE,
            })
            .collect()
    }
}

/// The block whose events are nearest to the mean; of several the first.
fn nearest_to_mean(blocks: &[(u64, usize)]) -> Option<usize> {
    let sum: u64 = blocks.iter().map(|(events, _)| events).sum();
    let mean = sum as f64 / blocks.len() as f64;
    let far = |events: u64| (events as f64 - mean).abs();
    let nearest = blocks
        .iter()
        .min_by(|(a, _), (b, _)| far(*a).total_cmp(&far(*b)));
    nearest.map(|(_, block)| *block)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{event::Polarity, plane::Plane, unit::Micros};

    fn event(x: usize, y: usize) -> Event {
        Event {
            t: Micros(0),
            x: x as u16,
            y: y as u16,
            polarity: Polarity::On,
            channel: 0,
        }
    }

    /// Block k of the grid, row by row, has k events.
    fn events(size: Size, halo: usize) -> Vec<Event> {
        let blocks = Blocks::new(size, halo);
        (0..blocks.count())
            .flat_map(|k| {
                let (x, y) = (k % blocks.across * SIDE, k / blocks.across * SIDE);
                (0..k).map(move |i| event(halo + x + i % SIDE, halo + y + i / SIDE))
            })
            .collect()
    }

    #[test]
    fn a_tile_stands_for_each_stratum() {
        let size = Size::new(86, 102);
        let sample = Sample::new(size, 3, 5, &events(size, 3), (0.0, 1.0, 11));
        // 5 rows of 6 blocks in strata of 6: the middle of each.
        let middle = |k: usize| Tile {
            x: 3 + k % 6 * SIDE,
            y: 3 + k / 6 * SIDE,
        };
        assert_eq!(sample.tiles, [2, 8, 14, 20, 26].map(middle));
        assert_eq!((sample.width, sample.height, sample.halo), (SIDE, SIDE, 3));
        assert_eq!(sample.size(), Size::new(22, 110));
        assert_eq!(sample.pixels, 5 * 256);
    }

    #[test]
    fn a_mosaic_shows_the_tiles_and_what_lies_round_them() {
        let size = Size::new(86, 102);
        let sample = Sample::new(size, 3, 5, &events(size, 3), (0.0, 1.0, 11));
        let place = |y: usize, x: usize| (1000 * y + x) as f64;
        let frame = Frame {
            index: 4,
            seconds: 0.4,
            light: Plane::from_shape_fn(size.shape(), |(y, x)| place(y, x)).into(),
        };
        let shown = sample.shown(&frame);
        assert_eq!((shown.index, shown.seconds), (4, 0.4));
        for (i, tile) in sample.tiles.iter().enumerate() {
            for (y, x) in [(0, 0), (5, 7), (21, 21)] {
                let light = shown.light[(y, 22 * i + x)];
                assert_eq!(light, place(tile.y + y - 3, tile.x + x - 3));
            }
        }
        let mut packet = Packet::new(sample.size(), 1);
        packet.events = [(2, 5), (3, 3), (18, 18), (19, 3), (24, 4), (25, 4), (30, 2)]
            .map(|(x, y)| event(x, y))
            .to_vec();
        let packet = sample.within(packet);
        let left: Vec<_> = packet.events.iter().map(|e| (e.x, e.y)).collect();
        assert_eq!(left, [(3, 3), (18, 18), (25, 4)]);
    }

    #[test]
    fn a_small_sensor_is_looked_at_whole() {
        let size = Size::new(32, 48);
        let sample = Sample::new(size, 2, 8, &[], (0.0, 1.0, 11));
        assert_eq!((sample.size(), sample.halo, sample.part()), (size, 0, 1.0));
        let light = Plane::from_shape_fn(size.shape(), |(y, x)| (y * x) as f64);
        let frame = Frame {
            index: 0,
            seconds: 0.0,
            light: light.into(),
        };
        assert_eq!(sample.shown(&frame), frame);
    }
}
