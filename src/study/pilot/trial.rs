//! A trial: models run side by side on the tiles of a draw, each with its own clock.

use crate::{
    event::Packet,
    mosaic::Mosaic,
    plane::Size,
    scene::{Frame, kept::Kept},
    sensor::{Sensor, SensorError},
    stop::Stop,
};

use super::{
    draw::Drawn,
    family::Family,
    look::{Grid, Look},
    spread::Parts,
    stage::{Between, Stage, StageFrame},
};

/// The scene on tiles, and what runs there.
pub(super) struct Trial<'a, F> {
    pub family: &'a F,
    pub kept: &'a Kept,
    pub between: Option<&'a Between>,
    pub grid: Grid,
    pub halo: usize,
    pub clock: &'a (dyn Fn() -> f64 + Sync),
    /// Whether to give up.
    pub stop: Stop,
}

/// A model on tiles.
#[derive(Debug)]
pub(super) struct Ran<M> {
    pub model: M,
    pub packet: Packet,
    /// Seconds that it took.
    pub seconds: f64,
    /// Frames that it saw in them.
    pub frames: u64,
    /// The same, as several measurements.
    pub parts: Parts,
    /// Why it was given up, if it was: its packet is then of part of the scene.
    pub given_up: Option<String>,
}

impl<M> Ran<M> {
    /// Seconds for a frame of the mosaic.
    pub fn per_frame(&self) -> f64 {
        if self.frames == 0 {
            0.0
        } else {
            self.seconds / self.frames as f64
        }
    }
}

/// The clock has passed the time of a trial.
struct Late;

fn give_up<M>(runs: &mut [Ran<M>]) {
    for ran in runs {
        ran.given_up = Some("the pilot took longer than it may".to_owned());
    }
}

/// The fewest tiles that stand for anything.
pub(super) const LEAST_TILES: usize = 12;

/// Frames that are not timed: they fill caches.
const UNCLOCKED: u64 = 2;

/// Columns of a mosaic, about: enough for wide vectors.
const COLUMNS: usize = 256;

impl<F: Family> Trial<'_, F> {
    /// How much goes on in each tile, for models of the family; below 0 where nothing can.
    pub fn activity(&self, look: &Look) -> Vec<f64> {
        let mut activity = look.seen_from(self.halo);
        if self.family.fires_alone() {
            for tile in &mut activity {
                *tile = tile.max(0.0);
            }
        }
        activity
    }

    /// Frames of the whole scene that a model sees.
    pub fn frames(&self, model: &F::Model) -> f64 {
        let [all, own] = Stage::frames(self.kept, self.between);
        let sees = self.family.sees_inserted(model);
        (if sees { all } else { own }) as f64
    }

    /// Seconds that a model takes for the whole scene on the tiles that it ran on.
    pub fn whole_scene(&self, ran: &Ran<F::Model>) -> f64 {
        ran.per_frame() * self.frames(&ran.model)
    }

    /// How much longer a frame of the whole sensor takes than one of a mosaic: work is shared by
    /// as many threads as a sensor has parts.
    pub fn larger_than(&self, mosaic: &Mosaic) -> f64 {
        let share = |size: Size| {
            let parts = self.family.parts(size).min(rayon::current_num_threads());
            size.pixels() as f64 / parts.max(1) as f64
        };
        share(self.kept.size()) / share(mosaic.size())
    }

    /// Of the seconds for light with the inserted frames and without, those for what a model sees.
    pub fn light_of(&self, light: [f64; 2], model: &F::Model) -> f64 {
        light[usize::from(!self.family.sees_inserted(model))]
    }

    /// The mosaic of some tiles.
    pub fn mosaic(&self, drawn: &[Drawn]) -> Mosaic {
        let corners = drawn.iter().map(|one| self.grid.corner(one.tile)).collect();
        let Grid { size, side } = self.grid;
        let across = COLUMNS / (side + 2 * self.halo);
        Mosaic::new(size, Size::new(side, side), self.halo, corners, across)
    }

    /// Pixels of a tile with its halo.
    pub const fn pixels(&self) -> usize {
        let side = self.grid.side + 2 * self.halo;
        side * side
    }

    /// Runs models on a mosaic for the first `frames` frames of the scene. After each frame of the
    /// scene `check` is told how many there were, and may give models up. When the clock passes
    /// `late` all that were made so far are given up.
    pub fn run(
        &self,
        models: &[F::Model],
        mosaic: &Mosaic,
        frames: usize,
        late: f64,
        mut check: impl FnMut(usize, &mut [Ran<F::Model>]),
    ) -> Result<Vec<Ran<F::Model>>, SensorError> {
        let is_late = || self.stop.is_asked() || (late.is_finite() && (self.clock)() > late);
        let mut sensors: Vec<Box<dyn Sensor + Send>> = Vec::new();
        let mut runs: Vec<Ran<F::Model>> = Vec::new();
        for model in models {
            // Programs on many small arrays take longer to be made than to run.
            if !runs.is_empty() && is_late() {
                give_up(&mut runs);
                return Ok(runs);
            }
            let sensor = self.family.on_tiles(model, mosaic)?;
            runs.push(Ran {
                model: model.clone(),
                packet: Packet::new(sensor.size(), sensor.channels()),
                seconds: 0.0,
                frames: 0,
                parts: Parts::default(),
                given_up: None,
            });
            sensors.push(sensor);
        }
        let stage = Stage::new(self.kept, self.between, mosaic, self.family.outside());
        let mut shown = 0;
        let played = stage.play(frames, |StageFrame { frame, own }| {
            let timed = frame.index >= UNCLOCKED;
            for (sensor, ran) in sensors.iter_mut().zip(&mut runs) {
                if is_late() {
                    return Err(Late);
                }
                let sees = own.is_some() || self.family.sees_inserted(&ran.model);
                if sees && ran.given_up.is_none() {
                    self.watch(&mut **sensor, ran, &frame, timed);
                }
            }
            if own.is_some() {
                shown += 1;
                check(shown, &mut runs);
            }
            Ok(())
        });
        if played.is_err() {
            give_up(&mut runs);
        }
        Ok(runs)
    }

    /// A model that cannot go on is given up: another may.
    fn watch(&self, sensor: &mut dyn Sensor, ran: &mut Ran<F::Model>, frame: &Frame, timed: bool) {
        let start = (self.clock)();
        if let Err(error) = sensor.watch(frame, &mut ran.packet) {
            ran.given_up = Some(error.to_string());
        } else if ran.packet.dropped.no_slot > 0 {
            ran.given_up = Some("slots of the readout are full in a tile".to_owned());
        }
        if timed {
            let seconds = (self.clock)() - start;
            ran.seconds += seconds;
            ran.frames += 1;
            ran.parts.add(seconds);
        }
    }
}
