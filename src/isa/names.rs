//! Names on a chip: registers, neighbours, lines.

use super::{
    Analog, Bit, Device, Digital, Direction, Registers, Source, Target, Value,
    operands::{Access, Cell, Terminal},
    row::neighbour_name,
};

impl Device {
    /// What a name means on this chip.
    #[must_use]
    pub fn value_of(&self, name: &str) -> Option<Value> {
        let Registers {
            analog,
            digital,
            aliases,
            ..
        } = self.registers();
        if let Some(at) = analog.iter().position(|n| n == name) {
            return Some(Value::Source(Source::Register(Analog(at as u8))));
        }
        if let Some(at) = digital.iter().position(|n| n == name) {
            return Some(Value::Bit(Bit::Register(Digital(at as u8))));
        }
        if let Some((_, register)) = aliases.iter().find(|(alias, _)| alias == name) {
            return Some(Value::Bit(Bit::Register(*register)));
        }
        FIXED_NAMES
            .iter()
            .find(|(fixed, _)| *fixed == name)
            .map(|(_, value)| value())
    }

    /// All names that mean something on this chip.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        let registers = self.registers();
        registers
            .analog
            .iter()
            .chain(&registers.digital)
            .chain(registers.aliases.iter().map(|(alias, _)| alias))
            .map(String::as_str)
            .chain(FIXED_NAMES.iter().map(|(name, _)| *name))
    }

    /// Name of an analogue register.
    #[must_use]
    pub fn analog_name(&self, register: Analog) -> String {
        let name = self.registers().analog.get(usize::from(register.0));
        name.cloned()
            .unwrap_or_else(|| format!("<analogue {}>", register.0))
    }

    /// Name of a one-bit register.
    #[must_use]
    pub fn digital_name(&self, register: Digital) -> String {
        let name = self.registers().digital.get(usize::from(register.0));
        name.cloned()
            .unwrap_or_else(|| format!("<digital {}>", register.0))
    }

    /// Name of an analogue source.
    #[must_use]
    pub fn source_name(&self, source: Source) -> String {
        match source {
            Source::Register(register) => self.analog_name(register),
            Source::Pix => "PIX".to_owned(),
            Source::In => "IN".to_owned(),
            Source::Neighbour(direction) => neighbour_name(direction).to_owned(),
        }
    }

    /// Name of an analogue target.
    #[must_use]
    pub fn target_name(&self, target: Target) -> String {
        match target {
            Target::Register(register) => self.analog_name(register),
            Target::Neighbour(direction) => neighbour_name(direction).to_owned(),
        }
    }

    /// Name of a one-bit source.
    #[must_use]
    pub fn bit_name(&self, bit: Bit) -> String {
        match bit {
            Bit::Register(register) => self.digital_name(register),
            Bit::Flag => "FLAG".to_owned(),
            Bit::Select => "SELECT".to_owned(),
            Bit::Rect => "RECT".to_owned(),
        }
    }
}

impl Cell {
    /// Its name on a chip.
    #[must_use]
    pub fn name(self, device: &Device) -> String {
        match self {
            Self::Analog(register) => device.analog_name(register),
            Self::Digital(register) => device.digital_name(register),
            Self::Flag => "FLAG".to_owned(),
        }
    }
}

impl Access {
    /// As the vendor writes it: `A`, `XN`, `PIX`, ….
    #[must_use]
    pub fn name(&self, device: &Device) -> String {
        let beside = Direction::ALL.into_iter().find(|d| d.step() == self.offset);
        match (self.terminal, beside) {
            (Terminal::Cell(Cell::Analog(_)), Some(direction)) => {
                device.source_name(Source::Neighbour(direction))
            }
            (Terminal::Cell(cell), _) => cell.name(device),
            (Terminal::Pix, _) => device.source_name(Source::Pix),
            (Terminal::In, _) => device.source_name(Source::In),
            (Terminal::Select, _) => device.bit_name(Bit::Select),
        }
    }
}

/// Whether programs can write a register of this name: letters, digits and `_`, no digit first, no
/// word that means something else in programs, in macros or in the vendor's C++.
#[must_use]
pub fn is_writable(name: &str) -> bool {
    let is_letter = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let begins = |c: char| is_letter(c) && !c.is_ascii_digit();
    name.starts_with(begins)
        && name.chars().all(is_letter)
        && !FIXED_NAMES.iter().any(|(fixed, _)| *fixed == name)
        && !WORDS.contains(&name)
}

/// Words of programs, of macros and of the vendor's C++.
const WORDS: &[&str] = &[
    "const", "init", "frame", "repeat", "macro", "host", "if", "else", "for", "while", "do",
    "switch", "case", "default", "break", "continue", "return", "goto", "new", "delete", "auto",
    "void", "bool", "char", "int", "float", "double", "NULL",
];

type FixedName = (&'static str, fn() -> Value);

/// Names that mean the same on every chip.
const FIXED_NAMES: &[FixedName] = &[
    ("PIX", || Value::Source(Source::Pix)),
    ("IN", || Value::Source(Source::In)),
    ("XN", || Value::Source(Source::Neighbour(Direction::North))),
    ("XE", || Value::Source(Source::Neighbour(Direction::East))),
    ("XS", || Value::Source(Source::Neighbour(Direction::South))),
    ("XW", || Value::Source(Source::Neighbour(Direction::West))),
    ("FLAG", || Value::Bit(Bit::Flag)),
    ("SELECT", || Value::Bit(Bit::Select)),
    ("RECT", || Value::Bit(Bit::Rect)),
    ("north", || Value::Directions(vec![Direction::North])),
    ("east", || Value::Directions(vec![Direction::East])),
    ("south", || Value::Directions(vec![Direction::South])),
    ("west", || Value::Directions(vec![Direction::West])),
    ("alldir", || Value::Directions(Direction::ALL.to_vec())),
    ("true", || Value::Number(1.0)),
    ("false", || Value::Number(0.0)),
];
