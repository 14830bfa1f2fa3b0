//! Drive through a resistor sheet: the surround that the silicon makes itself.
//!
//! ```text
//! S(p) = c u(p) + sum over i of a_i H_i(p)          u = R(I), H_i the sheet's answer to u
//! ```
//!
//! One sheet with `c = 1`, `a = -1` is the Center Surround DVS (Delbruck et al., ICIP 2022);
//! two sheets of different space constants with `c = 0` are a difference of surrounds. Memory,
//! thresholds and noise come after the subtraction. A sheet moves between frames exactly
//! ([`crate::mesh::Flow`]), in double precision, and starts settled; one that takes no time is
//! solved for each frame ([`crate::mesh::Steady`]); `rule = "v2e"` steps it as v2e does. The
//! border is always the open end of the resistors.

use serde::Deserialize;

use super::{noise::Fault, signal::Light};
use crate::{
    mesh::{Between, Euler, Flow, MeshError, Sheet, Steady},
    number::Number,
    plane::{Plane, Size},
    rng::Key,
    sensor::SensorError,
};

/// The sheets of a channel, in place of a kernel.
#[derive(Clone, Debug, PartialEq)]
pub struct Surrounds {
    /// The gain of the pixel itself.
    pub centre: f64,
    /// The sheets, at least one.
    pub sheets: Vec<Surround>,
    /// How they are moved on.
    pub rule: SheetRule,
}

/// One sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surround {
    /// What it is multiplied by.
    pub gain: f64,
    /// Its space constants.
    pub sheet: Sheet,
    /// Its time constant C/g, in seconds; 0 settles at once.
    pub tau: f64,
    /// `sqrt(kT/C)`, in the signal's unit.
    pub noise: f64,
}

/// How sheets are moved on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SheetRule {
    /// Exactly; the signal is a straight line between frames.
    #[default]
    Ramp,
    /// Exactly; the later frame is there right after the earlier.
    Step,
    /// v2e's Euler steps, which stop early, from a sheet that starts as the first frame.
    V2e,
}

/// The sheets as they stand in a sensor file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct Written {
    lambda: Option<f64>,
    lambda_y: Option<f64>,
    tau_us: Option<f64>,
    noise: Option<f64>,
    centre: Option<f64>,
    sheets: Option<Vec<WrittenSheet>>,
    #[serde(default)]
    rule: SheetRule,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct WrittenSheet {
    gain: f64,
    lambda: f64,
    lambda_y: Option<f64>,
    #[serde(default)]
    tau_us: f64,
    #[serde(default)]
    noise: f64,
}

impl Written {
    /// Checks what was written; `gain` is the channel's.
    pub(super) fn checked(self, gain: f64) -> Result<Surrounds, Fault> {
        let rule = self.rule;
        let (centre, sheets) = match (self.lambda, self.sheets) {
            (Some(lambda), None) => {
                let sheet = WrittenSheet {
                    gain: -1.0,
                    lambda,
                    lambda_y: self.lambda_y,
                    tau_us: self.tau_us.unwrap_or(0.0),
                    noise: self.noise.unwrap_or(0.0),
                };
                (self.centre.unwrap_or(1.0), vec![sheet])
            }
            (None, Some(sheets)) if !sheets.is_empty() => {
                for (key, given) in [
                    ("lambda-y", self.lambda_y),
                    ("tau-us", self.tau_us),
                    ("noise", self.noise),
                ] {
                    if given.is_some() {
                        return Err(fault(
                            key,
                            format!("{key} stands beside sheets"),
                            "give it inside each of the sheets",
                        ));
                    }
                }
                (self.centre.unwrap_or(1.0), sheets)
            }
            _ => {
                return Err(fault(
                    "mesh",
                    "a mesh has either one lambda, or a list of sheets".into(),
                    "write mesh = { lambda = 10, tau-us = 500 }, or mesh = { centre = 1, sheets = [{ gain = -1, lambda = 10 }] }",
                ));
            }
        };
        let centre = finite("centre", centre)? * gain;
        let sheets = sheets
            .into_iter()
            .map(|sheet| sheet.checked(gain, rule))
            .collect::<Result<_, _>>()?;
        Ok(Surrounds {
            centre: finite("centre", centre)?,
            sheets,
            rule,
        })
    }
}

impl WrittenSheet {
    fn checked(self, gain: f64, rule: SheetRule) -> Result<Surround, Fault> {
        let sheet = Sheet::anisotropic(self.lambda_y.unwrap_or(self.lambda), self.lambda);
        let sheet = sheet.map_err(|e| {
            let advice =
                "give a number of pixels, 0 or more: λ² is transverse over lateral resistance";
            fault("lambda", e.to_string(), advice)
        })?;
        let positive = |key, value: f64| {
            if value >= 0.0 && value.is_finite() {
                Ok(value)
            } else {
                let message = format!("mesh.{key} is {value}");
                Err(fault(key, message, "give a finite number, 0 or more"))
            }
        };
        let noise = positive("noise", self.noise)?;
        if rule == SheetRule::V2e && (noise > 0.0 || sheet.lambdas().0 != sheet.lambdas().1) {
            return Err(fault(
                "rule",
                "v2e's sheet has one space constant and no noise".into(),
                "use rule = \"ramp\", or leave noise and lambda-y out",
            ));
        }
        Ok(Surround {
            gain: finite("gain", finite("gain", self.gain)? * gain)?,
            sheet,
            tau: positive("tau-us", self.tau_us)? * 1e-6,
            noise,
        })
    }
}

fn finite(key: &'static str, value: f64) -> Result<f64, Fault> {
    if value.is_finite() {
        return Ok(value);
    }
    let message = format!("mesh.{key}, times the channel's gain, is {value}");
    Err(fault(key, message, "give a finite number"))
}

fn fault(key: &'static str, message: String, advice: &str) -> Fault {
    Fault {
        key,
        message,
        advice: advice.into(),
    }
}

/// The sheets of a sensor while it runs.
#[derive(Clone, Debug)]
pub(super) struct Sheets {
    name: String,
    seed: u64,
    signal: Plane<f64>,
    /// Time of the frame before, in seconds.
    before: Option<f64>,
    /// For each channel that has sheets.
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
    /// A sheet that takes no time, and where it stands.
    Settled(Box<(Steady, Plane<f64>)>),
    Exact(Box<Flow>),
    V2e(Euler),
}

impl Sheets {
    /// The sheets of a sensor; `None` if it has none.
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

    /// Takes in a frame.
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
            let seed = Key::raw(self.seed).nth(channel as u64 + 1).bits();
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

    /// Row `y` of the drive of a channel, if it has sheets.
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
                    flow = flow.with_noise(noise, Key::raw(seed).with_mixed(n as u64).bits());
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

/// What a channel sees of row `y`: its sheets if it has some, else what `kernel` makes of it.
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
