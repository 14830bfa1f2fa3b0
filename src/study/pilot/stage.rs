//! The stage: the light of a kept scene on a mosaic, frame by frame, with the frames that are
//! inserted between those of the scene.

use crate::{
    mosaic::{Mosaic, Outside},
    plane::{Plane, Size},
    scene::{
        Frame,
        kept::{Kept, Pixels},
        upsample::{Bound, Upsampling, at},
    },
};

/// Where the frames between each two frames of a scene lie, from 0 to 1.
pub type Between = Vec<Vec<f64>>;

/// Where upsampling inserts frames; none where it refuses to.
#[must_use]
pub fn between(kept: &Kept, contrast: f64) -> Option<Between> {
    let bound = Bound::Contrast {
        contrast,
        offset: 1.0,
    };
    let how = Upsampling {
        bound,
        ..Upsampling::default()
    };
    let mut before = kept.plane(0)?;
    let mut all = Vec::new();
    for n in 1..kept.len() {
        let now = kept.plane(n)?;
        all.push(how.shares(&before, &now)?);
        before = now;
    }
    Some(all)
}

/// Seconds for the light of the whole scene: with the frames that are inserted, and without.
pub fn seconds_of_light(
    kept: &Kept,
    between: Option<&Between>,
    clock: &(dyn Fn() -> f64 + Sync),
) -> [f64; 2] {
    let [all, own] = Stage::frames(kept, between).map(|frames| frames as f64);
    let start = clock();
    let planes: Vec<_> = (0..2.min(kept.len()))
        .filter_map(|n| kept.plane(n))
        .collect();
    let each = (clock() - start) / planes.len().max(1) as f64;
    let mut inserted = 0.0;
    if let [a, b] = &planes[..]
        && all > own
    {
        let start = clock();
        let between = ndarray::Zip::from(a)
            .and(b)
            .map_collect(|a, b| at(*a, *b, 0.5));
        std::hint::black_box(between);
        inserted = (clock() - start) * (all - own);
    }
    let own = each * own;
    [own + inserted, own]
}

/// A mosaic's light.
pub struct Stage<'a> {
    kept: &'a Kept,
    between: Option<&'a Between>,
    /// The pixel that each cell shows; `u32::MAX` for the dark.
    shows: Vec<u32>,
    size: Size,
}

/// A frame of a stage.
pub struct StageFrame {
    /// As the models that see inserted frames get it.
    pub frame: Frame,
    /// Its number among the scene's own frames, if it is one.
    pub own: Option<u64>,
}

impl<'a> Stage<'a> {
    pub fn new(
        kept: &'a Kept,
        between: Option<&'a Between>,
        mosaic: &Mosaic,
        outside: Outside,
    ) -> Self {
        let size = mosaic.size();
        let width = mosaic.whole().width;
        let cells = (0..size.height).flat_map(|y| (0..size.width).map(move |x| (y, x)));
        let shows = cells.map(|(y, x)| {
            let (at, own) = mosaic.shows(y, x);
            match outside {
                Outside::Dark if !own => u32::MAX,
                Outside::Dark | Outside::Nearest => (at.y * width + at.x) as u32,
            }
        });
        Self {
            kept,
            between,
            shows: shows.collect(),
            size,
        }
    }

    /// Frames that models see that see the inserted ones, and that others see.
    pub fn frames(kept: &Kept, between: Option<&Between>) -> [usize; 2] {
        let inserted = between.map_or(0, |all| all.iter().map(Vec::len).sum());
        [kept.len() + inserted, kept.len()]
    }

    fn light(&self, pixels: Pixels<'_>) -> Plane<f64> {
        let lights = self.shows.iter().map(|from| pixels.at(*from as usize));
        let shape = self.size.shape();
        Plane::from_shape_vec(shape, lights.collect()).unwrap_or_else(|_| Plane::zeros(shape))
    }

    /// Shows the first so many frames of the scene, with those between them.
    pub fn play<E>(
        &self,
        most: usize,
        mut see: impl FnMut(StageFrame) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut given = 0;
        let mut before: Option<(f64, Plane<f64>)> = None;
        for n in 0..most.min(self.kept.len()) {
            let Some((index, seconds, pixels)) = self.kept.frame(n) else {
                break;
            };
            let light = self.light(pixels);
            if let (Some(between), Some((start, old))) = (self.between, &before) {
                let pair = n.checked_sub(1).and_then(|pair| between.get(pair));
                for share in pair.into_iter().flatten() {
                    let light = ndarray::Zip::from(old)
                        .and(&light)
                        .map_collect(|a, b| at(*a, *b, *share));
                    let frame = Frame {
                        index: given,
                        seconds: at(*start, seconds, *share),
                        light: light.into(),
                    };
                    given += 1;
                    see(StageFrame { frame, own: None })?;
                }
            }
            if self.between.is_some() {
                before = Some((seconds, light.clone()));
            }
            let frame = Frame {
                index: given,
                seconds,
                light: light.into(),
            };
            given += 1;
            let own = Some(index);
            see(StageFrame { frame, own })?;
        }
        Ok(())
    }
}
