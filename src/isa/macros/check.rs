//! Checks of a chip's macros against each other, its rows and its registers.

use std::collections::{BTreeMap, BTreeSet};

use crate::{
    config::{Fault, Place, suggestion_or},
    isa::{
        Callable, Device, Signature, Value,
        signature::{Given, Mode},
        text::{Argument, Expression, Statement, Term},
    },
    limit::{FAULTS, MACRO_DEPTH},
    unit::counted,
};

use super::{
    calls::{fits_literals, may_mean, may_write, statements},
    definition::{Item, Macro},
    possible, reach, roles,
};

/// What is wrong with a macro, and what of that is for want of something on the chip.
#[derive(Default)]
struct Found {
    faults: Vec<Fault>,
    lacks: Vec<String>,
}

impl Found {
    fn new(device: &Device, it: &Macro) -> Self {
        let mut found = Self::default();
        check_heading(device, it, &mut found);
        check_body(device, it, &it.body, &mut found);
        check_results(device, it, &mut found);
        found
    }

    fn push(&mut self, fault: Fault) {
        self.faults.push(fault);
    }

    /// A fault for want of this, as a message names it.
    fn lacks(&mut self, what: String, fault: Fault) {
        self.lacks.push(what);
        self.faults.push(fault);
    }
}

/// Checks a macro of a device against the others, its rows and its registers; `it` is one of the
/// device's own.
#[must_use]
pub fn check(device: &Device, it: &Macro) -> Vec<Fault> {
    let mut faults = Found::new(device, it).faults;
    faults.extend(reach::unreachable(device, it));
    faults
}

/// What a macro of the chip `home`, which is below, needs that the device does not have, as a message
/// names it: of a statement that is left out, what that needs.
#[must_use]
pub fn lacks(device: &Device, home: &Device, it: &Macro) -> Option<String> {
    let lacks = Found::new(device, it).lacks.into_iter().next();
    lacks.or_else(|| roles::lacks(device, home, it))
}

/// Leaves out what parameters are where nothing is given, if the device does not have that.
pub fn without_defaults(device: &Device, it: &mut Macro) {
    for at in 0..it.signature.parameters.len() {
        let mut found = Found::default();
        if let Some(default) = &it.signature.parameters[at].default {
            check_names(device, it, default, &mut found);
        }
        if !found.lacks.is_empty() {
            it.signature.parameters[at].default = None;
        }
    }
}

/// Checks that no macro of a device comes back to itself, and that none is too deep. What is
/// wrong comes with the number of the macro.
#[must_use]
pub fn check_calls(device: &Device) -> Vec<(usize, Fault)> {
    let macros = device.macros();
    let mut named: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for (at, it) in macros.iter().enumerate() {
        named.entry(&it.signature.name).or_default().push(at);
    }
    let called: Vec<BTreeSet<usize>> = macros
        .iter()
        .map(|it| {
            let mut calls = Vec::new();
            statements(&it.body, &mut calls);
            let candidates = |call: &&Statement| {
                let all = named.get(call.name.as_str()).into_iter().flatten();
                let call = *call;
                let meant: Vec<usize> = all
                    .copied()
                    .filter(|at| may_mean(call, &macros[*at]))
                    .collect();
                meant
            };
            calls.iter().flat_map(candidates).collect()
        })
        .collect();
    // Level by level: first the macros that call none, then those that call only these, …
    let mut settled = vec![false; macros.len()];
    let mut open: Vec<usize> = (0..macros.len()).collect();
    let mut faults = Vec::new();
    for level in 1.. {
        let (ready, rest): (Vec<usize>, Vec<usize>) = open
            .iter()
            .partition(|at| called[**at].iter().all(|next| settled[*next]));
        if ready.is_empty() {
            open = rest;
            break;
        }
        for at in &ready {
            settled[*at] = true;
            if level > MACRO_DEPTH && faults.len() <= FAULTS {
                let it = &macros[*at].signature;
                let what = format!("`{}` has {level} macros inside each other", it.name);
                faults.push((
                    *at,
                    Fault::error(it.place, what, format!("at most {MACRO_DEPTH}"))
                        .help("write what it does in fewer steps"),
                ));
            }
        }
        open = rest;
    }
    let circles = open
        .iter()
        .filter_map(|at| Some((*at, circle(device, &macros[*at])?)));
    faults.extend(circles.take(FAULTS));
    faults
}

/// The fault of a macro that comes back to itself, if it does.
fn circle(device: &Device, it: &Macro) -> Option<Fault> {
    calls_itself(device, it).map(|path| {
        let names: Vec<&str> = path.split(" calls ").collect();
        let path = match names.as_slice() {
            [first @ .., last] if first.len() > 8 => {
                let left = first.len() - 8;
                let first = first[..8].join(" calls ");
                format!("{first} calls {left} others, and then {last}")
            }
            _ => path,
        };
        Fault::error(
            it.signature.place,
            format!("`{}` comes back to itself: {path}", it.signature.name),
            "this macro would never end",
        )
        .help("a macro is made of primitives and of macros that are simpler")
    })
}

fn check_heading(device: &Device, it: &Macro, found: &mut Found) {
    let place = it.signature.place;
    let parameters: Vec<&str> = it
        .signature
        .parameters
        .iter()
        .map(|p| p.name.as_str())
        .collect();
    for (i, name) in parameters.iter().enumerate() {
        if !name.is_empty() && parameters[..i].contains(name) {
            found.push(
                Fault::error(
                    place,
                    format!("two parameters are called `{name}`"),
                    "in this heading",
                )
                .help("give one another name"),
            );
        }
        if it.signature.parameters[i].count != (1, 1) || it.signature.parameters[i].group {
            found.push(
                Fault::error(
                    place,
                    format!("the parameter `{name}` takes several arguments"),
                    "a parameter of a macro takes one",
                )
                .help("write a macro for each number of arguments"),
            );
        }
        if device.value_of(name).is_some() {
            found.push(
                Fault::error(
                    place,
                    format!("the parameter `{name}` hides a name of the chip"),
                    "in this heading",
                )
                .help("give it another name"),
            );
        }
    }
    for default in it
        .signature
        .parameters
        .iter()
        .filter_map(|p| p.default.as_ref())
    {
        check_names(device, it, default, found);
    }
    for distinct in &it.distinct {
        for name in [&distinct.first, &distinct.second] {
            if !parameters.contains(&name.as_str()) {
                found.push(
                    Fault::error(
                        place,
                        format!("`{name}` is not a parameter"),
                        "in this heading",
                    )
                    .help(suggestion_or(
                        name,
                        parameters.iter().copied(),
                        "name a parameter of this heading",
                    )),
                );
            }
        }
    }
    for name in &it.gives {
        if name != "FLAG" && device.value_of(name).is_none() {
            found.lacks(
                format!("register `{name}`"),
                Fault::error(
                    place,
                    format!("`{name}` is not a register"),
                    "in this heading",
                )
                .help(suggestion_or(
                    name,
                    device.names(),
                    "name a register of the chip, or FLAG",
                )),
            );
        }
    }
}

/// Checks that something in the body leaves a result in each parameter that is said to have one.
fn check_results(device: &Device, it: &Macro, found: &mut Found) {
    let mut body = Vec::new();
    statements(&it.body, &mut body);
    // What the chip does not have says nothing of its arguments.
    if body
        .iter()
        .any(|call| device.callables(&call.name).is_empty())
    {
        return;
    }
    for parameter in &it.signature.parameters {
        let name = &parameter.name;
        if parameter.mode == Mode::Out && !body.iter().any(|call| may_write(device, call, name)) {
            found.push(
                Fault::error(
                    it.signature.place,
                    format!(
                        "nothing in the body of `{}` writes `{name}`",
                        it.signature.name
                    ),
                    format!("`out {name}` in this heading"),
                )
                .help("leave the result in it, or leave `out` out"),
            );
        }
    }
}

fn check_body(device: &Device, it: &Macro, body: &[Item], found: &mut Found) {
    for item in body {
        match item {
            Item::Statement(statement) => check_statement(device, it, statement, found),
            Item::Repeat { times, body } => {
                check_names(device, it, times, found);
                check_body(device, it, body, found);
            }
        }
    }
}

fn check_statement(device: &Device, it: &Macro, statement: &Statement, found: &mut Found) {
    let callables = device.callables(&statement.name);
    if callables.is_empty() {
        let names = device.all_callables().map(|c| c.signature().name.as_str());
        let why = device.why_no_statement(&statement.name, None);
        found.lacks(
            lacked(device, statement),
            Fault::error(
                statement.name_place,
                (why.clone()).unwrap_or_else(|| format!("unknown statement `{}`", statement.name)),
                "in the body of a macro",
            )
            .help(match why {
                Some(_) => format!("use the statements that {} has", device.name()),
                None => suggestion_or(
                    &statement.name,
                    names,
                    "a body is made of primitives and of other macros",
                ),
            }),
        );
        return;
    }
    let mut spread = false;
    for argument in &statement.arguments {
        for item in argument.items() {
            check_names(device, it, item, found);
            // `R[dir]` may be one register or four.
            spread |= matches!(item.term, Term::Of { ref base, .. } if base == "R");
        }
    }
    let given: Vec<Given> = statement
        .arguments
        .iter()
        .map(|a| Given {
            values: vec![Value::Number(0.0); a.items().len()],
            group: matches!(a, Argument::Group { .. }),
            place: a.place(),
        })
        .collect();
    if spread {
        return;
    }
    let fits = |form: &Signature| form.takes(&given) && fits_literals(statement, form);
    let fitting: Vec<Callable<'_>> = { callables.iter().copied() }
        .filter(|c| fits(c.signature()))
        .collect();
    if fitting.is_empty() {
        let forms: Vec<String> = callables
            .iter()
            .map(|c| c.signature().to_string())
            .collect();
        found.lacks(
            lacked(device, statement),
            Fault::error(
                statement.place,
                format!("`{}` does not take these arguments", statement.name),
                "in the body of a macro",
            )
            .help(format!("its forms are {}", forms.join(", "))),
        );
    } else {
        found
            .faults
            .extend(possible::impossible(device, it, statement, &fitting));
    }
}

/// What is not there where a statement cannot be: what a macro of the name lacks, else the statement.
fn lacked(device: &Device, statement: &Statement) -> String {
    let left = device.left_out().iter();
    let mut left = left.filter(|left| { left.it.iter() }.any(|it| may_mean(statement, it)));
    match (left.next(), statement.arguments.len()) {
        (Some(left), _) => left.lacks.clone(),
        (None, count) if !device.callables(&statement.name).is_empty() => {
            format!("`{}` of {}", statement.name, counted(count, "argument"))
        }
        (None, _) => format!("`{}`", statement.name),
    }
}

fn check_names(device: &Device, it: &Macro, expression: &Expression, found: &mut Found) {
    let mut need = |name: &str, place: Place| {
        let parameters = it.signature.parameters.iter();
        let mut names = parameters.map(|p| p.name.as_str()).chain(device.names());
        if !names.any(|n| n == name) {
            let parameters = it.signature.parameters.iter().map(|p| p.name.as_str());
            let why = device.why_no_name(name);
            found.lacks(
                format!("`{name}`"),
                Fault::error(
                    place,
                    why.unwrap_or_else(|| format!("unknown name `{name}`")),
                    "in the body of a macro",
                )
                .help(suggestion_or(
                    name,
                    parameters.chain(device.names()),
                    "a body knows its parameters and the names of the chip",
                )),
            );
        }
    };
    match &expression.term {
        Term::Number(_) => {}
        Term::Name(name) => need(name, expression.place),
        Term::Negate(inner) => check_names(device, it, inner, found),
        Term::Binary { left, right, .. } => {
            check_names(device, it, left, found);
            check_names(device, it, right, found);
        }
        Term::Of {
            base, direction, ..
        } => {
            need(direction, expression.place);
            if base != "X" && base != "R" {
                found.push(
                    Fault::error(
                        expression.place,
                        format!("unknown name `{base}[…]`"),
                        "here",
                    )
                    .help("`X[dir]` is a neighbour's cell, `R[dir]` the register that enables it"),
                );
            }
        }
    }
}

/// The way by which a macro comes back to itself, if it does.
fn calls_itself(device: &Device, it: &Macro) -> Option<String> {
    fn follow(
        device: &Device,
        from: &Macro,
        start: &Macro,
        seen: &mut Vec<Signature>,
    ) -> Option<String> {
        let mut calls = Vec::new();
        statements(&from.body, &mut calls);
        for call in calls {
            for next in device.macros.iter().filter(|m| may_mean(call, m)) {
                if next.signature == start.signature {
                    return Some(format!("{} calls {}", from.signature.name, call.name));
                }
                if !seen.contains(&next.signature) {
                    seen.push(next.signature.clone());
                    if let Some(path) = follow(device, next, start, seen) {
                        return Some(format!("{} calls {path}", from.signature.name));
                    }
                }
            }
        }
        None
    }
    follow(device, it, it, &mut Vec::new())
}
