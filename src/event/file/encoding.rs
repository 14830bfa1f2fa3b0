//! The encoding that the header of a Prophesee file names.

use super::Format;

/// An encoding that a line names: `% evt 3.0`, or `% format EVT3;height=720;width=1280`.
#[derive(Debug)]
pub struct Encoding {
    /// As the line has it.
    pub name: String,
    /// What that is, where it is read.
    pub format: Option<Format>,
}

impl Encoding {
    /// The keys of the lines.
    pub const KEYS: [&str; 2] = ["evt", "format"];

    /// What a line of a header names, if anything.
    pub fn of_line(line: &str) -> Option<Self> {
        let text = line.trim_start_matches('%').trim();
        let (key, value) = text.split_once([' ', ':'])?;
        let mut keys = Self::KEYS.iter();
        keys.find(|known| key.eq_ignore_ascii_case(known))?;
        Self::of_value(value)
    }

    /// What the value of one of the keys names, if it is not empty.
    pub fn of_value(value: &str) -> Option<Self> {
        let name = value.trim().split([';', ' ']).next()?;
        let format = match name.to_ascii_lowercase().as_str() {
            "" => return None,
            "2" | "2.0" | "evt2" => Some(Format::Evt2),
            "2.1" | "evt21" => Some(Format::Evt21),
            "3" | "3.0" | "evt3" => Some(Format::Evt3),
            _ => None,
        };
        let name = name.to_owned();
        Some(Self { name, format })
    }
}
