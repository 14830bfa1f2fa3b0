//! The scene: a moving texture in memory, so that making it is not timed.

use amacrine::{
    plane::Size,
    scene::{Frame, Image, Levels},
};

/// Makes about 0.8 events per pixel and pair of the texture under `csdvs-5`.
pub const THRESHOLD: f64 = 0.04;

/// 240 frames a second.
const INTERVAL: f64 = 1.0 / 240.0;

/// Frames that are watched to and fro, so that no step is larger than another.
pub struct Clip {
    pub size: Size,
    frames: Vec<Frame>,
    watched: u64,
}

impl Clip {
    /// Pairs from the first frame to the last and back.
    pub const ROUND: u64 = 2 * (Self::FRAMES - 1);

    const FRAMES: u64 = 17;

    pub fn new(size: Size) -> Self {
        let frame = |n: u64| Frame {
            index: n,
            seconds: n as f64 * INTERVAL,
            light: Image::of_bytes(
                size,
                (0..size.pixels())
                    .map(|pixel| (pixel / size.width, pixel % size.width))
                    .map(|(y, x)| texture(x as f64 + 1.3 * n as f64, y as f64 + 0.4 * n as f64))
                    .map(|light| light.round() as u8)
                    .collect(),
                Levels::bytes(),
            )
            .expect("a byte for each pixel"),
        };
        Self {
            size,
            frames: (0..Self::FRAMES).map(frame).collect(),
            watched: 0,
        }
    }

    /// The same, held as numbers.
    pub fn as_numbers(&self) -> Self {
        let frames = self.frames.iter().map(|frame| Frame {
            light: frame.light.clone().into_plane().into(),
            ..frame.clone()
        });
        Self {
            frames: frames.collect(),
            ..*self
        }
    }

    /// The same, not quite in whole numbers.
    pub fn not_whole(&self) -> Self {
        let frames = self.frames.iter().map(|frame| Frame {
            light: frame.light.mapv(|light| light * 0.997 + 0.1).into(),
            ..frame.clone()
        });
        Self {
            frames: frames.collect(),
            ..*self
        }
    }

    /// Starts again, at time 0.
    pub fn rewind(&mut self) {
        self.watched = 0;
    }

    /// The next frame, at its own time.
    pub fn advance(&mut self) -> &Frame {
        let phase = self.watched % Self::ROUND;
        let frame = &mut self.frames[phase.min(Self::ROUND - phase) as usize];
        frame.index = self.watched;
        frame.seconds = self.watched as f64 * INTERVAL;
        self.watched += 1;
        frame
    }
}

/// Smooth noise of two sizes, 0 to 255.
fn texture(x: f64, y: f64) -> f64 {
    140.0 * smooth(x / 6.0, y / 6.0, 1) + 115.0 * smooth(x / 2.5, y / 2.5, 2)
}

/// Random numbers at whole places, interpolated between.
fn smooth(x: f64, y: f64, layer: u64) -> f64 {
    let at = |x: f64, y: f64| {
        let mut h = ((x as u64) << 32 | y as u64)
            .wrapping_add(layer << 60)
            .wrapping_mul(0x9E37_79B9_7F4A_7C15);
        h = (h ^ (h >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        (h >> 11) as f64 / (1u64 << 53) as f64
    };
    let (left, top) = (x.floor(), y.floor());
    let (u, v) = (x - left, y - top);
    let row = |y| at(left, y) * (1.0 - u) + at(left + 1.0, y) * u;
    row(top) * (1.0 - v) + row(top + 1.0) * v
}
