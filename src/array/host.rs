//! What the micro-controller beside the array does: inputs, selections, drawing, readings.
//!
//! Registers are read through the ADC of [`Converters`]. Addresses are the chip's ([`Address`]);
//! what lies off the array is not there. Sums over the array are modelled as the ADC's view of
//! a mean.

use std::sync::Arc;

use super::{BitPlane, Converters, Domain, State, propagate};
use crate::{
    event::readout::scan::Address,
    isa::Analog,
    plane::{At, Size},
    program::{Area, Host, Pattern, Shape, SumOver, Window},
};

/// What a reading operation of the host gave.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reading {
    /// Line of the program text.
    pub line: u32,
    /// Where that operation is written, if that is an included file: `file:line`.
    pub origin: Option<Arc<str>>,
    /// What was read.
    pub values: Readings,
}

impl Reading {
    /// Where that operation is written: `line 7`, or `part.hpp:3` in an included file.
    #[must_use]
    pub fn stands(&self) -> String {
        match &self.origin {
            Some(origin) => origin.to_string(),
            None => format!("line {}", self.line),
        }
    }
}

/// Values that the host read, in the chip's order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Readings {
    /// ADC values, row by row from the top right corner, `columns` in a row.
    Analog {
        /// Values in a row.
        columns: usize,
        /// All of them.
        values: Vec<u8>,
    },
    /// Bits, row by row from the top right corner, `columns` in a row.
    Digital {
        /// Bits in a row.
        columns: usize,
        /// All of them.
        values: Vec<bool>,
    },
    /// The box around all set pixels; `None` where no pixel is set.
    Box(Option<Window>),
    /// A sum or an estimate.
    Sum(u32),
    /// Whether any pixel was set.
    Any(bool),
}

/// Executes an operation of the host, event readout excepted; the reading, where it is one.
pub(super) fn execute<D: Domain>(
    domain: &D,
    converters: &Converters,
    state: &mut State<D::Cell>,
    host: &Host,
) -> Option<Readings> {
    if let Some(cell) = input(domain, converters, host) {
        state.input = cell;
        return None;
    }
    let size = state.layout.size;
    match host {
        Host::Load { target, area } => {
            let bits = covered(*area, size);
            propagate::write(state, *target, &bits);
        }
        Host::Select { area } => {
            state.select = covered(*area, size);
            if matches!(area, Area::Rect(_)) {
                state.rect = state.select.clone();
            }
        }
        Host::Draw { target, shape } => {
            let mut bits = state.digital(*target).clone();
            draw(&mut bits, *shape, size);
            propagate::write(state, *target, &bits);
        }
        Host::GlobalCount {
            source,
            temporary,
            over,
        } => {
            for at in pixels(size) {
                let set = state.digital(*source).get(at.y, at.x);
                let cell = domain.hold(if set { converters.high } else { converters.low });
                state.analog_mut(*temporary)[at.y * size.width + at.x] = cell;
            }
            // Both grids answer on one scale.
            let scale = match over {
                SumOver::Grid8 => 4,
                SumOver::Grid4 | SumOver::Whole | SumOver::Sparse(_) => 1,
            };
            let sum = sum(domain, converters, state, *temporary, *over);
            return Some(Readings::Sum(sum / scale));
        }
        _ => return read(domain, converters, state, host),
    }
    None
}

/// What the global input holds after an operation that sets it.
pub(super) fn input<D: Domain>(
    domain: &D,
    converters: &Converters,
    host: &Host,
) -> Option<D::Cell> {
    match host {
        Host::LoadIn { value } => Some(domain.input(*value, true)),
        Host::LoadInRaw { value } => Some(domain.input(*value, false)),
        // Past the host's table, whose steps are coarser than the DAC's.
        Host::LoadDac { code } => Some(domain.hold(converters.drive(*code))),
        _ => None,
    }
}

/// The operations that only look.
fn read<D: Domain>(
    domain: &D,
    converters: &Converters,
    state: &State<D::Cell>,
    host: &Host,
) -> Option<Readings> {
    let size = state.layout.size;
    let samples = |source: Analog, window: Window, step: (u16, u16)| {
        let cells = state.analog(source);
        grid(size, window, step, |at| {
            converters.read(domain.value(&cells[at.y * size.width + at.x]))
        })
    };
    Some(match host {
        Host::ReadAnalog { source } => samples(*source, whole(size), (1, 1)),
        Host::ReadPixel {
            source,
            row,
            column,
        } => {
            let window = Window {
                top: *row,
                bottom: *row,
                right: *column,
                left: *column,
            };
            samples(*source, window, (1, 1))
        }
        Host::ScanAnalog {
            source,
            window,
            step,
        } => samples(*source, *window, *step),
        Host::ScanBlocks { source, mean } => Readings::Analog {
            columns: 8,
            values: (0..64)
                .map(|i| {
                    let pixels = block(i / 8, i % 8, size);
                    let pixels = pixels.take(if *mean { usize::MAX } else { 1 });
                    mean_of(domain, converters, state, *source, pixels)
                })
                .collect(),
        },
        Host::ScanDigital {
            source,
            first_row,
            last_row,
            ..
        } => {
            let bits = state.digital(*source);
            let rows = usize::from(*first_row)..(usize::from(*last_row) + 1).min(size.height);
            Readings::Digital {
                columns: size.width,
                values: rows
                    .flat_map(|y| (0..size.width).rev().map(move |x| bits.get(y, x)))
                    .collect(),
            }
        }
        Host::ScanBoundingBox { source } => {
            Readings::Box(bounding_box(state.digital(*source), size))
        }
        Host::GlobalSum { source, over } => {
            Readings::Sum(sum(domain, converters, state, *source, *over))
        }
        Host::GlobalOr { source, pattern } => {
            let bits = state.digital(*source);
            let mut pixels = pixels(size);
            Readings::Any(pixels.any(|at| bits.get(at.y, at.x) && matches(*pattern, at, size)))
        }
        _ => return None,
    })
}

/// The pixels of one of eight by eight blocks, each at least one pixel on a small array.
fn block(row: usize, column: usize, size: Size) -> impl Iterator<Item = At> {
    let part = |i: usize, n: usize| i * n / 8..((i + 1) * n / 8).max(i * n / 8 + 1);
    let columns = part(column, size.width);
    part(row, size.height).flat_map(move |row| {
        columns
            .clone()
            .filter_map(move |column| Address { column, row }.at(size))
    })
}

fn pixels(size: Size) -> impl Iterator<Item = At> {
    (0..size.height).flat_map(move |y| (0..size.width).map(move |x| At { y, x }))
}

fn whole(size: Size) -> Window {
    Window {
        top: 0,
        right: 0,
        bottom: (size.height - 1) as u16,
        left: (size.width - 1) as u16,
    }
}

fn grid(size: Size, window: Window, step: (u16, u16), value: impl Fn(At) -> u8) -> Readings {
    let along = |first: u16, last: u16, step: u16, end: usize| {
        (usize::from(first)..(usize::from(last) + 1).min(end)).step_by(usize::from(step.max(1)))
    };
    let rows = along(window.top, window.bottom, step.0, size.height);
    let columns = along(window.right, window.left, step.1, size.width);
    Readings::Analog {
        columns: columns.len(),
        values: rows
            .flat_map(|row| columns.clone().map(move |column| Address { column, row }))
            .filter_map(|address| address.at(size))
            .map(value)
            .collect(),
    }
}

fn mean_of<D: Domain>(
    domain: &D,
    converters: &Converters,
    state: &State<D::Cell>,
    source: Analog,
    pixels: impl Iterator<Item = At>,
) -> u8 {
    let cells = state.analog(source);
    let (mut sum, mut count) = (0.0, 0.0);
    for at in pixels {
        sum += domain.value(&cells[at.y * state.layout.size.width + at.x]);
        count += 1.0;
    }
    mean(converters, sum, count)
}

fn mean(converters: &Converters, sum: f64, count: f64) -> u8 {
    // No pixel, no current.
    if count == 0.0 {
        converters.read(0.0)
    } else {
        converters.read(sum / count)
    }
}

fn sum<D: Domain>(
    domain: &D,
    converters: &Converters,
    state: &State<D::Cell>,
    source: Analog,
    over: SumOver,
) -> u32 {
    let size = state.layout.size;
    let patterns = |n: usize| {
        let cells = state.analog(source);
        let mut bins = vec![(0.0, 0.0); n * n];
        for at in pixels(size) {
            let address = Address::from_pixel(at, size);
            let (sum, count) = &mut bins[address.row % n * n + address.column % n];
            *sum += domain.value(&cells[at.y * size.width + at.x]);
            *count += 1.0;
        }
        { bins.into_iter() }
            .map(|(sum, count)| u32::from(mean(converters, sum, count)))
            .sum()
    };
    match over {
        SumOver::Grid4 => patterns(4),
        SumOver::Grid8 => patterns(8),
        SumOver::Whole => mean_of(domain, converters, state, source, pixels(size)).into(),
        SumOver::Sparse(pattern) => {
            let members = pixels(size).filter(|at| matches(pattern, *at, size));
            mean_of(domain, converters, state, source, members).into()
        }
    }
}

fn bounding_box(bits: &BitPlane, size: Size) -> Option<Window> {
    let mut found: Option<Window> = None;
    for at in pixels(size).filter(|at| bits.get(at.y, at.x)) {
        let address = Address::from_pixel(at, size);
        let (row, column) = (address.row as u16, address.column as u16);
        let so_far = found.get_or_insert(Window {
            top: row,
            bottom: row,
            right: column,
            left: column,
        });
        so_far.top = so_far.top.min(row);
        so_far.bottom = so_far.bottom.max(row);
        so_far.right = so_far.right.min(column);
        so_far.left = so_far.left.max(column);
    }
    found
}

fn agrees(address: usize, with: u16, ignored: u16) -> bool {
    (address as u16 ^ with) & !ignored == 0
}

fn matches(pattern: Pattern, at: At, size: Size) -> bool {
    let address = Address::from_pixel(at, size);
    agrees(address.row, pattern.row, pattern.row_ignored)
        && agrees(address.column, pattern.column, pattern.column_ignored)
}

/// The pixels of an area.
fn covered(area: Area, size: Size) -> BitPlane {
    let mut bits = BitPlane::zeros(size);
    for at in pixels(size) {
        let address = Address::from_pixel(at, size);
        let (own_row, own_column) = (address.row, address.column);
        let inside = match area {
            Area::Point { row, column } => {
                own_row == usize::from(row) && own_column == usize::from(column)
            }
            Area::Rect(window) => {
                (usize::from(window.top)..=usize::from(window.bottom)).contains(&own_row)
                    && (usize::from(window.right)..=usize::from(window.left)).contains(&own_column)
            }
            Area::Pattern(pattern) => matches(pattern, at, size),
            Area::Row { row, ignored } => agrees(own_row, row, ignored),
            Area::Column { column, ignored } => agrees(own_column, column, ignored),
        };
        bits.set(at.y, at.x, inside);
    }
    bits
}

fn draw(bits: &mut BitPlane, shape: Shape, size: Size) {
    let mut dot = |row: i64, column: i64, wrap: bool| {
        let (row, column) = if wrap {
            (
                row.rem_euclid(size.height as i64),
                column.rem_euclid(size.width as i64),
            )
        } else {
            (row, column)
        };
        if let (Ok(row), Ok(column)) = (usize::try_from(row), usize::try_from(column))
            && let Some(at) = (Address { column, row }).at(size)
        {
            bits.set(at.y, at.x, true);
        }
    };
    let wide = |(row, column): (i32, i32)| (i64::from(row), i64::from(column));
    match shape {
        Shape::Pixel { row, column } => dot(row.into(), column.into(), true),
        Shape::Point { row, column } => dot(row.into(), column.into(), false),
        Shape::Rect { from, to } => {
            // Only what can lie on the array, however large the rectangle.
            let along = |a: i32, b: i32, end: usize| {
                i64::from(a.min(b)).max(0)..=i64::from(a.max(b)).min(end as i64 - 1)
            };
            for row in along(from.0, to.0, size.height) {
                for column in along(from.1, to.1, size.width) {
                    dot(row, column, false);
                }
            }
        }
        Shape::Line { from, to } => line(wide(from), wide(to), size, |row, column| {
            dot(row, column, false);
        }),
        Shape::Circle {
            centre,
            radius,
            wrap,
        } => {
            let (row, column) = wide(centre);
            // The midpoint circle: one octant, mirrored.
            let (mut along, mut across, mut error) =
                (i64::from(radius), 0i64, 1 - i64::from(radius));
            while along >= across {
                for (a, b) in [(along, across), (across, along)] {
                    for (sa, sb) in [(1, 1), (1, -1), (-1, 1), (-1, -1)] {
                        dot(row + sa * a, column + sb * b, wrap);
                    }
                }
                across += 1;
                if error < 0 {
                    error += 2 * across + 1;
                } else {
                    along -= 1;
                    error += 2 * (across - along) + 1;
                }
            }
        }
        Shape::Negate => bits.not(),
    }
}

/// The pixels nearest to a straight line, one a step along the longer axis; halves away from
/// the start. Steps whose pixel cannot lie on the array are left out beforehand.
fn line(from: (i64, i64), to: (i64, i64), size: Size, mut dot: impl FnMut(i64, i64)) {
    let (rows, columns) = (to.0 - from.0, to.1 - from.1);
    let length = rows.abs().max(columns.abs());
    let (start, way, end) = if rows.abs() >= columns.abs() {
        (from.0, rows.signum(), size.height as i64)
    } else {
        (from.1, columns.signum(), size.width as i64)
    };
    // Along the longer axis the place is `start + way · i`; keep it on the array.
    let (first, last) = match way {
        1 => (-start, end - 1 - start),
        -1 => (start - (end - 1), start),
        _ => (0, 0),
    };
    for i in first.max(0)..=last.min(length) {
        let part = |whole: i64| {
            let twice = 2 * i128::from(whole) * i128::from(i);
            let length = i128::from(length.max(1));
            let away = twice.abs() + length;
            (away.div_euclid(2 * length) * twice.signum()) as i64
        };
        dot(from.0 + part(rows), from.1 + part(columns));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(bits: &BitPlane, size: Size) -> Vec<(usize, usize)> {
        let on = pixels(size).filter(|at| bits.get(at.y, at.x));
        on.map(|at| {
            let address = Address::from_pixel(at, size);
            (address.row, address.column)
        })
        .collect()
    }

    fn drawn(shape: Shape, size: Size) -> Vec<(usize, usize)> {
        let mut bits = BitPlane::zeros(size);
        draw(&mut bits, shape, size);
        let mut on = set(&bits, size);
        on.sort_unstable();
        on
    }

    #[test]
    fn lines_are_as_drawn_by_hand() {
        let size = Size::new(5, 6);
        let line = |from, to| drawn(Shape::Line { from, to }, size);
        assert_eq!(line((0, 0), (2, 2)), [(0, 0), (1, 1), (2, 2)]);
        assert_eq!(line((4, 1), (4, 4)), [(4, 1), (4, 2), (4, 3), (4, 4)]);
        assert_eq!(line((3, 3), (3, 3)), [(3, 3)]);
        assert_eq!(
            line((0, 0), (1, 4)),
            [(0, 0), (0, 1), (1, 2), (1, 3), (1, 4)]
        );
        let far = i32::MAX;
        assert_eq!(line((2, -far), (2, far)).len(), 6, "clipped, and at once");
        assert_eq!(line((-far, -far), (far, far)).len(), 5);
    }

    #[test]
    fn a_circle_is_round_and_wraps() {
        let size = Size::new(7, 7);
        let circle = |centre, radius, wrap| {
            drawn(
                Shape::Circle {
                    centre,
                    radius,
                    wrap,
                },
                size,
            )
        };
        let small = circle((3, 3), 1, false);
        assert_eq!(small, [(2, 3), (3, 2), (3, 4), (4, 3)]);
        assert_eq!(circle((0, 0), 1, true), [(0, 1), (0, 6), (1, 0), (6, 0)]);
        assert_eq!(circle((0, 0), 1, false), [(0, 1), (1, 0)]);
        assert_eq!(circle((3, 3), 0, false), [(3, 3)]);
    }

    #[test]
    fn a_pattern_ignores_bits() {
        let size = Size::new(1, 256);
        let area = Area::Pattern(Pattern {
            row: 0,
            column: 3,
            row_ignored: 255,
            column_ignored: 192,
        });
        let columns: Vec<_> = set(&covered(area, size), size)
            .into_iter()
            .map(|c| c.1)
            .rev()
            .collect();
        assert_eq!(columns, [3, 67, 131, 195]);
    }
}
