//! The keys of a study file: one table, from which the file is read, its JSON Schema is made,
//! and the documentation is checked.

use std::{fmt, str::FromStr};

use miette::Diagnostic;

pub use crate::config::Absent;

use crate::{
    array::Arithmetic,
    compile::DriveMemory,
    config::{self, Range},
    kernel::quantise::{self, Quantiser},
    number::{FORMAT_PATTERN, Format},
    photoreceptor::Response,
    plane::Size,
    reference::{Border, MemoryRule, Noise, PolarityRule, SheetRule, keys},
    scene::{Crop, Slice},
    study::sweep::{
        points::thresholds,
        tables::column::{
            Fixed,
            Part::{self, Field, Light, Model, Other, Sensor},
        },
    },
};

/// Which sensor a point is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Side {
    /// The float model.
    Reference,
    /// A compiled program on the array.
    Array,
    /// The float model behind a resistor mesh in place of a kernel.
    Mesh,
}

impl Side {
    /// All, in the order of the documentation.
    pub const ALL: [Self; 3] = [Self::Reference, Self::Array, Self::Mesh];

    /// As it is written in a study.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Reference => "reference",
            Self::Array => "array",
            Self::Mesh => "mesh",
        }
    }
}

impl fmt::Display for Side {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// One key whose values are an axis of the grid.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    /// As it is written.
    pub name: &'static str,
    /// The sides that have it.
    pub sides: &'static [Side],
    /// What it takes.
    pub kind: Kind,
    /// What it is when it is left out.
    pub default: Absent,
    /// What it is, with its unit.
    pub what: &'static str,
    /// Its columns in the results.
    pub columns: &'static [(Part, Fixed)],
}

/// A name in its canonical spelling; or what is wrong with it, and what to do.
pub type Spell = fn(&str) -> Result<String, (String, String)>;

/// What a key takes.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    /// The name of something that is opened.
    Name,
    /// A number from `least` on, or above it.
    Number {
        /// The least.
        least: f64,
        /// Whether the least itself is out.
        above: bool,
    },
    /// A whole number.
    Whole {
        /// The least.
        least: u64,
        /// The most.
        most: u64,
    },
    /// One of these words.
    Choice(&'static [&'static str]),
    /// A name with a grammar of its own, and the regular expression that it matches.
    Spelled(Spell, fn() -> String),
    /// `true` or `false`.
    Flag,
    /// A number, or `{ on, off, sigma }`.
    Threshold,
    /// `{ us, rule }`.
    Refractory,
    /// A preset, or the keys of a sensor file's `[noise]`.
    Noise,
    /// The `response` of a sensor file.
    Response,
}

/// A threshold: both signs in one number, or as in a sensor file, of each kind where they differ.
const THRESHOLD: config::Kind = config::Kind::Either {
    ways: &[
        config::Kind::Number(Range::POSITIVE),
        config::Kind::Table(&thresholds::TABLE),
    ],
    expected: "a number above 0, or { on = 8, off = 8, sigma = 0 }",
};

/// Noise: a preset, or as in a sensor file.
const NOISE: config::Kind = config::Kind::Either {
    ways: &[
        config::Kind::Choice(&["none", "noisy"]),
        config::Kind::Table(&Noise::TABLE),
    ],
    expected: "\"none\", \"noisy\" or { shot-hz = 5 }",
};

impl Kind {
    /// What one value is written as: where a sensor file has the key, as there.
    #[must_use]
    pub const fn value_kind(self) -> config::Kind {
        match self {
            Self::Name => config::Kind::Name,
            Self::Number { least, above } => config::Kind::Number(Range {
                above,
                ..Range::least(least)
            }),
            Self::Whole { least, most } => config::Kind::Whole { least, most },
            Self::Choice(words) => config::Kind::Choice(words),
            Self::Spelled(..) => config::Kind::Text,
            Self::Flag => config::Kind::Flag,
            Self::Threshold => THRESHOLD,
            Self::Refractory => config::Kind::Table(&keys::REFRACTORY),
            Self::Noise => NOISE,
            Self::Response => Response::KIND,
        }
    }
}

const ANY: &[Side] = &Side::ALL;
const FLOAT: &[Side] = &[Side::Reference, Side::Mesh];
const KERNEL: &[Side] = &[Side::Reference, Side::Array];
const REFERENCE: &[Side] = &[Side::Reference];
const ARRAY: &[Side] = &[Side::Array];
const MESH: &[Side] = &[Side::Mesh];

/// What slices, crops and sizes match.
const SLICE: &str =
    r"^([0-9]+|[0-9]+\.?[0-9]*(us|µs|ms|s))?\.\.([0-9]+|[0-9]+\.?[0-9]*(us|µs|ms|s))?$";
const CROP: &str = r"^[0-9]+x[0-9]+(\+[0-9]+\+[0-9]+)?$";
const SIZE: &str = "^[0-9]+x[0-9]+$";

/// The largest whole number that TOML has.
const MAX_INTEGER: u64 = i64::MAX as u64;

/// Every axis. The grid runs through them in this order, the last one fastest.
pub const KEYS: &[Key] = &[
    Key {
        name: "scene",
        sides: ANY,
        kind: Kind::Name,
        default: Absent::Required,
        what: "`bundled` (the clip that comes with the program), a clip, a `.npy`, a folder of pictures beside the study, or `pattern:NAME?key=value`",
        columns: &[Light.text("scene", "as it is named in the study")],
    },
    Key {
        name: "fps",
        sides: ANY,
        kind: Kind::Number {
            least: 0.0,
            above: true,
        },
        default: Absent::None,
        what: "frames per second, instead of what the scene says",
        columns: &[Light.real("fps", "frames per second of the scene, before any are inserted")],
    },
    Key {
        name: "frames",
        sides: ANY,
        kind: Kind::Whole {
            least: 2,
            most: MAX_INTEGER,
        },
        default: Absent::None,
        what: "only so many frames of the scene, at least 2; all when left out",
        columns: &[Light.whole("frames", "frames of the source, where the study says so")],
    },
    Key {
        name: "range",
        sides: ANY,
        kind: Kind::Choice(&["auto", "limited", "full"]),
        default: Absent::Is("\"auto\""),
        what: "which samples are black and white: 16 and 235, or all; `auto` takes what the file says, as `--range` of `amacrine run`",
        columns: &[Light.text("range", "which samples are black and white, where the study says so")],
    },
    Key {
        name: "transfer",
        sides: ANY,
        kind: Kind::Choice(&[
            "as-coded",
            "auto",
            "linear",
            "srgb",
            "bt709",
            "gamma22",
            "gamma28",
            "smpte240m",
        ]),
        default: Absent::Is("\"as-coded\""),
        what: "how the light was coded, to be undone; as `--transfer` of `amacrine run`",
        columns: &[Light.text("transfer", "the transfer that is undone, where the study says so")],
    },
    Key {
        name: "scale",
        sides: ANY,
        kind: Kind::Number {
            least: 0.0,
            above: true,
        },
        default: Absent::None,
        what: "what the numbers of a `.npy` are multiplied by: 255 where they are 0 to 1",
        columns: &[Light.real("scale", "what the numbers of an array are multiplied by")],
    },
    Key {
        name: "slice",
        sides: ANY,
        kind: Kind::Spelled(slice, || SLICE.to_owned()),
        default: Absent::None,
        what: "only these frames of the scene, as `--slice` of `amacrine run`: `\"2s..5s\"`, `\"500ms..\"` or, in numbers of frames, `\"..100\"`; `frames` counts from the first of them",
        columns: &[Light.text("slice", "which frames of the scene, where the study says so")],
    },
    Key {
        name: "crop",
        sides: ANY,
        kind: Kind::Spelled(crop, || CROP.to_owned()),
        default: Absent::None,
        what: "only this part of each picture, as `--crop`: `\"256x256\"` in its middle, or `\"256x256+10+20\"` from its left and its top",
        columns: &[Light.text("crop", "which part of each picture, where the study says so")],
    },
    Key {
        name: "resize",
        sides: ANY,
        kind: Kind::Spelled(resize, || SIZE.to_owned()),
        default: Absent::None,
        what: "so many larger pixels, as `--resize`: `\"64x48\"`, each with the mean of the light that falls on it; what is cut off is cut off before",
        columns: &[Light.text("resize", "to what size it is averaged, where the study says so")],
    },
    Key {
        name: "upsample",
        sides: ANY,
        kind: Kind::Number {
            least: 0.0,
            above: false,
        },
        default: Absent::Is("0"),
        what: "insert frames so that no pixel's light, of 255, plus 1 changes by more than this from one to the next, in ln units; 0 inserts none",
        columns: &[Light.real("upsample", "largest change of light (of 255) plus 1 between frames, in ln units; empty: no frames inserted")],
    },
    Key {
        name: "kernel",
        sides: KERNEL,
        kind: Kind::Name,
        default: Absent::Required,
        what: "a built-in kernel, or a kernel file (`.toml`, `.npy`) beside the study; a `.npy` of shape (K,k,k) or (K,1,k,k) is one sensor of K kinds of cells",
        columns: &[
            Field.text("kernel", "as it is named in the study"),
            Other.whole("kinds", "kinds of cells: kernels of the file"),
        ],
    },
    Key {
        name: "lambda",
        sides: MESH,
        kind: Kind::Number {
            least: 0.0,
            above: false,
        },
        default: Absent::Required,
        what: "space constant of the resistor mesh, in pixels",
        columns: &[Field.real("lambda", "space constant of the mesh, pixels")],
    },
    Key {
        name: "lambda-y",
        sides: MESH,
        kind: Kind::Number {
            least: 0.0,
            above: false,
        },
        default: Absent::None,
        what: "space constant down the columns, in pixels; as `lambda` when left out",
        columns: &[Field.real("lambda_y", "space constant down the columns, pixels, where it is another")],
    },
    Key {
        name: "tau-us",
        sides: MESH,
        kind: Kind::Number {
            least: 0.0,
            above: false,
        },
        default: Absent::Is("0"),
        what: "time constant of the mesh, in microseconds; 0 settles at once",
        columns: &[Field.real("tau_us", "time constant of the mesh, microseconds")],
    },
    Key {
        name: "threshold",
        sides: ANY,
        kind: Kind::Threshold,
        default: Absent::Required,
        what: "an event where kernel times light (0 to 255) moved by more than this; a number, or `{ on = 8, off = 8, sigma = 0 }` with the deviation of its mismatch, each of which may be a list of one for each kind. Under a logarithmic response in ln units",
        columns: &[
            Field.real("threshold_on", "light units (0 to 255) times kernel; ln units under a logarithmic response; empty where kinds differ"),
            Field.real("threshold_off", "the same, a positive magnitude"),
            Other.real("threshold_sigma", "deviation of the threshold's mismatch, same unit"),
            Field.text("thresholds", "the thresholds of each kind, as in the study, where kinds differ"),
        ],
    },
    Key {
        name: "response",
        sides: FLOAT,
        kind: Kind::Response,
        default: Absent::Is("\"identity\""),
        what: "the photoreceptor, as in a sensor file. Thresholds stay in light units under `{ linear = … }`",
        columns: &[Model.text("response", "photoreceptor, as in a sensor file")],
    },
    Key {
        name: "border",
        sides: REFERENCE,
        kind: Kind::Choice(Border::WORDS),
        default: Absent::Is("\"zero\""),
        what: "what the kernel reads off the array; the array itself reads zero",
        columns: &[Model.text("border", "what the kernel reads off the array")],
    },
    Key {
        name: "memory",
        sides: FLOAT,
        kind: Kind::Choice(&FLOAT_MEMORIES),
        default: Absent::Is("\"filtered-snap\""),
        what: "what an event does to the memory, as in a sensor file",
        columns: &[Model.text("rule", "what an event does to the memory: the `memory` of a sensor file")],
    },
    Key {
        name: "shared",
        sides: REFERENCE,
        kind: Kind::Flag,
        default: Absent::Is("false"),
        what: "one memory of the pixel for all kinds, with `memory = \"raw-snap\"`, as in a sensor file",
        columns: &[Model.text("shared", "true: one memory of the pixel for all kinds of a float sensor")],
    },
    Key {
        name: "polarity",
        sides: FLOAT,
        kind: Kind::Choice(PolarityRule::WORDS),
        default: Absent::Is("\"filtered\""),
        what: "where the sign of an event comes from, as in a sensor file",
        columns: &[Model.text("polarity", "where the sign of an event comes from")],
    },
    Key {
        name: "refractory",
        sides: FLOAT,
        kind: Kind::Refractory,
        default: Absent::Is("{ us = 0 }"),
        what: "dead time after an event, `{ us = 1000, rule = \"dead-time\" }` or `rule = \"authors\"`, in microseconds",
        columns: &[
            Sensor.real("refractory_us", "dead time, microseconds"),
            Sensor.text("refractory_rule", "dead-time or authors"),
        ],
    },
    Key {
        name: "noise",
        sides: FLOAT,
        kind: Kind::Noise,
        default: Absent::Is("\"none\""),
        what: "`\"none\"`, `\"noisy\"` (the `[noise]` of `sensors/dvs-noisy.toml`), or a table with the keys of a sensor file's `[noise]`",
        columns: &[Sensor.text("noise", "none, or the keys of a sensor file's `[noise]`")],
    },
    Key {
        name: "format",
        sides: FLOAT,
        kind: Kind::Spelled(spelled::<Format>, || FORMAT_PATTERN.to_owned()),
        default: Absent::Is("\"f64\""),
        what: "number format of signals, weights and memory: f64, f32, f16, bf16, qM.N or qM.N-wrap (M + N = 8, 16 or 32)",
        columns: &[Sensor.text("format", "number format of a float sensor")],
    },
    Key {
        name: "solver",
        sides: MESH,
        kind: Kind::Choice(SheetRule::WORDS),
        default: Absent::Is("\"ramp\""),
        what: "how the mesh is moved on: the `rule` of a sensor file's `mesh`",
        columns: &[Sensor.text("solver", "how the mesh is moved on")],
    },
    Key {
        name: "chip",
        sides: ARRAY,
        kind: Kind::Name,
        default: Absent::Is("\"scamp5\""),
        what: "a shipped chip, or the folder of another beside the study",
        columns: &[Sensor.text("chip", "as it is named in the study")],
    },
    Key {
        name: "quantise",
        sides: ARRAY,
        kind: Kind::Spelled(quantiser, quantisers),
        default: Absent::Is("\"none\""),
        what: "the kernel in few values, as in `amacrine quantise --to`; `none`, or `exact` as `compile` calls it, takes its weights as they are",
        columns: &[Sensor.text("quantise", "quantiser of the kernel")],
    },
    Key {
        name: "sum",
        sides: ARRAY,
        kind: Kind::Choice(&["free", "zero", "kept"]),
        default: Absent::Is("\"kept\""),
        what: "what a quantised kernel must sum to",
        columns: &[Sensor.text("sum", "what the quantised kernel must sum to")],
    },
    Key {
        name: "memory",
        sides: ARRAY,
        kind: Kind::Spelled(remembered, || "^(analogue|shared|bits:0*[1-8])$".to_owned()),
        default: Absent::Is("\"analogue\""),
        what: "what is kept of the last events: `analogue` and `bits:N`, the drive of each kind in an analogue register or in N one-bit registers; `shared`, the pixel at the last event of any kind",
        columns: &[Sensor.text("kept_in", "what the array keeps of the last events, and where")],
    },
    Key {
        name: "readout",
        sides: ARRAY,
        kind: Kind::Choice(&["chip", "all"]),
        default: Absent::Is("\"chip\""),
        what: "`chip`: 4000 events of either sign a frame at most, more are dropped and counted; `all`: every event",
        columns: &[Sensor.text("readout", "chip: 4000 events of either sign a frame at most; all: every event")],
    },
    Key {
        name: "domain",
        sides: ARRAY,
        kind: Kind::Spelled(spelled::<Arithmetic>, arithmetic),
        default: Absent::Is("\"exact\""),
        what: "arithmetic of the array: exact, f32, f16, bf16, qM.N or qM.N-wrap (M + N = 8, 16 or 32), silicon",
        columns: &[Sensor.text("domain", "arithmetic of the array")],
    },
    Key {
        name: "schedule",
        sides: ARRAY,
        kind: Kind::Choice(&["plain", "tiled"]),
        default: Absent::Is("\"tiled\""),
        what: "in which order the array is worked on, which changes only the speed",
        columns: &[Sensor.text("schedule", "order of the array's work")],
    },
    Key {
        name: "seed",
        sides: ANY,
        kind: Kind::Whole {
            least: 0,
            most: MAX_INTEGER,
        },
        default: Absent::Is("0"),
        what: "chooses mismatch, noise and stochastic rounding; points without chance have none",
        columns: &[Other.whole("seed", "of mismatch, noise and stochastic rounding; empty where there is no chance")],
    },
];

impl Key {
    /// The keys of a side, in the order of the grid.
    pub fn on_side(side: Side) -> impl Iterator<Item = &'static Self> {
        KEYS.iter().filter(move |key| key.sides.contains(&side))
    }

    /// Whether it takes `{ from, to, steps }`.
    #[must_use]
    pub const fn ranges(&self) -> bool {
        matches!(
            self.kind,
            Kind::Number { .. } | Kind::Whole { .. } | Kind::Threshold
        )
    }
}

fn spelled<T>(name: &str) -> Result<String, (String, String)>
where
    T: FromStr + fmt::Display,
    T::Err: Diagnostic,
{
    match name.parse::<T>() {
        Ok(known) => Ok(known.to_string()),
        Err(fault) => {
            let help = fault.help().map(|help| help.to_string());
            Err((fault.to_string(), help.unwrap_or_default()))
        }
    }
}

fn slice(text: &str) -> Result<String, (String, String)> {
    part::<Slice>("slice", text)
}

fn crop(text: &str) -> Result<String, (String, String)> {
    part::<Crop>("crop", text)
}

/// A part of a scene.
fn part<T>(name: &str, text: &str) -> Result<String, (String, String)>
where
    T: FromStr<Err = String> + fmt::Display,
{
    let part = text.parse::<T>();
    part.map(|part| part.to_string())
        .map_err(|help| (format!("`{name}` is `{text}`"), help))
}

fn resize(text: &str) -> Result<String, (String, String)> {
    let size = Size::read(text).filter(|size| size.is_possible());
    size.map(|size| size.to_string()).ok_or_else(|| {
        let help = "give WIDTHxHEIGHT in pixels, such as 64x48";
        (format!("`resize` is `{text}`"), help.to_owned())
    })
}

fn quantiser(name: &str) -> Result<String, (String, String)> {
    // `exact` is the word of `compile --to` and of Python.
    if matches!(name, "none" | "exact") {
        return Ok("none".to_owned());
    }
    spelled::<Quantiser>(name).map_err(|(what, help)| (what, format!("none, {help}")))
}

/// What names of arithmetics match.
fn arithmetic() -> String {
    FORMAT_PATTERN.replacen("^(", "^(silicon|", 1)
}

/// What names of quantisers match.
fn quantisers() -> String {
    quantise::pattern().replacen("^(", "^(none$|exact$|", 1)
}

/// Memories of a float sensor in a study.
pub(super) const FLOAT_MEMORIES: [&str; 3] = [
    MemoryRule::FilteredSnap.word(),
    MemoryRule::FilteredStep.word(),
    MemoryRule::RawSnap.word(),
];

fn remembered(name: &str) -> Result<String, (String, String)> {
    match name.parse::<DriveMemory>() {
        Ok(memory) => Ok(memory.to_string()),
        _ if FLOAT_MEMORIES.contains(&name) => Err((
            format!("`{name}` is a memory of a float sensor, and this is that of the array"),
            "write it below the [[side]] of the float sensor; below that of the array give analogue, bits:N or shared".to_owned(),
        )),
        _ => Err((
            format!("`{name}` is no memory of the array"),
            "give analogue or bits:N with N from 1 to 8, whose rule is filtered-snap, or shared, whose rule is raw-snap"
                .to_owned(),
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn number_formats_are_those_of_their_list() {
        for (name, known) in [("format", Format::names()), ("domain", Arithmetic::names())] {
            let key = KEYS.iter().find(|key| key.name == name).unwrap();
            assert!(key.what.ends_with(&known), "{}", key.what);
        }
    }

    /// A study gives no kernel of the memory.
    #[test]
    fn float_memories_are_those_without_a_kernel() {
        let mut own = FLOAT_MEMORIES.to_vec();
        let all = { MemoryRule::ALL.iter() }.filter(|rule| !rule.has_kernel());
        let mut all: Vec<_> = all.map(|rule| rule.word()).collect();
        own.sort_unstable();
        all.sort_unstable();
        assert_eq!(own, all);
    }

    #[test]
    fn no_side_has_a_key_twice() {
        for side in Side::ALL {
            let mut names: Vec<_> = Key::on_side(side).map(|key| key.name).collect();
            let all = names.len();
            names.sort_unstable();
            names.dedup();
            assert_eq!(names.len(), all, "{side}");
        }
    }
}
