//! What a program says about itself: settings at the top (`//!`), expectation at the bottom
//! (`//=`). Both are TOML inside comments, so that the file stays a text for the chip.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::{
    config::{
        Fault, File, Key, Kind, Name, Node, Place, Range, Read, Section, Spelling, Table,
        on_one_line, schema,
    },
    kernel,
    limit::ARRAY_SIDE,
    number::Format,
};

const SEE: &str = "docs/guides and the shipped programs show what can stand here";

/// The settings at the top of a program.
const SETTINGS_FILE: File = File {
    title: "settings of a program of amacrine: its lines that begin with //!",
    kind: Kind::Table(&SETTINGS),
    see: SEE,
};

/// The expectation at the bottom of a program.
const EXPECTATION_FILE: File = File {
    title: "expectation of a program of amacrine: its lines that begin with //=",
    kind: Kind::Table(&EXPECTATION),
    see: SEE,
};

/// JSON Schema of the settings of a program; that of its expectation is `$defs/expectation` in
/// it.
#[must_use]
pub fn json_schema() -> serde_json::Value {
    let mut settings = schema::file(&SETTINGS_FILE);
    let expectation = schema::file(&EXPECTATION_FILE);
    schema::add(
        &mut settings,
        "$defs",
        serde_json::json!({"expectation": expectation}),
    );
    settings
}

/// Any number: whoever uses it says what it may be.
const NUMBER: Kind = Kind::Number(Range::FREE);

/// The name of an arithmetic.
const DOMAIN: Kind = Kind::Spelled(&Spelling {
    what: "exact, f32, f16, bf16, qM.N (for instance q8.8) or silicon, in quotes",
    // As `PATTERN` of number formats, or that.
    pattern: "",
    holds: |name| name == "silicon" || name.parse::<Format>().is_ok(),
});

const WHOLE: Kind = Kind::Whole {
    least: 0,
    most: i64::MAX as u64,
};

const SETTINGS: Table = Table::new(&[
    Key::optional("title", Kind::Text, "the program in one line"),
    Key::optional(
        "chip",
        Kind::Text,
        "the chip that it is for; SCAMP-5 when left out",
    ),
    Key::optional(
        "image",
        Kind::Text,
        "a picture or scene to run it on, relative to the program's folder, or a pattern",
    ),
    Key::optional("fps", Kind::Number(Range::POSITIVE), "frames per second").unit("Hz"),
    Key::optional(
        "frames",
        Kind::Whole {
            least: 1,
            most: i64::MAX as u64,
        },
        "how many frames to run of `image`, of a still picture or of the dark; another clip is shown whole",
    ),
    Key::optional(
        "size",
        Kind::List {
            of: &Kind::Whole {
                least: 1,
                most: ARRAY_SIDE as u64,
            },
            least: 2,
            most: 2,
        },
        "height and width of the array",
    )
    .unit("px"),
    Key::optional("domain", DOMAIN, "the arithmetic"),
    Key::optional(
        "clip",
        Kind::Flag,
        "whether every store is limited to the register's range",
    ),
    Key::optional(
        "edge",
        Kind::Number(Range::FINITE),
        "the value of analogue registers off the array",
    )
    .unit("LSB"),
    Key::optional(
        "channels",
        Kind::Whole {
            least: 0,
            most: u8::MAX as u64,
        },
        "kinds of cells whose events it reads out",
    ),
    Key::optional(
        "names",
        Kind::List {
            of: &Kind::Name,
            least: 1,
            most: u8::MAX as usize,
        },
        "what these kinds are called, in their order, in files of events",
    ),
    Key::optional(
        "const",
        Kind::Map(&NUMBER),
        "constants, as `const` states them",
    ),
    Key::optional(
        "computes",
        Kind::Table(&COMPUTES),
        "the linear map that it computes, for a comparison with the reference",
    ),
]);

const COMPUTES: Table = Table::new(&[
    Key::required(
        "kernel",
        kernel::ROWS,
        "rows of weights, from the north; rows and columns are odd in number",
    )
    .example("kernel = [[0, -1, 0], [-1, 4, -1], [0, -1, 0]]"),
    Key::required(
        "scale",
        Kind::NONZERO,
        "from light (0 to 255) times weights to LSB",
    )
    .example("scale = 1"),
    Key::optional(
        "threshold",
        Kind::Text,
        "the constant by which the drive must have moved since the last event",
    ),
    Key::optional(
        "step",
        Kind::Number(Range::POSITIVE),
        "the memory holds the drive in steps of so many LSB, each as its middle",
    ),
    Key::optional(
        "register",
        Kind::Text,
        "the register that holds the drive, in programs without events",
    ),
]);

const EXPECTATION: Table = Table::new(&[
    Key::optional(
        "words",
        Kind::Table(&Table::new(&[
            Key::required("init", WHOLE, "of `init`"),
            Key::required("frame", WHOLE, "of one frame"),
        ])),
        "instruction words",
    ),
    Key::optional(
        "events",
        Kind::Table(&Table::new(&[
            Key::required("on", WHOLE, "ON events"),
            Key::required("off", WHOLE, "OFF events"),
        ])),
        "events over all frames",
    ),
    Key::optional(
        "registers",
        Kind::Map(&Kind::Table(&SUMMARY)),
        "registers after the last frame, by name",
    ),
]);

const SUMMARY: Table = Table::new(&[
    Key::required("min", NUMBER, "lowest value"),
    Key::required("max", NUMBER, "highest value"),
    Key::required("sum", NUMBER, "sum over the array"),
]);

/// The settings of a program; all can be left out.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Settings {
    /// The program in one line.
    pub title: Option<String>,
    /// The chip that it is for; SCAMP-5 when left out.
    pub chip: Option<String>,
    /// A picture or scene to run it on, relative to the program's folder or a pattern.
    pub image: Option<String>,
    /// Frames per second.
    pub fps: Option<f64>,
    /// How many frames to run.
    pub frames: Option<u64>,
    /// Height and width of the array, in pixels.
    pub size: Option<(usize, usize)>,
    /// The arithmetic.
    pub domain: Option<String>,
    /// Whether every store is limited to the register's range.
    pub clip: Option<bool>,
    /// The value of analogue registers off the array, in LSB.
    pub edge: Option<f64>,
    /// Kinds of cells whose events it reads out.
    pub channels: Option<u8>,
    /// What these kinds are called, in their order; empty where nobody says so.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub names: Vec<String>,
    /// Constants, as `const` states them.
    #[serde(rename = "const")]
    pub constants: BTreeMap<String, f64>,
    /// The linear map that it computes, for a comparison with the reference.
    pub computes: Option<Computes>,
}

/// `drive(p) = scale * sum over d of kernel(d) * light(p + d)`, correlation, row 0 is north.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Computes {
    /// Rows of weights, from the north; rows and columns are odd in number.
    pub kernel: Vec<Vec<f64>>,
    /// From light (0 to 255) times weights to LSB.
    pub scale: f64,
    /// The drive is compared with its value at the last event; an event happens when it has
    /// moved by more than this constant, in LSB.
    pub threshold: Option<String>,
    /// The memory holds the drive in steps of so many LSB, each as its middle: a change is known
    /// within half a step.
    pub step: Option<f64>,
    /// The register that holds the drive, in programs without events.
    pub register: Option<String>,
}

/// What a program gives, for a test that compares and can bless.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Expectation {
    /// Instruction words.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub words: Option<ExpectedWords>,
    /// Events over all frames.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub events: Option<ExpectedEvents>,
    /// Registers after the last frame, by name.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub registers: BTreeMap<String, Summary>,
}

/// Expected instruction words.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct ExpectedWords {
    /// Of `init`.
    pub init: u64,
    /// Of one frame.
    pub frame: u64,
}

/// Expected events.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct ExpectedEvents {
    /// ON events.
    pub on: u64,
    /// OFF events.
    pub off: u64,
}

/// A register in three numbers; bits count as 0 and 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Summary {
    /// Lowest value.
    pub min: f64,
    /// Highest value.
    pub max: f64,
    /// Sum over the array.
    pub sum: f64,
}

impl Expectation {
    /// The lines below a program, without `//=`, that say this.
    ///
    /// # Errors
    /// Only when a number cannot be written as TOML.
    pub fn lines(&self) -> Result<Vec<String>, toml::ser::Error> {
        let text = toml::to_string(self)?;
        Ok(text
            .lines()
            .map(|line| {
                if line.is_empty() {
                    String::new()
                } else {
                    format!(" {line}")
                }
            })
            .collect())
    }
}

impl Settings {
    /// The line of a head that says the names of the kinds, which vendor C++ has as a comment; empty
    /// where there are none.
    #[must_use]
    pub fn names_line(&self) -> String {
        if self.names.is_empty() {
            return String::new();
        }
        let names: Vec<String> = self.names.iter().map(|name| on_one_line(name)).collect();
        format!("//! names = [{}]\n", names.join(", "))
    }

    /// The settings of the lines above a program; `at` is the byte at which each line begins in
    /// the file. Nothing is set when something is wrong with them.
    pub(super) fn read(lines: &[String], at: &[usize], faults: &mut Vec<Fault>) -> Self {
        commented(&SETTINGS_FILE, lines, at, faults, Self::stated)
    }

    fn stated(root: Node<'_>) -> Read<Self> {
        let top = Section::new(root, &SETTINGS);
        let size: Vec<_> = top
            .list("size")
            .into_iter()
            .filter_map(Node::as_whole)
            .collect();
        let constants = top.entries("const").into_iter();
        Ok(Self {
            title: top.maybe_text("title"),
            chip: top.maybe_text("chip"),
            image: top.maybe_text("image"),
            fps: top.maybe_number("fps"),
            frames: top.maybe_whole("frames"),
            size: match size.as_slice() {
                [height, width] => Some((*height as usize, *width as usize)),
                _ => None,
            },
            domain: top.maybe_text("domain"),
            clip: top.get("clip").and_then(Node::as_flag),
            edge: top.maybe_number("edge"),
            channels: top.maybe_whole("channels").map(|n| n as u8),
            names: { top.list("names").into_iter() }
                .filter_map(|name| name.as_text().map(str::to_owned))
                .collect(),
            constants: constants
                .filter_map(|(name, value)| Some((name.text.to_owned(), value.as_number()?)))
                .collect(),
            computes: top
                .table("computes")
                .map(|it| Computes::stated(&it))
                .transpose()?,
        })
    }
}

impl Computes {
    fn stated(computes: &Section<'_>) -> Read<Self> {
        Ok(Self {
            kernel: computes.need("kernel")?.as_rows().unwrap_or_default(),
            scale: computes.number("scale")?,
            threshold: computes.maybe_text("threshold"),
            step: computes.maybe_number("step"),
            register: computes.maybe_text("register"),
        })
    }
}

impl Expectation {
    /// The expectation of the lines below a program, as [`Settings::read`].
    pub(super) fn read(lines: &[String], at: &[usize], faults: &mut Vec<Fault>) -> Self {
        commented(&EXPECTATION_FILE, lines, at, faults, Self::stated)
    }

    fn stated(root: Node<'_>) -> Read<Self> {
        let top = Section::new(root, &EXPECTATION);
        let words = |it: Section<'_>| {
            let (init, frame) = (it.whole("init")?, it.whole("frame")?);
            Ok(ExpectedWords { init, frame })
        };
        let events = |it: Section<'_>| {
            let (on, off) = (it.whole("on")?, it.whole("off")?);
            Ok(ExpectedEvents { on, off })
        };
        let summary = |(name, node): (Name<'_>, Node<'_>)| {
            let it = Section::new(node, &SUMMARY);
            let (min, max, sum) = (it.number("min")?, it.number("max")?, it.number("sum")?);
            Ok((name.text.to_owned(), Summary { min, max, sum }))
        };
        let registers = top.entries("registers").into_iter();
        Ok(Self {
            words: top.table("words").map(words).transpose()?,
            events: top.table("events").map(events).transpose()?,
            registers: registers.map(summary).collect::<Read<_>>()?,
        })
    }
}

/// Reads TOML from comment lines.
fn commented<T: Default>(
    file: &File,
    lines: &[String],
    at: &[usize],
    faults: &mut Vec<Fault>,
    stated: fn(Node<'_>) -> Read<T>,
) -> T {
    let text = lines.join("\n");
    let read = file.document(&text);
    let read = read.and_then(|document| stated(document.root()).map_err(|fault| vec![fault]));
    read.unwrap_or_else(|wrong| {
        let place = |place: Place| {
            Place::new(
                in_file(place.start, lines, at),
                in_file(place.end, lines, at),
            )
        };
        faults.extend(wrong.into_iter().map(|fault| Fault {
            place: place(fault.place),
            ..fault
        }));
        T::default()
    })
}

/// From a byte of the joined lines to a byte of the file.
fn in_file(byte: usize, lines: &[String], at: &[usize]) -> usize {
    let mut start = 0;
    let mut last = 0;
    for (line, &at) in lines.iter().zip(at) {
        if byte <= start + line.len() {
            return at + (byte - start);
        }
        start += line.len() + 1;
        last = at + line.len();
    }
    last
}
