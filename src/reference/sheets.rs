//! The resistive grids of a sensor while it runs; [`super::surround`] has the equation.

use crate::{
    mesh::{Between, Euler, Flow, MeshError, Steady},
    number::Number,
    plane::{Plane, Size},
    rng::Hash,
    sensor::SensorError,
};

use super::{
    signal::Light,
    surround::{SheetRule, Surround, Surrounds},
};

/// The resistive grids of a sensor while it runs.
#[derive(Clone, Debug)]
pub(super) struct Sheets {
    name: String,
    seed: u64,
    signal: Plane<f64>,
    /// Time of the frame before, in seconds.
    before: Option<f64>,
    /// For each channel, its grids, if it has some.
    channels: Vec<Option<Running>>,
}

#[derive(Clone, Debug)]
struct Running {
    what: Surrounds,
    moved: Vec<Moved>,
    drive: Plane<f64>,
}

#[derive(Clone, Debug)]
enum Moved {
    /// A grid that settles at once: its solver and its state.
    Settled(Box<(Steady, Plane<f64>)>),
    Exact(Box<Flow>),
    V2e(Euler),
}

impl Sheets {
    /// The grids of a sensor; `None` if it has none.
    pub(super) fn new<'a>(
        name: &str,
        channels: impl Iterator<Item = Option<&'a Surrounds>>,
        size: Size,
        seed: u64,
    ) -> Option<Self> {
        let running = |what: &Surrounds| Running {
            what: what.clone(),
            moved: Vec::new(),
            drive: Plane::zeros(size.shape()),
        };
        let channels: Vec<_> = channels.map(|what| what.map(running)).collect();
        let any = channels.iter().any(Option::is_some);
        any.then(|| Self {
            name: name.to_owned(),
            seed,
            signal: Plane::zeros(size.shape()),
            before: None,
            channels,
        })
    }

    /// Advances the grids by a frame.
    ///
    /// # Errors
    /// When it holds light that the response is not defined for, or that cannot be summed.
    pub(super) fn see<N: Number>(
        &mut self,
        number: &N,
        light: Light<'_, N>,
    ) -> Result<(), SensorError> {
        let mut held = vec![N::ZERO; self.signal.ncols()];
        for (y, mut row) in self.signal.rows_mut().into_iter().enumerate() {
            light.row(y, &mut held)?;
            for (to, held) in row.iter_mut().zip(&held) {
                *to = number.value(*held);
            }
        }
        let seconds = light.frame.seconds;
        let passed = self.before.replace(seconds).map(|before| seconds - before);
        for (channel, running) in self.channels.iter_mut().enumerate() {
            let Some(running) = running else { continue };
            let seed = Hash::raw(self.seed).nth(channel as u64 + 1).bits();
            let seen = running.see(&self.signal, passed, seed);
            seen.map_err(|e| SensorError::Stopped {
                sensor: self.name.clone(),
                why: format!(
                    "frame {}, the mesh of channel {channel}: {e}",
                    light.frame.index
                ),
            })?;
        }
        Ok(())
    }

    /// Row `y` of the drive of a channel, if it has grids.
    pub(super) fn row(&self, channel: usize, y: usize) -> Option<&[f64]> {
        let running = self.channels.get(channel)?.as_ref()?;
        let (start, width) = (y * running.drive.ncols(), running.drive.ncols());
        running.drive.as_slice()?.get(start..start + width)
    }
}

impl Running {
    fn see(
        &mut self,
        signal: &Plane<f64>,
        passed: Option<f64>,
        seed: u64,
    ) -> Result<(), MeshError> {
        let between = match self.what.rule {
            SheetRule::Step => Between::Step,
            SheetRule::Ramp | SheetRule::V2e => Between::Ramp,
        };
        if let Some(passed) = passed {
            for moved in &mut self.moved {
                match moved {
                    Moved::Settled(at) => at.0.solve_into(signal, &mut at.1)?,
                    Moved::Exact(flow) => flow.advance(signal, passed, between)?,
                    Moved::V2e(euler) => euler.advance(signal, passed)?,
                }
            }
        } else {
            let begin = |(n, sheet): (usize, &Surround)| {
                let Surround {
                    sheet, tau, noise, ..
                } = *sheet;
                if self.what.rule == SheetRule::V2e {
                    return Ok(Moved::V2e(Euler::begin(sheet, tau, signal)?));
                }
                if tau <= 0.0 && noise <= 0.0 {
                    let mut steady = Steady::new(sheet, Size::of(signal))?;
                    let surround = steady.solve(signal)?;
                    return Ok(Moved::Settled(Box::new((steady, surround))));
                }
                let mut flow = Flow::settled(sheet, tau, signal)?;
                if noise > 0.0 {
                    flow = flow.with_noise(noise, Hash::raw(seed).with_mixed(n as u64).bits());
                }
                Ok(Moved::Exact(Box::new(flow)))
            };
            let sheets = self.what.sheets.iter().enumerate().map(begin);
            self.moved = sheets.collect::<Result<_, MeshError>>()?;
        }
        self.drive
            .zip_mut_with(signal, |drive, u| *drive = self.what.centre * u);
        for (Surround { gain, .. }, moved) in self.what.sheets.iter().zip(&self.moved) {
            let surround = match moved {
                Moved::Settled(at) => &at.1,
                Moved::Exact(flow) => flow.surround(),
                Moved::V2e(euler) => euler.surround(),
            };
            self.drive.scaled_add(*gain, surround);
        }
        Ok(())
    }
}

/// The drive of row `y` of a channel: by its grids if it has some, else by `kernel`.
pub(super) fn row<N: Number>(
    number: &N,
    sheets: Option<&Sheets>,
    (channel, y): (usize, usize),
    out: &mut [N::Held],
    kernel: impl FnOnce(&mut [N::Held]),
) {
    let Some(drive) = sheets.and_then(|sheets| sheets.row(channel, y)) else {
        return kernel(out);
    };
    for (to, drive) in out.iter_mut().zip(drive) {
        *to = number.hold(*drive);
    }
}
