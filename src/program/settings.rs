//! What a program says about itself: settings at the top (`//!`), expectation at the bottom
//! (`//=`). Both are TOML inside comments, so that the file stays a text for the chip.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::config::{Fault, Place};
use crate::isa::toml_fault;

/// The settings of a program; all can be left out.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
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
    /// Constants, as `const` states them.
    #[serde(rename = "const")]
    pub constants: BTreeMap<String, f64>,
    /// The linear map that it computes, for a comparison with the reference.
    pub computes: Option<Computes>,
}

/// `drive(p) = scale * sum over d of kernel(d) * light(p + d)`, correlation, row 0 is north.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Computes {
    /// Rows of weights, from the north; rows and columns are odd in number.
    pub kernel: Vec<Vec<f64>>,
    /// From light (0 to 255) times weights to LSB.
    pub scale: f64,
    /// The drive is compared with its value at the last event; an event happens when it has
    /// moved by more than this constant, in LSB.
    pub threshold: Option<String>,
    /// The register that holds the drive, in programs without events.
    pub register: Option<String>,
}

/// What a program gives, for a test that compares and can bless.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
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
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExpectedWords {
    /// Of `init`.
    pub init: u64,
    /// Of one frame.
    pub frame: u64,
}

/// Expected events.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExpectedEvents {
    /// ON events.
    pub on: u64,
    /// OFF events.
    pub off: u64,
}

/// A register in three numbers; bits count as 0 and 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
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

/// Reads TOML from comment lines; `at` is the byte at which each line begins in the file.
pub(super) fn read<T: serde::de::DeserializeOwned + Default>(
    lines: &[String],
    at: &[usize],
    faults: &mut Vec<Fault>,
) -> T {
    let text = lines.join("\n");
    match toml::from_str(&text) {
        Ok(value) => value,
        Err(error) => {
            let fault = toml_fault(&error);
            let place = Place::new(
                in_file(fault.place.start, lines, at),
                in_file(fault.place.end, lines, at),
            );
            faults.push(Fault { place, ..fault });
            T::default()
        }
    }
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
