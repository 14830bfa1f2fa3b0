//! Survey: what a scene is like, from one look at its light.

use std::ops::{ControlFlow, Range};

use crate::{
    elementary,
    plane::{Plane, Size},
    reference::Description,
    rig,
    scene::{Frame, Scene},
    sensor::SensorError,
};

use super::PlanError;

/// The side of a tile, in pixels.
pub const TILE: usize = 16;

/// What a scene is like, as a sensor's photoreceptors see it.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Light {
    /// Its size.
    pub size: Size,
    /// Frames.
    pub frames: u64,
    /// From the first frame to the last, in seconds.
    pub seconds: f64,
    /// The least and the most light.
    pub range: (f64, f64),
    /// The largest signal, in size.
    pub signal: f64,
    /// Mean change of ln(light + 1), per pixel and second.
    pub contrast_per_second: f64,
    /// Share of tiles and pairs of frames in which any light changes.
    pub active_tiles: f64,
    /// Root mean square spatial frequency of the signal, in cycles a pixel.
    pub spatial_frequency: f64,
    /// Root mean square temporal frequency of the signal, in Hz.
    pub temporal_frequency: f64,
    /// Rows and columns outside of which no pixel ever differs from the first frame.
    pub changing: (Range<usize>, Range<usize>),
    /// Most that a photoreceptor without its low-pass is off, in the signal's unit.
    pub low_pass: f64,
    /// Most that a resistor sheet which settles at once is off, in the signal's unit.
    pub settling: f64,
    /// Mean number of shot noise events of one kind of cell, all pixels together; a bound where
    /// the photoreceptors have a low-pass.
    pub shots: f64,
    /// Frames that upsampling makes of it, about; as many as there are without.
    pub upsampled: f64,
}

/// What is added up on the way.
#[derive(Default)]
struct Sums {
    first: Plane<f64>,
    before: Option<Seen>,
    start: f64,
    contrast: f64,
    /// Tiles in which something changed, and all.
    tiles: [u64; 2],
    /// Of the signal: sum, squares, number.
    values: [f64; 3],
    /// Squared differences of neighbours, and their number.
    space: [f64; 2],
    /// Squared rates of change, and their number.
    time: [f64; 2],
    /// How far a photoreceptor without its low-pass is off at this frame.
    off: f64,
    /// The same of a resistor sheet that settles at once.
    lag: f64,
}

/// A frame, and what photoreceptors make of it.
struct Seen {
    seconds: f64,
    light: Plane<f64>,
    signal: Plane<f64>,
}

impl Light {
    /// Looks at every frame of a scene; `contrast` is what it would be upsampled by, in ln
    /// units. `seen` is called after each frame.
    ///
    /// # Errors
    /// When the scene cannot be read, has no frame, or holds light that the response is not
    /// defined for.
    pub fn of(
        scene: &mut dyn Scene,
        description: &Description,
        contrast: Option<f64>,
        mut seen: impl FnMut(),
    ) -> Result<Self, PlanError> {
        let size = scene.size();
        let mut light = Self {
            size,
            frames: 0,
            seconds: 0.0,
            range: (f64::INFINITY, f64::NEG_INFINITY),
            signal: 0.0,
            contrast_per_second: 0.0,
            active_tiles: 0.0,
            spatial_frequency: 0.0,
            temporal_frequency: 0.0,
            changing: (size.height..0, size.width..0),
            low_pass: 0.0,
            settling: 0.0,
            shots: 0.0,
            upsampled: 0.0,
        };
        let mut sums = Sums::default();
        rig::play(scene, |frame| {
            let now = Seen::of(frame, description)?;
            light.note(&now, &mut sums);
            if let Some(before) = &sums.before.take() {
                light.compare(before, &now, description, contrast, &mut sums);
            } else {
                sums.start = now.seconds;
                sums.first.clone_from(&now.light);
            }
            sums.before = Some(now);
            seen();
            Ok::<_, PlanError>(ControlFlow::Continue(()))
        })?;
        if light.frames == 0 {
            return Err(PlanError::NoFrames);
        }
        light.finish(&sums);
        Ok(light)
    }

    /// Takes in a frame by itself.
    fn note(&mut self, now: &Seen, sums: &mut Sums) {
        self.frames += 1;
        self.upsampled += 1.0;
        for light in &now.light {
            self.range = (self.range.0.min(*light), self.range.1.max(*light));
        }
        for value in &now.signal {
            self.signal = self.signal.max(value.abs());
            sums.values[0] += value;
            sums.values[1] += value * value;
        }
        sums.values[2] += now.signal.len() as f64;
        for pair in now.signal.rows().into_iter().chain(now.signal.columns()) {
            for (a, b) in pair.iter().zip(pair.iter().skip(1)) {
                sums.space[0] += (a - b).powi(2);
                sums.space[1] += 0.5;
            }
        }
    }

    /// Compares a frame with the one before.
    fn compare(
        &mut self,
        before: &Seen,
        now: &Seen,
        description: &Description,
        contrast: Option<f64>,
        sums: &mut Sums,
    ) {
        let dt = now.seconds - before.seconds;
        self.seconds = now.seconds - sums.start;
        let (mut steepest, mut moved) = (0.0_f64, 0.0_f64);
        let lights = now.light.iter().zip(&before.light);
        let signals = now.signal.iter().zip(&before.signal);
        for ((light, old), (u, v)) in lights.zip(signals) {
            if light != old {
                let change = elementary::ln((light.max(0.0) + 1.0) / (old.max(0.0) + 1.0)).abs();
                steepest = steepest.max(change);
                sums.contrast += change;
                moved = moved.max((u - v).abs());
                sums.time[0] += ((u - v) / dt).powi(2);
            }
        }
        sums.time[1] += now.signal.len() as f64;
        if let Some(most) = contrast {
            self.upsampled += (steepest / most).ceil().max(1.0) - 1.0;
        }
        let noise = description.noise;
        let slowest = slowest_sheet(description);
        if slowest > 0.0 {
            // What a photoreceptor is behind by, it may make good at once.
            let moved = moved + sums.off;
            let times = dt / slowest;
            // Inserted frames bend the line between two frames, at worst into a step.
            let late = match contrast {
                Some(_) => 1.0,
                None => -elementary::exp_m1(-times) / times,
            };
            sums.lag = elementary::exp(-times) * sums.lag + late * moved;
            self.settling = self.settling.max(sums.lag);
        }
        if noise.cutoff_hz > 0.0 {
            // The darker, the slower: none is slower than in the least light of the scene.
            let darkest = now.light.iter().fold(f64::INFINITY, |a, b| a.min(*b));
            sums.off = (1.0 - noise.low_pass(darkest, dt)) * (sums.off + moved);
            self.low_pass = self.low_pass.max(sums.off);
        }
        let shares: f64 = if noise.cutoff_hz > 0.0 {
            now.light.len() as f64
        } else {
            now.light.iter().map(|light| noise.shot_share(*light)).sum()
        };
        self.shots += noise.shot_hz * dt * shares;
        self.tiles(before, now, sums);
    }

    /// Counts tiles in which something changed, and grows what has changed since the start.
    fn tiles(&mut self, before: &Seen, now: &Seen, sums: &mut Sums) {
        let (height, width) = now.light.dim();
        for top in (0..height).step_by(TILE) {
            for left in (0..width).step_by(TILE) {
                let part = ndarray::s![
                    top..(top + TILE).min(height),
                    left..(left + TILE).min(width)
                ];
                let now = now.light.slice(part);
                sums.tiles[0] += u64::from(now != before.light.slice(part));
                sums.tiles[1] += 1;
                if now == sums.first.slice(part) {
                    continue;
                }
                let (rows, columns) = &mut self.changing;
                for ((y, x), light) in now.indexed_iter() {
                    let (y, x) = (top + y, left + x);
                    if *light != sums.first[[y, x]] {
                        *rows = rows.start.min(y)..rows.end.max(y + 1);
                        *columns = columns.start.min(x)..columns.end.max(x + 1);
                    }
                }
            }
        }
    }

    fn finish(&mut self, sums: &Sums) {
        let [sum, squares, number] = sums.values;
        let variance = (squares - sum * sum / number) / number;
        let frequency = |[squares, number]: [f64; 2]| {
            if variance > 0.0 && number > 0.0 {
                (squares / number / variance).sqrt() / std::f64::consts::TAU
            } else {
                0.0
            }
        };
        self.spatial_frequency = frequency(sums.space);
        self.temporal_frequency = frequency(sums.time);
        let pixel_seconds = self.size.pixels() as f64 * self.seconds;
        if pixel_seconds > 0.0 {
            self.contrast_per_second = sums.contrast / pixel_seconds;
        }
        if sums.tiles[1] > 0 {
            self.active_tiles = sums.tiles[0] as f64 / sums.tiles[1] as f64;
        }
        if self.changing.0.is_empty() {
            self.changing = (0..0, 0..0);
        }
    }
}

/// The longest time constant of a description's sheets, in seconds; 0 without any.
fn slowest_sheet(description: &Description) -> f64 {
    let surrounds = description
        .channels
        .iter()
        .filter_map(|c| c.surrounds.as_ref());
    let sheets = surrounds.flat_map(|s| &s.sheets);
    sheets.map(|sheet| sheet.tau).fold(0.0, f64::max)
}

impl Seen {
    fn of(frame: Frame, description: &Description) -> Result<Self, SensorError> {
        let Frame {
            index,
            seconds,
            light,
        } = frame;
        let mut signal = light.clone();
        for ((y, x), value) in signal.indexed_iter_mut() {
            let answer = description.response.apply(*value);
            *value = answer.map_err(|cause| SensorError::Light { index, y, x, cause })?;
        }
        Ok(Self {
            seconds,
            light,
            signal,
        })
    }
}
