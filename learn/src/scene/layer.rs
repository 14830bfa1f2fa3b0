//! One photograph on its path.

use std::ops::Range;

use amacrine::plane::{Plane, Size};

use super::{
    affine::{Affine, Path, plus},
    motion::{Draw, Motion, Reason},
    outline::Outline,
};

/// Samples along each side of a pixel.
pub(super) const SAMPLES: usize = 2;

/// Pixels from one to the next.
const SPACING: f32 = 1.0 / SAMPLES as f32;

/// Where the `n`-th sample of a row or a column is: the middle of pixel 0 is at 0.
pub(super) fn place(n: usize) -> f32 {
    (n as f32 + 0.5) * SPACING - 0.5
}

/// Pixels of the photograph a pixel of the clip, where it is large enough.
const SHRINK: [f64; 2] = [0.8, 2.0];

/// How much larger than the crop what it sees of the photograph is at the least.
const ROOM: f64 = 1.2;

/// A photograph on its path, cut along an outline where it has one.
#[derive(Debug)]
pub(super) struct Layer<'a> {
    picture: &'a Plane<u8>,
    /// From places in the clip at time 0 to pixels of the photograph.
    texture: Affine,
    pub path: Path,
    pub outline: Option<Outline>,
}

impl<'a> Layer<'a> {
    /// Draws a layer whose middle is at `path.centre` at time 0.
    pub fn new(
        picture: &'a Plane<u8>,
        (draw, motion): (Draw, &Motion),
        (size, centre): (Size, [f64; 2]),
        outline: Option<Outline>,
    ) -> Self {
        let (height, width) = picture.dim();
        let ratio = |own: usize, crop: usize| own as f64 / (ROOM * crop as f64);
        let largest = ratio(height, size.height).min(ratio(width, size.width));
        let most = SHRINK[1].min(largest);
        let shrink = draw.between(Reason::Shrink, [SHRINK[0].min(most), most]);
        // One of the eight ways to lay a square upon itself.
        let way = draw.one_of(Reason::Orientation, 8);
        let (a, b) = (
            if way & 1 == 0 { shrink } else { -shrink },
            if way & 2 == 0 { shrink } else { -shrink },
        );
        let matrix = if way & 4 == 0 {
            [[a, 0.0], [0.0, b]]
        } else {
            [[0.0, a], [b, 0.0]]
        };
        // Where in the photograph the middle of the crop looks: as far from the border as it can
        // see, where there is room.
        let spot = |reason, own: usize, crop: usize| {
            let end = (own - 1) as f64;
            let half = (shrink * crop as f64 / 2.0).min(end / 2.0);
            draw.between(reason, [half, end - half])
        };
        let side = size.height.max(size.width);
        let seen = [
            spot(Reason::Left, width, side),
            spot(Reason::Top, height, side),
        ];
        let turned = Affine {
            matrix,
            offset: [0.0; 2],
        };
        let middle = turned.at([
            (size.width - 1) as f64 / 2.0,
            (size.height - 1) as f64 / 2.0,
        ]);
        let texture = Affine {
            matrix,
            offset: [seen[0] - middle[0], seen[1] - middle[1]],
        };
        Self {
            picture,
            texture,
            path: motion.path(draw, centre),
            outline,
        }
    }

    /// The layer at time `t`, in frames.
    pub fn at(&self, t: f64, size: Size) -> View<'_> {
        let back = self.path.back(t);
        let place = self.texture.after(&back);
        let (height, width) = self.picture.dim();
        let (right, bottom) = (size.width as f64 - 0.5, size.height as f64 - 0.5);
        let corners = [[-0.5, -0.5], [right, -0.5], [-0.5, bottom], [right, bottom]];
        let inside = corners.iter().all(|corner| {
            let [x, y] = place.at(*corner);
            let holds = |v: f64, own: usize| v > 0.5 && v < own as f64 - 2.5;
            holds(x, width) && holds(y, height)
        });
        let centre = self.path.centre;
        let from = plus(back.offset, [-centre[0], -centre[1]]);
        View {
            picture: self.picture,
            texture: Single::new(&place),
            inside,
            outline: self.outline.as_ref(),
            local: Single::new(&Affine {
                matrix: back.matrix,
                offset: from,
            }),
        }
    }
}

/// An affine map in single precision.
#[derive(Clone, Copy, Debug)]
struct Single {
    matrix: [[f32; 2]; 2],
    offset: [f32; 2],
}

impl Single {
    fn new(map: &Affine) -> Self {
        Self {
            matrix: map.matrix.map(|row| row.map(|v| v as f32)),
            offset: map.offset.map(|v| v as f32),
        }
    }

    fn at(&self, x: f32, y: f32) -> [f32; 2] {
        let [p, q] = self.matrix;
        [
            self.offset[0] + (p[0] * x + p[1] * y),
            self.offset[1] + (q[0] * x + q[1] * y),
        ]
    }
}

/// A layer at one time.
pub(super) struct View<'a> {
    picture: &'a Plane<u8>,
    texture: Single,
    /// Whether all that the crop sees lies in the photograph.
    inside: bool,
    outline: Option<&'a Outline>,
    local: Single,
}

impl View<'_> {
    /// How much of what is at the samples of a row this layer hides, an edge being a pixel wide;
    /// and the samples between which it hides anything.
    pub fn cover(&self, y: f32, cover: &mut [f32]) -> Range<usize> {
        let Some(outline) = self.outline else {
            cover.fill(1.0);
            return 0..cover.len();
        };
        let (mut first, mut end) = (cover.len(), 0);
        for (n, own) in cover.iter_mut().enumerate() {
            let at = self.local.at(place(n), y);
            *own = if outline.near(at) {
                (outline.depth(at) + 0.5).clamp(0.0, 1.0)
            } else {
                0.0
            };
            if *own > 0.0 {
                (first, end) = (first.min(n), n + 1);
            }
        }
        first.min(end)..end
    }

    /// The light at some samples of a row: between four pixels of the photograph, mirrored beyond
    /// its border.
    pub fn light(&self, y: f32, samples: Range<usize>, light: &mut [f32]) {
        let (height, width) = self.picture.dim();
        let pixels = self.picture.as_slice().unwrap_or_default();
        // Fixed point: steps along a row are all alike.
        let [x, y] = { self.texture.at(place(samples.start), y) }.map(fixed);
        let [dx, dy] = self.texture.matrix.map(|row| fixed(row[0] * SPACING));
        let (mut x, mut y) = (x, y);
        for own in light {
            let (i, j) = (x >> FRACTION, y >> FRACTION);
            let part = |v: i64| (v & (ONE - 1)) as i32 as f32 * (1.0 / ONE as f32);
            let (fx, fy) = (part(x), part(y));
            let ([left, right], [upper, lower]) = if self.inside {
                let (i, j) = (i as usize, j as usize);
                ([i, i + 1], [j, j + 1])
            } else {
                (
                    [mirrored(i, width), mirrored(i + 1, width)],
                    [mirrored(j, height), mirrored(j + 1, height)],
                )
            };
            let line = |row: usize| {
                let row = &pixels[row * width..][..width];
                let (left, right) = (f32::from(row[left]), f32::from(row[right]));
                left + (right - left) * fx
            };
            let (upper, lower) = (line(upper), line(lower));
            *own = upper + (lower - upper) * fy;
            (x, y) = (x + dx, y + dy);
        }
    }
}

/// Bits of a place behind the point.
const FRACTION: u32 = 20;
const ONE: i64 = 1 << FRACTION;

fn fixed(v: f32) -> i64 {
    (f64::from(v) * ONE as f64) as i64
}

/// The pixel that stands for one beyond the border.
fn mirrored(at: i64, length: usize) -> usize {
    let last = length as i64 - 1;
    if last == 0 {
        return 0;
    }
    let at = at.rem_euclid(2 * last);
    at.min(2 * last - at) as usize
}
