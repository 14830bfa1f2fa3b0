//! Parameters of eight bits in the vendor's header: rows and columns, which are a `uint8_t`, and
//! values for the array, which are an `int8_t`.

use std::fmt::Write as _;

use super::chip::Given;
use crate::{
    config::{Fault, Place},
    isa::Figure,
    program::vendor::{interpreter::machine::Machine, syntax::tree::Kind},
};

/// Addresses of a `uint8_t`, as far as any array of the vendor goes.
const SIDE: f64 = 256.0;

const LABEL: &str = "an unsigned 8-bit parameter";

const SIGNED: &str = "a signed 8-bit parameter";

/// The first parameter of those that are a `uint8_t`: rows and columns, and their masks.
fn first(name: &str, narrow: bool) -> Option<usize> {
    match name {
        "scamp5_load_point"
        | "scamp5_load_rect"
        | "scamp5_load_pattern"
        | "scamp5_global_or"
        | "scamp5_global_sum_sparse"
        | "scamp5_read_areg" => Some(1),
        "scamp5_scan_areg" => Some(2),
        // Larger arrays draw where they are told to.
        "scamp5_draw_pixel" | "scamp5_draw_rect" if narrow => Some(0),
        _ if name.starts_with("scamp5_select_") => Some(0),
        _ => None,
    }
}

/// A mask of rows or columns goes with the one that was selected last; whether it is known which.
pub(super) fn with_its_mask(
    machine: &mut Machine<'_>,
    name: &str,
    given: &mut Vec<Given>,
    place: Place,
) -> bool {
    let Some(which) = name.strip_prefix("scamp5_select_") else {
        return true;
    };
    let (at, what, line) = match which {
        "row" | "rowx" => (0, "row", "scamp5_select_row"),
        "col" | "colx" => (1, "column", "scamp5_select_col"),
        // What a mask does after these, the vendor does not say.
        _ => {
            machine.selected = [None, None];
            return true;
        }
    };
    if !which.ends_with('x') {
        machine.selected[at] = given.first().map(|it| it.0.clone());
        return true;
    }
    if given.len() != 1 {
        let message = format!("`{name}` takes one argument, the mask");
        let help = format!("write `{line}({what}); {name}(mask);`");
        machine.error(place, message, "this call", &help);
        return false;
    }
    let Some(selected) = machine.selected[at].clone() else {
        let message =
            format!("`{name}` masks the {what} that was selected last, but none was selected");
        let help = format!(
            "select it first, with `{line}({what});`, or both at once with `scamp5_select_pattern(row, column, row_mask, column_mask);`"
        );
        machine.error(place, message, "this call", &help);
        return false;
    };
    given.insert(0, (selected, place, String::new()));
    true
}

/// A value for the array as C++ passes it: 206 is -50.
pub(super) fn with_a_sign(machine: &mut Machine<'_>, name: &str, given: &mut [Given]) {
    if !matches!(name, "scamp5_in" | "scamp5_load_in") {
        return;
    }
    let at = usize::from(given.len() > 1);
    let Some((value, place, _)) = given.get_mut(at) else {
        return;
    };
    let passed = value.clone().converted(Kind::Bits(8, true));
    let (Some(number), Some(made)) = (value.number(), passed.number()) else {
        return;
    };
    if number != made {
        let written = value.written();
        *value = passed;
        tell(machine, (name, *place, SIGNED), (&written, made), None);
    }
}

/// Rows and columns as C++ passes them: -1 is 255, 300 is 44. Beyond 255 an array may have more of
/// them.
pub(super) fn in_eight_bits(machine: &mut Machine<'_>, name: &str, given: &mut [Given]) {
    let side = |figure| machine.device.value(figure);
    let narrow = side(Figure::Height).max(side(Figure::Width)) <= SIDE;
    let Some(first) = first(name, narrow) else {
        return;
    };
    let given = given.get_mut(first..).unwrap_or_default();
    let numbers =
        |given: &[Given]| -> Vec<Option<f64>> { given.iter().map(|it| it.0.number()).collect() };
    let before = numbers(given);
    let written: Vec<String> = given.iter().map(|it| it.0.written()).collect();
    for ((value, ..), number) in given.iter_mut().zip(&before) {
        let Some(number) = *number else {
            continue;
        };
        let whole = value.clone().converted(Kind::INT);
        let passed = if narrow || number < 0.0 {
            whole.converted(Kind::Bits(8, false))
        } else {
            whole
        };
        if passed.number() != Some(number) {
            *value = passed;
        }
    }
    let after = numbers(given);
    let wrapped = before.iter().zip(&after).enumerate();
    for (index, (number, made)) in wrapped.filter(|(_, (a, b))| a != b) {
        let (Some(_), Some(made)) = (number, *made) else {
            continue;
        };
        let turned = if has_corners(name) {
            turned(index, &before, &after)
        } else {
            None
        };
        let given = (name, given[index].1, LABEL);
        tell(machine, given, (&written[index], made), turned);
    }
}

fn has_corners(name: &str) -> bool {
    matches!(
        name,
        "scamp5_load_rect" | "scamp5_select_rect" | "scamp5_draw_rect" | "scamp5_scan_areg"
    )
}

/// The other end of a rectangle along this axis, where the end lies below the start and was written
/// behind it.
fn turned(index: usize, before: &[Option<f64>], after: &[Option<f64>]) -> Option<f64> {
    let (start, end) = match index {
        0 | 1 => (index, index + 2),
        2 | 3 => (index - 2, index),
        _ => return None,
    };
    let at = |all: &[Option<f64>], at: usize| all.get(at).copied().flatten();
    let turns = at(before, start)? <= at(before, end)? && at(after, end)? < at(after, start)?;
    let other = if index == start { end } else { start };
    turns.then(|| at(after, other)).flatten()
}

/// Warns of a number that became another one; in a loop once for all of its numbers.
fn tell(
    machine: &mut Machine<'_>,
    (name, place, label): (&str, Place, &str),
    (number, made): (&str, f64),
    turned: Option<f64>,
) {
    let mut told = machine.faults.iter();
    if told.any(|it| it.place.start == place.start && it.label == label) {
        return;
    }
    let mut message = format!("C++ passes {made} instead of {number}");
    let mut help = format!("write {made}");
    if let Some(other) = turned {
        let _ = write!(
            message,
            ": the rectangle ends at {}, before its start at {}",
            made.min(other),
            made.max(other)
        );
        help = if name == "scamp5_draw_rect" {
            "rows and columns go from 0 to 255; the pixels between the two are drawn".to_owned()
        } else {
            "rows and columns go from 0 to 255; this rectangle is empty here; the vendor does not document what the chip does with it".to_owned()
        };
    }
    machine.fault(Fault::warning(place, message, label).help(help));
}
