//! Host operations: parsed from a statement, and printed as one.

use super::{Area, Host, Pattern, Shape, SumOver, Window};
use crate::{
    event::{Polarity, readout::scan::Order},
    isa::{Analog, Device, Digital, Figure, HostKind, Value, signature::Bound},
};

/// The polarity and channel that a buffer's name stands for: `off…` is OFF, anything else is
/// ON; a number at the end is the channel, else it is 0.
#[must_use]
pub fn buffer(name: &str) -> Option<(Polarity, u8)> {
    let polarity = if name.to_ascii_lowercase().starts_with("off") {
        Polarity::Off
    } else {
        Polarity::On
    };
    let digits = name.len() - name.trim_end_matches(|c: char| c.is_ascii_digit()).len();
    let channel = match &name[name.len() - digits..] {
        "" => 0,
        number => number.parse().ok()?,
    };
    Some((polarity, channel))
}

/// The polarity and channel of a buffer of bits that are events: it is called `on` or `off`, with
/// a channel's number or without. Bits in a buffer of any other name are only looked at.
fn event_buffer(name: &str) -> Option<(Polarity, u8)> {
    let word = name.trim_end_matches(|c: char| c.is_ascii_digit());
    ["on", "off"]
        .contains(&word.to_ascii_lowercase().as_str())
        .then(|| buffer(name))?
}

/// The values of a statement, by position; defaults are already in.
struct Values<'a>(&'a [Bound]);

impl Values<'_> {
    fn value(&self, at: usize) -> Option<&Value> {
        self.0.get(at)?.first()
    }
    fn number(&self, at: usize) -> Option<f64> {
        self.value(at)?.number()
    }
    fn u16(&self, at: usize) -> Option<u16> {
        Some(self.number(at)? as u16)
    }
    fn i32(&self, at: usize) -> Option<i32> {
        Some(self.number(at)? as i32)
    }
    fn analog(&self, at: usize) -> Option<Analog> {
        self.value(at)?.analog()
    }
    fn digital(&self, at: usize) -> Option<Digital> {
        self.value(at)?.digital()
    }
    fn window(&self, at: usize) -> Option<Window> {
        Some(Window {
            top: self.u16(at)?,
            right: self.u16(at + 1)?,
            bottom: self.u16(at + 2)?,
            left: self.u16(at + 3)?,
        })
    }
    fn pattern(&self, at: usize) -> Option<Pattern> {
        Some(Pattern {
            row: self.u16(at)?,
            column: self.u16(at + 1)?,
            row_ignored: self.u16(at + 2)?,
            column_ignored: self.u16(at + 3)?,
        })
    }
    fn corners(&self, at: usize) -> Option<((i32, i32), (i32, i32))> {
        Some((
            (self.i32(at)?, self.i32(at + 1)?),
            (self.i32(at + 2)?, self.i32(at + 3)?),
        ))
    }
}

/// The operation that a statement of this name asks for; `drawing` is the register of the
/// `scamp5_draw_begin` before; `device` says how far the array goes where nothing else does.
///
/// # Errors
/// What is wrong with it, in words.
pub(super) fn build(
    (kind, name): (HostKind, &str),
    bound: &[Bound],
    drawing: Option<Digital>,
    device: &Device,
) -> Result<Host, String> {
    // A chip's own row may have other parameters than the operation needs.
    let misfit = || format!("the chip's row of `{name}` lacks a parameter");
    if kind == HostKind::Draw && drawing.is_none() {
        return Err(format!(
            "`{name}` needs a `scamp5_draw_begin(register);` before it"
        ));
    }
    if kind == HostKind::ScanEvents {
        return scan_events(name, &Values(bound));
    }
    let last_row = (device.value(Figure::Height) - 1.0) as u16;
    operation((kind, name), &Values(bound), drawing, last_row).ok_or_else(misfit)
}

fn scan_events(statement: &str, values: &Values<'_>) -> Result<Host, String> {
    let misfit = || "the chip's row of scan_events lacks a parameter".to_owned();
    let by_rows = statement.ends_with("_rc");
    let source = values.digital(0).ok_or_else(misfit)?;
    let name = match values.value(1) {
        Some(Value::Word(name)) => name.as_str(),
        _ => "",
    };
    let (polarity, channel) = buffer(name).ok_or_else(|| {
        format!(
            "`{name}` names channel {}: channels are 0 to 255",
            name.trim_start_matches(|c: char| !c.is_ascii_digit())
        )
    })?;
    let number = |at| values.number(at).ok_or_else(misfit);
    let slots = number(2)? as u32;
    Ok(Host::ScanEvents {
        source,
        polarity,
        channel,
        slots,
        order: Order {
            from_left: number(3)? != 0.0,
            from_bottom: number(4)? != 0.0,
        },
        by_rows,
    })
}

fn operation(
    (kind, name): (HostKind, &str),
    values: &Values<'_>,
    drawing: Option<Digital>,
    last_row: u16,
) -> Option<Host> {
    Some(match kind {
        HostKind::LoadIn => Host::LoadIn {
            value: values.number(0)?,
        },
        HostKind::LoadInRaw => Host::LoadInRaw {
            value: values.number(0)?,
        },
        HostKind::LoadDac => Host::LoadDac {
            code: values.u16(0)?,
        },
        HostKind::ScanEvents => scan_events(name, values).ok()?,
        HostKind::ReadAnalog => Host::ReadAnalog {
            source: values.analog(0)?,
        },
        HostKind::ReadPixel => Host::ReadPixel {
            source: values.analog(0)?,
            row: values.u16(1)?,
            column: values.u16(2)?,
        },
        HostKind::ScanAnalog => Host::ScanAnalog {
            source: values.analog(0)?,
            window: values.window(2)?,
            step: (values.u16(6)?, values.u16(7)?),
        },
        HostKind::ScanBlocks => Host::ScanBlocks {
            source: values.analog(0)?,
            mean: name.contains("mean"),
        },
        HostKind::ScanDigital => Host::ScanDigital {
            source: values.digital(0)?,
            // A picture is of all rows.
            first_row: values.u16(2).unwrap_or(0),
            last_row: values.u16(3).unwrap_or(last_row),
            events: match values.value(1) {
                Some(Value::Word(name)) => event_buffer(name),
                _ => None,
            },
        },
        HostKind::ScanBoundingBox => Host::ScanBoundingBox {
            source: values.digital(0)?,
        },
        HostKind::GlobalSum => Host::GlobalSum {
            source: values.analog(0)?,
            over: match name {
                "scamp5_global_sum_64" => SumOver::Grid8,
                "scamp5_global_sum_fast" => SumOver::Whole,
                "scamp5_global_sum_sparse" => SumOver::Sparse(values.pattern(1)?),
                _ => SumOver::Grid4,
            },
        },
        HostKind::GlobalOr => Host::GlobalOr {
            source: values.digital(0)?,
            pattern: values.pattern(1)?,
        },
        HostKind::GlobalCount => Host::GlobalCount {
            source: values.digital(0)?,
            temporary: values.analog(1)?,
            over: if values.number(2)? == 0.0 {
                SumOver::Grid4
            } else {
                SumOver::Grid8
            },
        },
        HostKind::Load => Host::Load {
            target: values.digital(0)?,
            area: match name {
                "scamp5_load_rect" => Area::Rect(values.window(1)?),
                "scamp5_load_pattern" => Area::Pattern(values.pattern(1)?),
                _ => Area::Point {
                    row: values.u16(1)?,
                    column: values.u16(2)?,
                },
            },
        },
        HostKind::Select => Host::Select {
            area: match name {
                "scamp5_select_rect" => Area::Rect(values.window(0)?),
                "scamp5_select_pattern" => Area::Pattern(values.pattern(0)?),
                "scamp5_select_row" | "scamp5_select_rowx" => Area::Row {
                    row: values.u16(0)?,
                    ignored: values.u16(1).unwrap_or(0),
                },
                "scamp5_select_col" | "scamp5_select_colx" => Area::Column {
                    column: values.u16(0)?,
                    ignored: values.u16(1).unwrap_or(0),
                },
                _ => Area::Point {
                    row: values.u16(0)?,
                    column: values.u16(1)?,
                },
            },
        },
        HostKind::DrawBegin => Host::DrawBegin {
            target: values.digital(0)?,
        },
        HostKind::Draw => Host::Draw {
            target: drawing?,
            shape: shape(name, values)?,
        },
        HostKind::DrawEnd => Host::DrawEnd,
    })
}

fn shape(name: &str, values: &Values<'_>) -> Option<Shape> {
    let (row, column) = (values.i32(0), values.i32(1));
    Some(match name {
        "scamp5_draw_negate" => Shape::Negate,
        "scamp5_draw_pixel" => Shape::Pixel {
            row: row?,
            column: column?,
        },
        "scamp5_draw_rect" => {
            let (from, to) = values.corners(0)?;
            Shape::Rect { from, to }
        }
        "scamp5_draw_line" => {
            let (from, to) = values.corners(0)?;
            Shape::Line { from, to }
        }
        "scamp5_draw_circle" => Shape::Circle {
            centre: (row?, column?),
            radius: values.u16(2)?,
            wrap: values.number(3)? != 0.0,
        },
        _ => Shape::Point {
            row: row?,
            column: column?,
        },
    })
}

impl Host {
    /// Whether it only sets the global input.
    #[must_use]
    pub const fn is_input(&self) -> bool {
        matches!(
            self,
            Self::LoadIn { .. } | Self::LoadInRaw { .. } | Self::LoadDac { .. }
        )
    }

    /// Its row.
    #[must_use]
    pub const fn kind(&self) -> HostKind {
        match self {
            Self::LoadIn { .. } => HostKind::LoadIn,
            Self::LoadInRaw { .. } => HostKind::LoadInRaw,
            Self::LoadDac { .. } => HostKind::LoadDac,
            Self::ScanEvents { .. } => HostKind::ScanEvents,
            Self::ReadAnalog { .. } => HostKind::ReadAnalog,
            Self::ReadPixel { .. } => HostKind::ReadPixel,
            Self::ScanAnalog { .. } => HostKind::ScanAnalog,
            Self::ScanBlocks { .. } => HostKind::ScanBlocks,
            Self::ScanDigital { .. } => HostKind::ScanDigital,
            Self::ScanBoundingBox { .. } => HostKind::ScanBoundingBox,
            Self::GlobalSum { .. } => HostKind::GlobalSum,
            Self::GlobalOr { .. } => HostKind::GlobalOr,
            Self::GlobalCount { .. } => HostKind::GlobalCount,
            Self::Load { .. } => HostKind::Load,
            Self::Select { .. } => HostKind::Select,
            Self::DrawBegin { .. } => HostKind::DrawBegin,
            Self::Draw { .. } => HostKind::Draw,
            Self::DrawEnd => HostKind::DrawEnd,
        }
    }

    /// As it is written, with the device's names.
    #[must_use]
    pub fn text(&self, device: &Device) -> String {
        let a = |r: &Analog| device.analog_name(*r);
        let d = |r: &Digital| device.digital_name(*r);
        match self {
            Self::LoadIn { value } => format!("scamp5_in({value})"),
            Self::LoadInRaw { value } => format!("scamp5_load_in({value})"),
            Self::LoadDac { code } => format!("scamp5_load_dac({code})"),
            Self::ScanEvents {
                source,
                polarity,
                channel,
                slots,
                order,
                by_rows,
            } => {
                let (source, name) = (d(source), buffer_name(*polarity, *channel));
                let corner = if *order == Order::default() {
                    String::new()
                } else {
                    let [h, v] = [order.from_left, order.from_bottom].map(u8::from);
                    format!(", {h}, {v}")
                };
                let rows = if *by_rows { "_rc" } else { "" };
                format!("scamp5_scan_events{rows}({source}, {name}, {slots}{corner})")
            }
            Self::ReadAnalog { source } => format!("scamp5_output_image({})", a(source)),
            Self::ReadPixel {
                source,
                row,
                column,
            } => {
                format!("scamp5_read_areg({}, {row}, {column})", a(source))
            }
            Self::ScanAnalog {
                source,
                window: w,
                step: (rows, columns),
            } => {
                format!(
                    "scamp5_scan_areg({}, buffer, {}, {rows}, {columns})",
                    a(source),
                    window_text(*w)
                )
            }
            Self::ScanBlocks { source, mean } => {
                let mean = if *mean { "mean_" } else { "" };
                format!("scamp5_scan_areg_{mean}8x8({}, buffer)", a(source))
            }
            Self::ScanDigital {
                source,
                first_row,
                last_row,
                events,
            } => {
                let buffer = events.map_or("buffer".to_owned(), |(polarity, channel)| {
                    buffer_name(polarity, channel)
                });
                format!(
                    "scamp5_scan_dreg({}, {buffer}, {first_row}, {last_row})",
                    d(source)
                )
            }
            Self::ScanBoundingBox { source } => {
                format!("scamp5_scan_boundingbox({}, buffer)", d(source))
            }
            Self::GlobalSum { source, over } => sum_text(&a(source), over),
            Self::GlobalOr { source, pattern: p } => {
                format!("scamp5_global_or({}, {})", d(source), pattern_text(*p))
            }
            Self::GlobalCount {
                source,
                temporary,
                over,
            } => {
                let option = u8::from(*over == SumOver::Grid8);
                format!(
                    "scamp5_global_count({}, {}, {option})",
                    d(source),
                    a(temporary)
                )
            }
            Self::Load { target, area } => load_text(&d(target), area),
            Self::Select { area } => select_text(area),
            Self::DrawBegin { target } => format!("scamp5_draw_begin({})", d(target)),
            Self::Draw { shape, .. } => shape_text(shape),
            Self::DrawEnd => "scamp5_draw_end()".to_owned(),
        }
    }
}

fn window_text(w: Window) -> String {
    format!("{}, {}, {}, {}", w.top, w.right, w.bottom, w.left)
}

fn pattern_text(p: Pattern) -> String {
    format!(
        "{}, {}, {}, {}",
        p.row, p.column, p.row_ignored, p.column_ignored
    )
}

fn load_text(d: &str, area: &Area) -> String {
    match area {
        Area::Rect(w) => format!("scamp5_load_rect({d}, {})", window_text(*w)),
        Area::Pattern(p) => format!("scamp5_load_pattern({d}, {})", pattern_text(*p)),
        Area::Point { row, column } => format!("scamp5_load_point({d}, {row}, {column})"),
        // No statement loads a row or a column; a pattern says the same.
        Area::Row { row, ignored } => {
            format!("scamp5_load_pattern({d}, {row}, 0, {ignored}, 65535)")
        }
        Area::Column { column, ignored } => {
            format!("scamp5_load_pattern({d}, 0, {column}, 65535, {ignored})")
        }
    }
}

fn select_text(area: &Area) -> String {
    match area {
        Area::Rect(w) => format!("scamp5_select_rect({})", window_text(*w)),
        Area::Pattern(p) => format!("scamp5_select_pattern({})", pattern_text(*p)),
        Area::Point { row, column } => format!("scamp5_select_point({row}, {column})"),
        Area::Row { row, ignored } => format!("scamp5_select_rowx({row}, {ignored})"),
        Area::Column { column, ignored } => format!("scamp5_select_colx({column}, {ignored})"),
    }
}

/// The buffer of a sign and channel, as programs are written.
fn buffer_name(polarity: Polarity, channel: u8) -> String {
    let name = match polarity {
        Polarity::On => "on",
        Polarity::Off => "off",
    };
    match channel {
        0 => name.to_owned(),
        channel => format!("{name}{channel}"),
    }
}

fn sum_text(a: &str, over: &SumOver) -> String {
    match over {
        SumOver::Grid4 => format!("scamp5_global_sum_16({a})"),
        SumOver::Grid8 => format!("scamp5_global_sum_64({a})"),
        SumOver::Whole => format!("scamp5_global_sum_fast({a})"),
        SumOver::Sparse(p) => format!("scamp5_global_sum_sparse({a}, {})", pattern_text(*p)),
    }
}

fn shape_text(shape: &Shape) -> String {
    let four = |name: &str, (a, b): (i32, i32), (c, d): (i32, i32)| {
        format!("scamp5_draw_{name}({a}, {b}, {c}, {d})")
    };
    match *shape {
        Shape::Pixel { row, column } => format!("scamp5_draw_pixel({row}, {column})"),
        Shape::Point { row, column } => format!("scamp5_draw_point({row}, {column})"),
        Shape::Rect { from, to } => four("rect", from, to),
        Shape::Line { from, to } => four("line", from, to),
        Shape::Circle {
            centre: (row, column),
            radius,
            wrap,
        } => format!(
            "scamp5_draw_circle({row}, {column}, {radius}, {})",
            u8::from(wrap)
        ),
        Shape::Negate => "scamp5_draw_negate()".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_buffer_says_polarity_and_channel() {
        assert_eq!(buffer("BUFFER"), Some((Polarity::On, 0)));
        assert_eq!(buffer("on2"), Some((Polarity::On, 2)));
        assert_eq!(buffer("OFF"), Some((Polarity::Off, 0)));
        assert_eq!(buffer("off_events13"), Some((Polarity::Off, 13)));
        assert_eq!(buffer("on256"), None);
    }

    #[test]
    fn bits_are_events_in_a_buffer_that_says_so() {
        assert_eq!(event_buffer("on"), Some((Polarity::On, 0)));
        assert_eq!(event_buffer("off3"), Some((Polarity::Off, 3)));
        for other in ["buffer", "once", "offset", "mem", "on256", ""] {
            assert_eq!(event_buffer(other), None, "{other}");
        }
    }
}
