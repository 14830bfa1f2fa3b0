//! Programs of the array: text in, instruction words out.
//!
//! ```
//! use amacrine::{isa::Device, program::{Cost, Program}};
//!
//! let program = Program::parse("copy.scamp", "mov(A, B); // through NEWS")?;
//! let expansion = program.expand(&Device::scamp5(), &Default::default())?;
//! assert_eq!(Cost::of(&expansion.code.frame, &Device::scamp5()).words.0, 2);
//! # Ok::<(), amacrine::config::Faults>(())
//! ```

mod check;
mod cost;
mod effect;
mod expand;
mod host;
mod parse;
mod print;
mod reference;
mod settings;
pub mod syntax;
mod words;

use std::sync::Arc;

pub use crate::isa::Cell;
pub use check::for_each;
pub use cost::{Cost, host_us, stored};
pub use effect::{Effect, FlagState};
pub use expand::{Entry, Expanded, Expansion, Overrides};
pub use host::buffer;
pub use reference::reference;
pub use settings::{
    Computes, Expectation, ExpectedEvents, ExpectedWords, Settings, Summary, json_schema,
};
pub use syntax::Syntax;
pub use words::vendor_text;

use crate::{
    config::{Fault, Faults, Severity},
    event::Polarity,
    isa::{Analog, Device, Digital, Primitive},
};

/// A program: its text, taken apart.
#[derive(Clone, Debug)]
pub struct Program {
    /// Name of its file, for messages.
    pub file: String,
    /// Its text.
    pub text: Arc<str>,
    /// The text as a tree.
    pub syntax: Syntax,
    /// What it says about itself.
    pub settings: Settings,
    /// What it is expected to give.
    pub expectation: Expectation,
    /// What is wrong with the text itself.
    faults: Vec<Fault>,
}

impl Program {
    /// Reads a text; `file` is named in messages.
    ///
    /// # Errors
    /// All that is wrong with the text.
    pub fn parse(file: &str, text: &str) -> Result<Self, Faults> {
        let program = Self::read(file, text);
        Faults::check(file, text, program.faults.clone())?;
        Ok(program)
    }

    /// Reads as much of a text as can be read. What is wrong with it is said by
    /// [`Program::expand`], together with all that is wrong with its statements.
    #[must_use]
    pub fn read(file: &str, text: &str) -> Self {
        let parse::Parsed {
            syntax,
            header_at,
            footer_at,
            mut faults,
        } = parse::parse(text);
        let settings = Settings::read(&syntax.header, &header_at, &mut faults);
        let expectation = Expectation::read(&syntax.footer, &footer_at, &mut faults);
        Self {
            file: file.to_owned(),
            text: text.into(),
            syntax,
            settings,
            expectation,
            faults,
        }
    }

    /// Looks up every name on a chip, expands every macro, and checks the result.
    ///
    /// # Errors
    /// All that is wrong with the program on this chip, warnings included.
    pub fn expand(&self, device: &Device, overrides: &Overrides) -> Result<Expansion, Faults> {
        let settings = &self.settings.constants;
        let (expansion, mut faults) =
            expand::expand(&self.syntax, &self.text, settings, device, overrides);
        faults.extend(self.faults.iter().cloned());
        Faults::check(&self.file, &self.text, faults)?;
        Ok(expansion)
    }

    /// The warnings of an expansion, ready to be shown; `None` when there are none.
    #[must_use]
    pub fn warnings(&self, expansion: &Expansion) -> Option<Faults> {
        debug_assert!(
            expansion
                .warnings
                .iter()
                .all(|w| w.severity == Severity::Warning)
        );
        if expansion.warnings.is_empty() {
            return None;
        }
        Some(Faults::new(
            &self.file,
            &self.text,
            expansion.warnings.clone(),
        ))
    }

    /// The text with another expectation below it, nothing else changed: how a golden test
    /// blesses.
    ///
    /// # Errors
    /// Only when a number cannot be written as TOML.
    pub fn blessed(&self, expectation: &Expectation) -> Result<String, toml::ser::Error> {
        let body: Vec<&str> = self
            .text
            .lines()
            .filter(|line| !line.trim_start().starts_with("//="))
            .collect();
        let mut text = body.join("\n").trim_end().to_owned();
        text.push_str("\n\n");
        for line in expectation.lines()? {
            text.push_str("//=");
            text.push_str(&line);
            text.push('\n');
        }
        Ok(text)
    }
}

/// A program ready to run: every macro expanded into primitives.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Code {
    /// Run once, before the first frame.
    pub init: Vec<Step>,
    /// Run for every frame.
    pub frame: Vec<Step>,
}

/// One step of a program, with the line of the source text that it came from.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// What to do.
    pub action: Action,
    /// Line of the program text, from 1.
    pub line: u32,
}

/// What a step does.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// One instruction word on all pixels.
    Word(Primitive),
    /// Something that the host (the micro-controller beside the array) does.
    Host(Host),
    /// A body, several times.
    Repeat {
        /// How often.
        times: u32,
        /// What.
        body: Vec<Step>,
    },
}

/// Operations of the host.
#[derive(Clone, Debug, PartialEq)]
pub enum Host {
    /// Drive the global input with a value on the ADC scale (LSB).
    LoadIn {
        /// -128 to 127.
        value: f64,
    },
    /// Read the set pixels of a one-bit register as events, column by column from the
    /// chip's origin (top right), rows downward; the register is left as it is.
    ScanEvents {
        /// Which register.
        source: Digital,
        /// The sign that these events carry.
        polarity: Polarity,
        /// The kind of cell that they carry.
        channel: u8,
        /// Slots asked; later events are dropped and counted. Cost is proportional to this.
        slots: u32,
    },
    /// Read an analogue register through the ADC, for the caller to look at.
    ReadAnalog {
        /// Which register.
        source: Analog,
    },
    /// As [`Host::LoadIn`], without the host's calibration of the DAC.
    LoadInRaw {
        /// -128 to 127.
        value: f64,
    },
    /// Drive the global input with a raw DAC code.
    LoadDac {
        /// 0 to 4095.
        code: u16,
    },
    /// As [`Host::ScanEvents`], from another corner of the array.
    ScanEventsFrom {
        /// Which register.
        source: Digital,
        /// The sign that these events carry.
        polarity: Polarity,
        /// The kind of cell that they carry.
        channel: u8,
        /// Slots asked.
        slots: u32,
        /// Columns from the last to the first.
        columns_reversed: bool,
        /// Rows from the last to the first.
        rows_reversed: bool,
    },
    /// One sample of an analogue register through the ADC.
    ReadPixel {
        /// Which register.
        source: Analog,
        /// The pixel's row, the chip's count.
        row: u16,
        /// The pixel's column, the chip's count.
        column: u16,
    },
    /// Samples of an analogue register on a grid of pixels through the ADC.
    ScanAnalog {
        /// Which register.
        source: Analog,
        /// Corners of the grid.
        window: Window,
        /// Rows and columns from one sample to the next, each at least 1.
        step: (u16, u16),
    },
    /// Eight by eight values that stand for the whole array.
    ScanBlocks {
        /// Which register.
        source: Analog,
        /// The mean of each block; else one sample of each.
        mean: bool,
    },
    /// The bits of a one-bit register, whole rows.
    ScanDigital {
        /// Which register.
        source: Digital,
        /// First row, the chip's count.
        first_row: u16,
        /// Last row, inclusive.
        last_row: u16,
    },
    /// The smallest box that holds every set pixel: its top right and bottom left corner.
    ScanBoundingBox {
        /// Which register.
        source: Digital,
    },
    /// A sum over the array; proportional, not equal, to the true sum.
    GlobalSum {
        /// Which register.
        source: Analog,
        /// Over which pixels, and how.
        over: SumOver,
    },
    /// Whether any of the pixels of a pattern is set.
    GlobalOr {
        /// Which register.
        source: Digital,
        /// Which pixels.
        pattern: Pattern,
    },
    /// An estimate of the number of set pixels: the bits become an analogue plane whose sum
    /// is taken.
    GlobalCount {
        /// Which register.
        source: Digital,
        /// The analogue register that is overwritten for it.
        temporary: Analog,
        /// Over which grid.
        over: SumOver,
    },
    /// Set a one-bit register inside an area and clear it outside.
    Load {
        /// Which register.
        target: Digital,
        /// Where it becomes 1.
        area: Area,
    },
    /// Let the address decoder drive SELECT; a rectangle drives RECT as well.
    Select {
        /// Which pixels.
        area: Area,
    },
    /// What is drawn from here on goes to this register.
    DrawBegin {
        /// Which register.
        target: Digital,
    },
    /// Draw one shape: its pixels become 1, the others stay.
    Draw {
        /// The register of the [`Host::DrawBegin`] before.
        target: Digital,
        /// What.
        shape: Shape,
    },
    /// The end of drawing.
    DrawEnd,
}

/// Two opposite corners, both inclusive, in the chip's count: rows down from the top,
/// columns leftwards from the right.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Window {
    /// First row.
    pub top: u16,
    /// First column.
    pub right: u16,
    /// Last row.
    pub bottom: u16,
    /// Last column.
    pub left: u16,
}

/// Pixels whose address equals `row` and `column` in all bits but the ignored ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Pattern {
    /// Row, the chip's count.
    pub row: u16,
    /// Column, the chip's count.
    pub column: u16,
    /// Bits of the row that do not count.
    pub row_ignored: u16,
    /// Bits of the column that do not count.
    pub column_ignored: u16,
}

/// Pixels that the address decoder can choose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Area {
    /// One pixel.
    Point {
        /// Row, the chip's count.
        row: u16,
        /// Column, the chip's count.
        column: u16,
    },
    /// A filled rectangle.
    Rect(Window),
    /// A regular pattern.
    Pattern(Pattern),
    /// One whole row, or all rows that agree in the bits that are not ignored.
    Row {
        /// Row, the chip's count.
        row: u16,
        /// Bits that do not count.
        ignored: u16,
    },
    /// One whole column, or all columns that agree in the bits that are not ignored.
    Column {
        /// Column, the chip's count.
        column: u16,
        /// Bits that do not count.
        ignored: u16,
    },
}

/// The pixels of a global sum.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SumOver {
    /// The ADC values of a sparse grid of 4 by 4 pixels.
    Grid4,
    /// The ADC values of a sparse grid of 8 by 8 pixels.
    Grid8,
    /// All pixels at once, one ADC value.
    Whole,
    /// The pixels of a pattern at once, one ADC value.
    Sparse(Pattern),
}

/// What the host draws. Coordinates are the chip's count and may lie off the array.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Shape {
    /// One pixel; coordinates wrap around the array.
    Pixel {
        /// Row.
        row: i32,
        /// Column.
        column: i32,
    },
    /// One pixel; nothing when it lies off the array.
    Point {
        /// Row.
        row: i32,
        /// Column.
        column: i32,
    },
    /// A filled rectangle, corners inclusive.
    Rect {
        /// First corner: row, column.
        from: (i32, i32),
        /// Second corner: row, column.
        to: (i32, i32),
    },
    /// A straight line, ends inclusive.
    Line {
        /// First end: row, column.
        from: (i32, i32),
        /// Second end: row, column.
        to: (i32, i32),
    },
    /// The outline of a circle.
    Circle {
        /// Centre: row, column.
        centre: (i32, i32),
        /// Radius in pixels.
        radius: u16,
        /// Parts off the array come in again on the other side.
        wrap: bool,
    },
    /// Every pixel the other way.
    Negate,
}
