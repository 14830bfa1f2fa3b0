//! The drive through a resistive grid: a surround that the silicon makes itself.
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

use crate::{
    config::{Fault, Key, Kind, Node, Place, Range, Read, Section, Table, listed},
    mesh::Sheet,
};

/// The resistive grids of a channel, in place of a kernel.
#[derive(Clone, Debug, PartialEq)]
pub struct Surrounds {
    /// The gain of the pixel itself.
    pub centre: f64,
    /// The sheets, at least one.
    pub sheets: Vec<Surround>,
    /// How they are advanced in time.
    pub rule: SheetRule,
}

/// One grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surround {
    /// The gain of its surround, `a_i`.
    pub gain: f64,
    /// Its space constants.
    pub sheet: Sheet,
    /// Its time constant C/g, in seconds; 0 settles at once.
    pub tau: f64,
    /// Thermal noise `sqrt(kT/C)` of a node, in the signal's unit.
    pub noise: f64,
}

listed! {
/// How grids are advanced in time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SheetRule {
    /// Exactly; the signal is a straight line between frames.
    #[default]
    Ramp = "ramp",
    /// Exactly; the later frame is there right after the earlier.
    Step = "step",
    /// v2e's Euler steps, which stop early, from a sheet that starts as the first frame.
    V2e = "v2e",
}
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
            Kind::Choice(SheetRule::WORDS),
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
        let rule = mesh.word("rule", SheetRule::ALL)?.unwrap_or_default();
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

impl Surrounds {
    /// What a file cannot state, and what to do.
    pub(super) fn odd(&self) -> Option<(String, &'static str)> {
        if self.sheets.is_empty() {
            return Some((
                "a mesh without sheets".to_owned(),
                "give one sheet at least",
            ));
        }
        let all = self.sheets.iter().flat_map(|sheet| {
            [
                ("gain", sheet.gain, Range::FINITE),
                ("tau", sheet.tau * 1e6, Range::NOT_NEGATIVE),
                ("noise", sheet.noise, Range::NOT_NEGATIVE),
            ]
        });
        let centre = ("centre", self.centre, Range::FINITE);
        let mut odd = std::iter::once(centre)
            .chain(all)
            .filter(|(_, value, range)| !range.holds(*value));
        if let Some((name, value, _)) = odd.next() {
            let help = "give finite numbers, times and noise of 0 or more";
            return Some((format!("a mesh with {name} of {value}"), help));
        }
        let alike = |sheet: &Surround| suits(self.rule, sheet.sheet, sheet.noise);
        (!self.sheets.iter().all(alike)).then(|| (V2E.0.to_owned(), V2E.1))
    }
}

/// Whether a rule knows such a sheet.
fn suits(rule: SheetRule, sheet: Sheet, noise: f64) -> bool {
    rule != SheetRule::V2e || (noise <= 0.0 && sheet.lambdas().0 == sheet.lambdas().1)
}

/// What v2e's rule does not know, and what to do.
const V2E: (&str, &str) = (
    "v2e's sheet has one space constant and no noise",
    "use rule = \"ramp\", or leave noise and lambda-y out",
);

impl Surround {
    fn read(section: &Section<'_>, own: f64, gain: f64, rule: SheetRule) -> Read<Self> {
        let lambda = section.number("lambda")?;
        let down = section.maybe_number("lambda-y");
        let sheet = Sheet::anisotropic(down.unwrap_or(lambda), lambda).map_err(|e| {
            let advice = miette::Diagnostic::help(&e).map(|help| help.to_string());
            fault(
                section.place_of("lambda"),
                e.to_string(),
                &advice.unwrap_or_default(),
            )
        })?;
        let noise = section.number("noise")?;
        if !suits(rule, sheet, noise) {
            return Err(fault(section.place(), V2E.0, V2E.1));
        }
        Ok(Self {
            gain: times("gain", own, gain, section.place())?,
            sheet,
            tau: from_micros(section.number("tau-us")?),
            noise,
        })
    }
}

/// A time of a file, in seconds.
pub(super) fn from_micros(us: f64) -> f64 {
    us * 1e-6
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
