//! A kind of cell, where programs remember what it saw, and what it is called in their text.

use std::{
    fmt::{self, Write as _},
    str::FromStr,
};

use crate::{
    config::{UnknownWord, on_one_line},
    event::kind_names,
    isa::Device,
    kernel::Kernel,
};

/// One kind of cell.
#[derive(Clone, Debug, PartialEq)]
pub struct CellKind {
    /// What it is called.
    pub name: Option<String>,
    /// Its kernel, of dyadic weights.
    pub kernel: Kernel,
    /// The ON threshold: an event happens when kernel times light (0 to 255) has risen by more
    /// than this since the last event.
    pub on: f64,
    /// The OFF threshold, likewise for a fall.
    pub off: f64,
}

/// What a program remembers of the last events, and where.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DriveMemory {
    /// The drive of each kind, in an analogue register of its own (`filtered-snap`).
    #[default]
    Analogue,
    /// The pixel at the last event of any kind, in one analogue register for all (`raw-snap` with
    /// `shared = true`).
    Shared,
    /// The drive of each kind, in so many one-bit registers: the range of the drive in
    /// equal steps, each remembered as its middle. They do not decay, and leave analogue registers
    /// free; thresholds must be half a step at least.
    Bits(u8),
}

impl DriveMemory {
    /// The most bits of a drive.
    pub(super) const MOST_BITS: u8 = 8;
}

impl fmt::Display for DriveMemory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Analogue => f.write_str("analogue"),
            Self::Shared => f.write_str("shared"),
            Self::Bits(bits) => write!(f, "bits:{bits}"),
        }
    }
}

impl FromStr for DriveMemory {
    type Err = UnknownWord;

    /// `analogue`, `shared` or `bits:N`.
    fn from_str(word: &str) -> Result<Self, UnknownWord> {
        let bits = || {
            let bits = word.strip_prefix("bits:")?.parse().ok();
            bits.filter(|bits| (1..=Self::MOST_BITS).contains(bits))
        };
        match word {
            "analogue" => Ok(Self::Analogue),
            "shared" => Ok(Self::Shared),
            _ => bits().map(Self::Bits).ok_or_else(|| UnknownWord {
                word: word.to_owned(),
                what: "memory",
                help: format!(
                    "give analogue, shared, or bits:N with N from 1 to {}, such as bits:5",
                    Self::MOST_BITS
                ),
            }),
        }
    }
}

/// The number of a kind in names, where there are several.
pub(super) fn number(kinds: &[CellKind], i: usize) -> String {
    if kinds.len() > 1 {
        i.to_string()
    } else {
        String::new()
    }
}

/// The names of a kind's ON and OFF thresholds.
pub(super) fn constants(kinds: &[CellKind], i: usize) -> (String, String) {
    let number = number(kinds, i);
    if kinds[i].on == kinds[i].off {
        let both = format!("threshold{number}");
        return (both.clone(), both);
    }
    (
        format!("on_threshold{number}"),
        format!("off_threshold{number}"),
    )
}

/// Frames that a program runs by itself, of its own pattern.
pub const FRAMES: u64 = 8;

/// The settings at the head of a program.
pub(super) fn header(title: &str, device: &Device, kinds: &[CellKind]) -> String {
    let mut text = format!(
        "//! title = {}\n//! chip = {}\n//! image = \"pattern:disc?width=64&height=48\"\n//! frames = {FRAMES}\n//! channels = {}\n",
        on_one_line(title),
        on_one_line(device.name()),
        kinds.len()
    );
    let names = kind_names(kinds.iter().map(|kind| kind.name.as_deref()));
    if !names.is_empty() {
        let names: Vec<String> = names.iter().map(|name| on_one_line(name)).collect();
        let _ = writeln!(text, "//! names = [{}]", names.join(", "));
    }
    text
}

/// The constants of all thresholds, each in LSB of its kind's result, of this scale.
pub(super) fn thresholds(kinds: &[CellKind], scales: &[f64]) -> String {
    let mut text = String::new();
    for (i, (kind, scale)) in kinds.iter().zip(scales).enumerate() {
        let (on, off) = constants(kinds, i);
        let _ = writeln!(text, "const {on} = {:?};", kind.on * scale);
        if off != on {
            let _ = writeln!(text, "const {off} = {:?};", kind.off * scale);
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memories_are_read_as_they_are_written() {
        let bits = (1..=DriveMemory::MOST_BITS).map(DriveMemory::Bits);
        for memory in [DriveMemory::Analogue, DriveMemory::Shared]
            .into_iter()
            .chain(bits)
        {
            assert_eq!(memory.to_string().parse::<DriveMemory>(), Ok(memory));
        }
        for wrong in ["bits:0", "bits:9", "bits:", "bits", "analog"] {
            let unknown = wrong.parse::<DriveMemory>().unwrap_err();
            assert_eq!(unknown.to_string(), format!("`{wrong}` is no memory"));
        }
    }
}
