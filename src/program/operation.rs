//! What the host can do, and the areas of the array that it can name.

use crate::{
    event::{Polarity, readout::scan::Order},
    isa::{Analog, Digital},
};

/// Operations of the host.
#[derive(Clone, Debug, PartialEq)]
pub enum Host {
    /// Drive the global input with a value on the ADC scale (LSB).
    LoadIn {
        /// The value in LSB, -128 to 127.
        value: f64,
    },
    /// Read the set pixels of a one-bit register as events, column by column from the
    /// chip's origin (top right), rows downward, or from another corner; the register is left as
    /// it is.
    ScanEvents {
        /// The one-bit register that is read.
        source: Digital,
        /// The sign that these events carry.
        polarity: Polarity,
        /// The kind of cell that they carry.
        channel: u8,
        /// Slots asked; later events are dropped and counted. Cost is proportional to this.
        slots: u32,
        /// From which corner.
        order: Order,
        /// Whether it goes row by row, and not column by column.
        by_rows: bool,
    },
    /// Read an analogue register through the ADC, for the caller to look at.
    ReadAnalog {
        /// The analogue register that is read.
        source: Analog,
    },
    /// As [`Host::LoadIn`], without the host's calibration of the DAC.
    LoadInRaw {
        /// The value in LSB, -128 to 127.
        value: f64,
    },
    /// Drive the global input with a raw DAC code.
    LoadDac {
        /// The code, 0 to 4095.
        code: u16,
    },
    /// One sample of an analogue register through the ADC.
    ReadPixel {
        /// The analogue register that is read.
        source: Analog,
        /// The pixel's row, the chip's count.
        row: u16,
        /// The pixel's column, the chip's count.
        column: u16,
    },
    /// Samples of an analogue register on a grid of pixels through the ADC.
    ScanAnalog {
        /// The analogue register that is read.
        source: Analog,
        /// Corners of the grid.
        window: Window,
        /// Rows and columns from one sample to the next, each at least 1.
        step: (u16, u16),
    },
    /// Eight by eight values that stand for the whole array.
    ScanBlocks {
        /// The analogue register that is read.
        source: Analog,
        /// The mean of each block; else one sample of each.
        mean: bool,
    },
    /// The bits of a one-bit register, whole rows.
    ScanDigital {
        /// The one-bit register that is read.
        source: Digital,
        /// First row, the chip's count.
        first_row: u16,
        /// Last row, inclusive.
        last_row: u16,
        /// The sign and kind of the events that the host makes of the set bits; none where it
        /// only looks at them.
        events: Option<(Polarity, u8)>,
    },
    /// The smallest box that holds every set pixel: its top right and bottom left corner.
    ScanBoundingBox {
        /// The one-bit register that is read.
        source: Digital,
    },
    /// A sum over the array; proportional, not equal, to the true sum.
    GlobalSum {
        /// The analogue register that is read.
        source: Analog,
        /// Over which pixels, and how.
        over: SumOver,
    },
    /// Whether any of the pixels of a pattern is set.
    GlobalOr {
        /// The one-bit register that is read.
        source: Digital,
        /// The pixels that are asked.
        pattern: Pattern,
    },
    /// An estimate of the number of set pixels: the bits become an analogue plane whose sum
    /// is taken.
    GlobalCount {
        /// The one-bit register that is read.
        source: Digital,
        /// The analogue register that is overwritten for it.
        temporary: Analog,
        /// Over which grid.
        over: SumOver,
    },
    /// Set a one-bit register inside an area and clear it outside.
    Load {
        /// The one-bit register that is set.
        target: Digital,
        /// Where it becomes 1.
        area: Area,
    },
    /// Let the address decoder drive SELECT; a rectangle drives RECT as well.
    Select {
        /// The pixels that are chosen.
        area: Area,
    },
    /// What is drawn from here on goes to this register.
    DrawBegin {
        /// The one-bit register that shapes are drawn in.
        target: Digital,
    },
    /// Draw one shape: its pixels become 1, the others stay.
    Draw {
        /// The register of the [`Host::DrawBegin`] before.
        target: Digital,
        /// The shape.
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
        /// Row, the chip's count.
        row: i32,
        /// Column, the chip's count.
        column: i32,
    },
    /// One pixel; nothing when it lies off the array.
    Point {
        /// Row, the chip's count.
        row: i32,
        /// Column, the chip's count.
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
