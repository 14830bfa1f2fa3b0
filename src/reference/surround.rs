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

use super::signal::Light;
use crate::{
    config::{Fault, Key, Kind, Node, Place, Range, Read, Section, Table},
    mesh::{Between, Euler, Flow, MeshError, Sheet, Steady},
    number::Number,
    plane::{Plane, Size},
    rng::Hash,
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
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SheetRule {
    /// Exactly; the signal is a straight line between frames.
    #[default]
    Ramp,
    /// Exactly; the later frame is there right after the earlier.
    Step,
    /// v2e's Euler steps, which stop early, from a sheet that starts as the first frame.
    V2e,
}

const NOT_NEGATIVE: Kind = Kind::Number(Range::NOT_NEGATIVE);

const LAMBDA_Y: Key = Key::optional(
    "lambda-y",
    NOT_NEGATIVE,
    "space constant down the columns; as lambda when left out",
)
.unit("px");

const TAU: Key = Key::with_default(
    "tau-us",
    NOT_NEGATIVE,
    "0",
    "time constant C/g; 0 settles at once",
)
.unit("us");

const NOISE: Key = Key::with_default(
    "noise",
    NOT_NEGATIVE,
    "0",
    "sqrt(kT/C), in the unit of the signal",
);

/// The words of [`SheetRule`], in its order.
pub const RULES: &[&str] = &["ramp", "step", "v2e"];

/// The keys of a channel's `mesh`.
pub const MESH: Table = Table {
    one_of: &["lambda", "sheets"],
    keys: &[
        Key::optional(
            "lambda",
            NOT_NEGATIVE,
            "space constant of the one sheet; its square is transverse over lateral resistance",
        )
        .unit("px")
        .example("lambda = 10"),
        LAMBDA_Y,
        TAU,
        NOISE,
        Key::with_default(
            "centre",
            Kind::Number(Range::FINITE),
            "1",
            "gain of the pixel itself",
        ),
        Key::optional(
            "sheets",
            Kind::List {
                of: &Kind::Table(&SHEET),
                least: 1,
                most: usize::MAX,
            },
            "several sheets in place of one",
        )
        .example("sheets = [{ gain = -1, lambda = 10 }]"),
        Key::with_default(
            "rule",
            Kind::Choice(RULES),
            "\"ramp\"",
            "how the sheets are moved on",
        ),
    ],
};

const SHEET: Table = Table::new(&[
    Key::required(
        "gain",
        Kind::Number(Range::FINITE),
        "what it is multiplied by",
    )
    .example("gain = -1"),
    Key::required("lambda", NOT_NEGATIVE, "its space constant")
        .unit("px")
        .example("lambda = 10"),
    LAMBDA_Y,
    TAU,
    NOISE,
]);

impl Surrounds {
    /// The sheets that a checked table of [`MESH`] states; `gain` is the channel's.
    ///
    /// # Errors
    /// When they contradict each other, or are too large times the gain.
    pub(super) fn read(node: Node<'_>, gain: f64) -> Read<Self> {
        let mesh = Section::new(node, &MESH);
        let rules = [SheetRule::Ramp, SheetRule::Step, SheetRule::V2e];
        let rule = mesh.word("rule", &rules)?.unwrap_or_default();
        let sheets = if mesh.get("lambda").is_some() {
            vec![Surround::read(&mesh, -1.0, gain, rule)?]
        } else {
            for key in ["lambda-y", "tau-us", "noise"] {
                if let Some(given) = mesh.get(key) {
                    let message = format!("{key} stands beside sheets");
                    let advice = "give it inside each of the sheets";
                    return Err(fault(given.place(), message, advice));
                }
            }
            let sheets = mesh.tables("sheets").into_iter();
            sheets
                .map(|sheet| Surround::read(&sheet, sheet.number("gain")?, gain, rule))
                .collect::<Read<_>>()?
        };
        let centre = mesh.number("centre")?;
        Ok(Self {
            centre: times("centre", centre, gain, mesh.place_of("centre"))?,
            sheets,
            rule,
        })
    }
}

impl Surround {
    fn read(section: &Section<'_>, own: f64, gain: f64, rule: SheetRule) -> Read<Self> {
        let lambda = section.number("lambda")?;
        let down = section.maybe_number("lambda-y");
        let sheet = Sheet::anisotropic(down.unwrap_or(lambda), lambda).map_err(|e| {
            let advice =
                "give a number of pixels, 0 or more: λ² is transverse over lateral resistance";
            fault(section.place_of("lambda"), e.to_string(), advice)
        })?;
        let noise = section.number("noise")?;
        if rule == SheetRule::V2e && (noise > 0.0 || sheet.lambdas().0 != sheet.lambdas().1) {
            return Err(fault(
                section.place(),
                "v2e's sheet has one space constant and no noise",
                "use rule = \"ramp\", or leave noise and lambda-y out",
            ));
        }
        Ok(Self {
            gain: times("gain", own, gain, section.place())?,
            sheet,
            tau: section.number("tau-us")? * 1e-6,
            noise,
        })
    }
}

/// A factor times the channel's gain.
fn times(key: &str, factor: f64, gain: f64, place: Place) -> Read<f64> {
    let product = factor * gain;
    if product.is_finite() {
        return Ok(product);
    }
    let message = format!("mesh.{key}, times the channel's gain, is {product}");
    Err(fault(place, message, "give a finite number"))
}

fn fault(place: Place, message: impl Into<String>, advice: &str) -> Fault {
    Fault::error(place, message, "here").help(advice)
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
