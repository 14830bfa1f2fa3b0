//! Calls of the vendor's library that are other statements here, and names that mean the same.

use super::{Role, byte_parameter, vendors};
use crate::{
    config::{Fault, Place},
    isa::{
        Device, Figure, Operand,
        text::{Argument, Statement, Term},
    },
    program::{
        buffer,
        vendor::{
            host,
            interpreter::{machine::Machine, value::Value},
            syntax::tree::{Kind, Word},
        },
    },
};

/// A value that is given, where it stands, and the name that it begins with.
pub(super) type Given = (Value, Place, String);

/// The statement that a call is; nothing where it is none.
pub(super) fn rewritten(
    machine: &mut Machine<'_>,
    name: &str,
    mut given: Vec<Given>,
    place: Place,
) -> Option<(String, Vec<Given>)> {
    let renamed = match name {
        "scamp5_output_events" => {
            given.truncate(5);
            if let Some(display) = given.get_mut(1) {
                *display = word("on", display.1);
            }
            "scamp5_scan_events"
        }
        "scamp5_scan_events_cr" => "scamp5_scan_events",
        "scamp5_output_boundingbox" => {
            given.truncate(1);
            given.push(word("box", place));
            "scamp5_scan_boundingbox"
        }
        "scamp5_load_region" => "scamp5_load_rect",
        "scamp5_shift" => {
            // What comes in at the edge, and how often the host refreshes.
            let edge = given.get(3).and_then(|it| it.0.number());
            given.truncate(if edge == Some(0.0) { 3 } else { 4 });
            name
        }
        "scamp5_draw_line" => {
            if given.get(4).is_some_and(|it| it.0.number() == Some(1.0)) {
                line_leaves(machine, &given, place);
            }
            given.truncate(4);
            name
        }
        // Compilers name the register twice.
        "div2_inplace" if given.len() == 2 => {
            if given[0].0 != given[1].0 {
                machine.error(
                    place,
                    "`div2_inplace` halves one register in place".to_owned(),
                    "these are two",
                    "write `div2(y, x);`",
                );
            }
            given.truncate(1);
            name
        }
        name if name.starts_with("scamp7_") => {
            another_chip(machine, name, place);
            return None;
        }
        "icw" => {
            machine.error(
                place,
                "`icw` sets single lines of the chip".to_owned(),
                "what they do together is not known",
                "write the instruction by its name, such as `DNEWS0(d, s);`",
            );
            return None;
        }
        name => {
            if let (Some(way), true) = (instead(name), machine.device.callables(name).is_empty()) {
                machine.error(
                    place,
                    format!("unknown statement `{name}`"),
                    "this call",
                    way,
                );
                return None;
            }
            name
        }
    };
    if renamed.starts_with("scamp5_") {
        for (value, at, _) in &mut given {
            in_whole(machine, value, *at);
        }
    }
    byte_parameter::in_eight_bits(machine, renamed, &mut given);
    if !byte_parameter::with_its_mask(machine, renamed, &mut given, place) {
        return None;
    }
    byte_parameter::with_a_sign(machine, renamed, &mut given);
    if matches!(renamed, "scamp5_scan_events" | "scamp5_scan_events_rc") {
        as_many_slots_as_there_are(machine, renamed, &mut given);
        for (value, ..) in given.iter_mut().skip(3) {
            *value = value.clone().converted(Kind::INT);
        }
    }
    Some((variant(machine.device, renamed, given.len()), given))
}

/// Whether a statement of the frame language means something to the vendor's tools, or comes from a
/// kernel compiler, and has no such meaning in the language itself.
pub(in crate::program::vendor) fn has_alone(device: &Device, statement: &Statement) -> bool {
    let (name, arguments) = (&*statement.name, &statement.arguments[..]);
    let role = host::role(name, arguments.len());
    if !device.callables(name).is_empty() {
        let term = |it: &Argument| match it {
            Argument::One(one) => Some(one.term.clone()),
            Argument::Group { .. } => None,
        };
        // A register named twice, of which the language's own form has no room for the second.
        let twice = matches!(arguments, [a, b] if term(a).is_some() && term(a) == term(b));
        return role == Role::Kernel || name == "div2_inplace" && twice;
    }
    match role {
        Role::Kernel | Role::Sync | Role::Show | Role::Read => true,
        Role::Library => vendors(name) || name == "display",
        Role::Number => false,
        Role::Chip => variant(device, name, arguments.len()) != name,
    }
}

/// Warns of a line that would go on at the other side of the array, where it is not known to end
/// on it.
fn line_leaves(machine: &mut Machine<'_>, given: &[Given], place: Place) {
    let on = |at: usize, figure| {
        let number = given.get(at).and_then(|it| it.0.number());
        number.is_some_and(|it| (0.0..machine.device.value(figure)).contains(&it))
    };
    let rows = on(0, Figure::Height) && on(2, Figure::Height);
    if rows && on(1, Figure::Width) && on(3, Figure::Width) {
        return;
    }
    machine.fault(
        Fault::warning(place, "a line does not wrap around here", "this line")
            .help("draw it in parts"),
    );
}

fn another_chip(machine: &mut Machine<'_>, name: &str, place: Place) {
    let message = format!("`{name}` is a call of the SCAMP-7, which is not modelled");
    let help = "the chip here is the SCAMP-5, whose calls begin with `scamp5_`";
    machine.error(place, message, "another chip", help);
}

/// What the host takes are whole numbers.
fn in_whole(machine: &mut Machine<'_>, value: &mut Value, at: Place) {
    const MAKES: &str = "C++ passes the integer";
    let (Value::Real(_) | Value::Single(_), Some(real)) = (&*value, value.decimal()) else {
        return;
    };
    // In a loop, once for all of its values.
    let mut told = machine.faults.iter();
    let told = told.any(|it| it.place.start == at.start && it.message.starts_with(MAKES));
    if real.fract() != 0.0 && !told {
        let message = format!("{MAKES} {} instead of {real}", real.trunc());
        machine.fault(
            Fault::warning(at, message, "an integer parameter").help("write a whole number"),
        );
    }
    *value = Value::Whole(real as i64);
}

/// Slots as far as the list of the chip's host goes: more of them hold no more events.
fn as_many_slots_as_there_are(machine: &mut Machine<'_>, name: &str, given: &mut [Given]) {
    let Some((value, place, _)) = given.get_mut(2) else {
        return;
    };
    // C++ counts slots in whole numbers.
    *value = value.clone().converted(Kind::INT);
    let forms = machine.device.callables(name);
    let most = { forms.iter() }
        .filter_map(|it| it.signature().parameters.get(2))
        .find_map(|it| match it.operand {
            Operand::Integer(_, most) => Some(most),
            _ => None,
        });
    let (Some(most), Some(number)) = (most, value.number()) else {
        return;
    };
    if number <= most {
        return;
    }
    *value = Value::Whole(most as i64);
    let label = "more slots than the chip has";
    let mut told = machine.faults.iter();
    if told.any(|it| it.place.start == place.start && it.label == label) {
        return;
    }
    let own = machine.files.own(*place);
    let written = machine.text.get(own.start..own.end).unwrap_or_default();
    let named = written.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && written
            .chars()
            .all(|c| c.is_ascii_alphanumeric() || c == '_');
    let way = if named {
        format!("write {most}, or give `--const {written}={most}`")
    } else {
        format!("write {most}")
    };
    let message = format!("`{name}` reads at most {most} events, but {number} are asked for");
    machine.fault(
        Fault::warning(*place, message, label).help(format!("{most} slots are read here: {way}")),
    );
}

/// Whether a call draws a point on the array, where its place is known.
pub(super) fn draws_point(machine: &Machine<'_>, name: &str, given: &[Given]) -> Option<Value> {
    if name != "scamp5_draw_point" {
        return None;
    }
    let [row, column] = [0, 1].map(|at| given.get(at)?.0.number());
    let on = |at: f64, figure| (0.0..machine.device.value(figure)).contains(&at);
    let inside = on(row?, Figure::Height) && on(column?, Figure::Width);
    Some(Value::Whole(inside.into()))
}

/// What to write in the place of a call that the vendor's library has and no document describes.
fn instead(name: &str) -> Option<&'static str> {
    Some(match name {
        "scamp5_global_sum_region" => {
            "`scamp5_global_sum_sparse(a, row, column, row_ignored, column_ignored)` sums a block whose sides are powers of two: rows and columns 0 to 63 are `(a, 0, 0, 63, 63)`; of any other one `scamp5_scan_areg` reads the samples, for the host to add"
        }
        "blur_repeat" => {
            "`gauss(y, x, n)` spreads x over the network n times, where R1 and R2 are 1; whether `blur_repeat` is the same, the vendor does not say"
        }
        _ => return None,
    })
}

fn word(name: &str, place: Place) -> Given {
    (Value::Symbol(name.into()), place, name.to_owned())
}

/// Whether the chip may have such a statement.
pub(in crate::program::vendor) fn is_known(
    machine: &Machine<'_>,
    name: &str,
    given: usize,
) -> bool {
    let name = variant(machine.device, name, given);
    !machine.device.callables(&name).is_empty() || name == "icw"
}

/// `bus2_3` where the chip has `bus2`: compilers number forms that the vendor tells apart by their
/// arguments. Any other word may turn the meaning round, as `MOV_NOT` would.
fn variant(device: &Device, name: &str, given: usize) -> String {
    if device.callables(name).is_empty()
        && let Some((base, rest)) = name.rsplit_once('_')
    {
        let is_number = !rest.is_empty() && rest.bytes().all(|c| c.is_ascii_digit());
        let takes = device
            .callables(base)
            .iter()
            .any(|it| it.signature().counts().contains(&given));
        if is_number && !base.starts_with("scamp5") && takes {
            return base.to_owned();
        }
    }
    name.to_owned()
}

/// The name of a buffer as this program has it, which says which events it takes. With a number, so
/// that a variable of the same name is another one.
pub(super) fn buffer_name(name: &str) -> String {
    let digits = name.trim_start_matches(|c: char| c.is_ascii_alphabetic());
    let word = &name[..name.len() - digits.len()];
    let is_number = !digits.is_empty() && digits.bytes().all(|c| c.is_ascii_digit());
    if matches!(word, "on" | "off") && is_number && buffer(name).is_some() {
        return name.to_owned();
    }
    if takes_off(name) { "off0" } else { "on0" }.to_owned()
}

/// Whether a buffer is named for what gets darker: `off`, `ev_off`, `eventsNeg`.
fn takes_off(name: &str) -> bool {
    let (mut words, mut before) = (vec![String::new()], ' ');
    for c in name.chars() {
        let begins = c.is_ascii_uppercase() && before.is_ascii_lowercase();
        if begins || !c.is_ascii_alphabetic() {
            words.push(String::new());
        }
        if let (true, Some(word)) = (c.is_ascii_alphabetic(), words.last_mut()) {
            word.push(c.to_ascii_lowercase());
        }
        before = c;
    }
    let whole = name.to_ascii_lowercase();
    let is_off =
        |word: &String| matches!(&**word, "off" | "neg" | "negative" | "minus" | "falling");
    words.iter().any(is_off) || whole.starts_with("off") && !whole.starts_with("offs")
}

/// The directions of a `DNEWS` that takes several of them.
pub(super) fn joined(given: &[Given]) -> Option<Vec<Word>> {
    match given.get(2).map(|it| &it.0) {
        Some(Value::Symbols(names)) => Some(names.clone()),
        _ => None,
    }
}

/// `DNEWS` from some directions: the words of the macro, with these registers set.
pub(super) fn neighbours(
    machine: &mut Machine<'_>,
    given: &[Given],
    directions: &[Word],
    place: Place,
) {
    let name = |name: &str| Term::Name(name.to_owned());
    let all = ["RS", "RW", "RN", "RE"];
    let mut enabled = Vec::new();
    for direction in directions {
        let register = match &**direction {
            "south" => "RS",
            "west" => "RW",
            "north" => "RN",
            "east" => "RE",
            other => {
                machine.error(
                    place,
                    format!("`{other}` is not a direction"),
                    "this call",
                    "directions are north, east, south, west and alldir",
                );
                return;
            }
        };
        if !enabled.contains(&register) {
            enabled.push(register);
        }
    }
    let boundary = given.get(3).is_some_and(|it| it.0.number() == Some(1.0));
    machine.ask("CLR", all.iter().map(|it| name(it)).collect(), place);
    machine.ask("SET", enabled.iter().map(|it| name(it)).collect(), place);
    let operands = given.iter().take(2);
    let operands: Option<Vec<Term>> = operands.map(|it| super::request::term(&it.0)).collect();
    let word = if boundary { "DNEWS1" } else { "DNEWS0" };
    machine.ask(word, operands.unwrap_or_default(), place);
}
