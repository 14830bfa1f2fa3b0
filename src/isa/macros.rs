//! Macros: short sequences of primitives, as text.
//!
//! ```text
//! /// y := x0 - x1
//! macro sub(out y: areg, x0: source, x1: source)
//!     distinct y, x1 "the second store would read the register that it writes"
//! {
//!     bus(NEWS, x0);
//!     bus(y, NEWS, x1);
//! }
//! ```
//!
//! What a macro destroys is not written down: it is what its body writes and its heading does
//! not give as a result.

use std::collections::{BTreeMap, BTreeSet};

use crate::config::{Fault, Place, suggestion_or};
use crate::limit::{FAULTS, MACRO_DEPTH, MACRO_STATEMENTS, MACROS};

use super::{
    Callable, Device, Evidence, Kind as Primitives, Operand, Signature,
    signature::{Given, Mode},
    text::{Argument, Cursor, Expression, Kind, Statement, Term, Token, lex},
};

/// A macro.
#[derive(Clone, Debug, PartialEq)]
pub struct Macro {
    /// What it does, as its comment says.
    pub doc: String,
    /// What it is called and takes.
    pub signature: Signature,
    /// Run by the host as kernels of its own: its loops do not fill the kernel store.
    pub host: bool,
    /// Registers, besides parameters, that hold a result.
    pub gives: Vec<String>,
    /// Whether it needs FLAG to be 1 everywhere.
    pub whole_flag: bool,
    /// Parameters that may not be the same register.
    pub distinct: Vec<Distinct>,
    /// How well its sequence is known, and who says so, where that is stated.
    pub evidence: Option<(Evidence, String)>,
    /// What it stands for.
    pub body: Vec<Item>,
}

/// Two parameters that may not be the same register.
#[derive(Clone, Debug, PartialEq)]
pub struct Distinct {
    /// One.
    pub first: String,
    /// The other.
    pub second: String,
    /// Why.
    pub reason: String,
}

/// A part of a macro's body.
#[derive(Clone, Debug, PartialEq)]
pub enum Item {
    /// A statement.
    Statement(Statement),
    /// Several times.
    Repeat {
        /// How often.
        times: Expression,
        /// What.
        body: Vec<Item>,
    },
}

/// Reads a file of macros.
///
/// # Errors
/// All faults of the file.
pub fn parse(text: &str) -> Result<Vec<Macro>, Vec<Fault>> {
    let (tokens, mut faults) = lex(text);
    let (comments, tokens): (Vec<Token>, Vec<Token>) = tokens
        .into_iter()
        .partition(|t| matches!(t.kind, Kind::Line(_) | Kind::Block(_)));
    let mut cursor = Cursor::new(&tokens, text.len());
    let mut macros: Vec<Macro> = Vec::new();
    let mut end = 0;
    while cursor.peek().is_some() {
        let start = cursor.place().start;
        match read(&mut cursor) {
            Ok(mut it) => {
                it.doc = doc(&comments, end, start);
                macros.push(it);
            }
            Err(fault) => {
                faults.push(fault);
                if faults.len() > FAULTS {
                    return Err(faults);
                }
                // The next macro begins with a word of its own.
                while cursor.peek().is_some()
                    && !cursor.sees_word("macro")
                    && !cursor.sees_word("host")
                {
                    cursor.advance();
                }
            }
        }
        end = cursor.before().end;
    }
    let mut statements = 0;
    for (at, it) in macros.iter().enumerate() {
        statements += length(&it.body);
        let place = it.signature.place;
        if at == MACROS || statements > MACRO_STATEMENTS {
            let (what, most) = if at == MACROS {
                ("macros", MACROS)
            } else {
                ("statements", MACRO_STATEMENTS)
            };
            faults.push(
                Fault::error(
                    place,
                    format!("a chip has {most} {what} at most"),
                    "this macro",
                )
                .help("leave out what no program uses"),
            );
            return Err(faults);
        }
        if it.doc.is_empty() {
            faults.push(
                Fault::error(
                    place,
                    format!("`{}` is not explained", it.signature.name),
                    "this macro",
                )
                .help("write what it does in a comment `/// …` above it"),
            );
        }
    }
    if faults.is_empty() {
        Ok(macros)
    } else {
        Err(faults)
    }
}

/// Statements of a body.
fn length(body: &[Item]) -> usize {
    let one = |item: &Item| match item {
        Item::Statement(_) => 1,
        Item::Repeat { body, .. } => length(body),
    };
    body.iter().map(one).sum()
}

/// The `///` comments between two places.
fn doc(comments: &[Token], from: usize, to: usize) -> String {
    let lines = comments.iter().filter_map(|c| match &c.kind {
        Kind::Line(text) if (from..to).contains(&c.place.start) => text.strip_prefix('/'),
        _ => None,
    });
    lines.map(str::trim).collect::<Vec<_>>().join("\n")
}

fn read(cursor: &mut Cursor<'_>) -> Result<Macro, Fault> {
    const HELP: &str = "a macro is `macro name(parameters) { statements }`";
    let host = cursor.take_word("host");
    if !cursor.take_word("macro") {
        return Err(cursor.unexpected("`macro`", HELP));
    }
    let signature = Signature::read(cursor)?;
    let mut it = Macro {
        doc: String::new(),
        signature,
        host,
        gives: Vec::new(),
        whole_flag: false,
        distinct: Vec::new(),
        evidence: None,
        body: Vec::new(),
    };
    while !cursor.sees("{") {
        clause(cursor, &mut it)?;
    }
    it.body = body(cursor)?;
    Ok(it)
}

fn clause(cursor: &mut Cursor<'_>, it: &mut Macro) -> Result<(), Fault> {
    const HELP: &str = "before its body a macro can say `gives R12`, `needs FLAG`, \
                        `distinct y, x \"why\"` and `evidence guess \"source\"`";
    if cursor.take_word("gives") {
        loop {
            it.gives.push(cursor.name("a register", HELP)?.0);
            if !cursor.take(",") {
                break;
            }
        }
    } else if cursor.take_word("needs") {
        let (name, place) = cursor.name("FLAG", HELP)?;
        if name != "FLAG" {
            return Err(Fault::error(place, "only FLAG can be needed", "not FLAG").help(HELP));
        }
        it.whole_flag = true;
    } else if cursor.take_word("distinct") {
        let (first, _) = cursor.name("a parameter", HELP)?;
        cursor.expect(",", HELP)?;
        let (second, _) = cursor.name("a parameter", HELP)?;
        let reason = quoted(cursor, "the reason in quotes", HELP)?;
        it.distinct.push(Distinct {
            first,
            second,
            reason,
        });
    } else if cursor.take_word("evidence") {
        let (name, place) = cursor.name("measured, quoted, modelled or guess", HELP)?;
        let evidence = match name.as_str() {
            "measured" => Evidence::Measured,
            "quoted" => Evidence::Quoted,
            "modelled" => Evidence::Modelled,
            "guess" => Evidence::Guess,
            _ => {
                let known = ["measured", "quoted", "modelled", "guess"];
                return Err(
                    Fault::error(place, format!("unknown evidence `{name}`"), "here").help(
                        suggestion_or(
                            &name,
                            known,
                            "evidence is measured, quoted, modelled or guess",
                        ),
                    ),
                );
            }
        };
        it.evidence = Some((evidence, quoted(cursor, "the source in quotes", HELP)?));
    } else {
        return Err(cursor.unexpected("`{`", HELP));
    }
    Ok(())
}

fn quoted(cursor: &mut Cursor<'_>, expected: &str, help: &str) -> Result<String, Fault> {
    let Some(Token {
        kind: Kind::Quoted(text),
        ..
    }) = cursor.peek()
    else {
        return Err(cursor.unexpected(expected, help));
    };
    cursor.advance();
    Ok(text.clone())
}

fn body(cursor: &mut Cursor<'_>) -> Result<Vec<Item>, Fault> {
    cursor.expect("{", "a body is `{ statements }`")?;
    let mut items = Vec::new();
    while !cursor.take("}") {
        if cursor.take_word("repeat") {
            let times = cursor.expression()?;
            let body = cursor.deeper(body)?;
            items.push(Item::Repeat { times, body });
        } else {
            items.push(Item::Statement(cursor.statement()?));
        }
    }
    Ok(items)
}

/// Checks a macro of a device against the others, its rows and its registers.
#[must_use]
pub fn check(device: &Device, it: &Macro) -> Vec<Fault> {
    let mut faults = Vec::new();
    check_heading(device, it, &mut faults);
    check_body(device, it, &it.body, &mut faults);
    faults
}

/// Checks that no macro of a device comes back to itself, and that none is too deep. What is
/// wrong comes with the number of the macro.
#[must_use]
pub fn check_calls(device: &Device) -> Vec<(usize, Fault)> {
    let macros = &device.macros;
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

fn check_heading(device: &Device, it: &Macro, faults: &mut Vec<Fault>) {
    let place = it.signature.place;
    let parameters: Vec<&str> = it
        .signature
        .parameters
        .iter()
        .map(|p| p.name.as_str())
        .collect();
    for (i, name) in parameters.iter().enumerate() {
        if !name.is_empty() && parameters[..i].contains(name) {
            faults.push(
                Fault::error(
                    place,
                    format!("two parameters are called `{name}`"),
                    "in this heading",
                )
                .help("give one another name"),
            );
        }
        if it.signature.parameters[i].count != (1, 1) || it.signature.parameters[i].group {
            faults.push(
                Fault::error(
                    place,
                    format!("the parameter `{name}` takes several arguments"),
                    "a parameter of a macro takes one",
                )
                .help("write a macro for each number of arguments"),
            );
        }
        if device.value_of(name).is_some() {
            faults.push(
                Fault::error(
                    place,
                    format!("the parameter `{name}` hides a name of the chip"),
                    "in this heading",
                )
                .help("give it another name"),
            );
        }
    }
    for distinct in &it.distinct {
        for name in [&distinct.first, &distinct.second] {
            if !parameters.contains(&name.as_str()) {
                faults.push(
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
            faults.push(
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

fn check_body(device: &Device, it: &Macro, body: &[Item], faults: &mut Vec<Fault>) {
    for item in body {
        match item {
            Item::Statement(statement) => check_statement(device, it, statement, faults),
            Item::Repeat { times, body } => {
                check_names(device, it, times, faults);
                check_body(device, it, body, faults);
            }
        }
    }
}

fn check_statement(device: &Device, it: &Macro, statement: &Statement, faults: &mut Vec<Fault>) {
    let callables = device.callables(&statement.name);
    if callables.is_empty() {
        let names = device.all_callables().map(|c| c.signature().name.as_str());
        faults.push(
            Fault::error(
                statement.name_place,
                format!("unknown statement `{}`", statement.name),
                "in the body of a macro",
            )
            .help(suggestion_or(
                &statement.name,
                names,
                "a body is made of primitives and of other macros",
            )),
        );
        return;
    }
    let mut spread = false;
    for argument in &statement.arguments {
        let items = match argument {
            Argument::One(one) => std::slice::from_ref(one),
            Argument::Group { items, .. } => items,
        };
        for item in items {
            check_names(device, it, item, faults);
            // `R[dir]` may be one register or four.
            spread |= matches!(item.term, Term::Of { ref base, .. } if base == "R");
        }
    }
    let given: Vec<Given> = statement
        .arguments
        .iter()
        .map(|a| Given {
            values: match a {
                Argument::One(_) => vec![super::Value::Number(0.0)],
                Argument::Group { items, .. } => vec![super::Value::Number(0.0); items.len()],
            },
            group: matches!(a, Argument::Group { .. }),
            place: a.place(),
        })
        .collect();
    if !spread && !callables.iter().any(|c| c.signature().takes(&given)) {
        let forms: Vec<String> = callables
            .iter()
            .map(|c| c.signature().to_string())
            .collect();
        faults.push(
            Fault::error(
                statement.place,
                format!("`{}` does not take these arguments", statement.name),
                "in the body of a macro",
            )
            .help(format!("its forms are {}", forms.join(", "))),
        );
    }
}

fn check_names(device: &Device, it: &Macro, expression: &Expression, faults: &mut Vec<Fault>) {
    let mut need = |name: &str, place: Place| {
        let parameters = it.signature.parameters.iter();
        let mut names = parameters.map(|p| p.name.as_str()).chain(device.names());
        if !names.any(|n| n == name) {
            let parameters = it.signature.parameters.iter().map(|p| p.name.as_str());
            faults.push(
                Fault::error(
                    place,
                    format!("unknown name `{name}`"),
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
        Term::Negate(inner) => check_names(device, it, inner, faults),
        Term::Binary { left, right, .. } => {
            check_names(device, it, left, faults);
            check_names(device, it, right, faults);
        }
        Term::Of {
            base, direction, ..
        } => {
            need(direction, expression.place);
            if base != "X" && base != "R" {
                faults.push(
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

/// Whether a call can mean this macro, as far as number and literals of its arguments tell.
fn may_mean(call: &Statement, it: &Macro) -> bool {
    let parameters = &it.signature.parameters;
    let least = parameters.iter().filter(|p| p.default.is_none()).count();
    let other = |(argument, parameter): (&Argument, &super::signature::Parameter)| {
        let Operand::Literal(want) = parameter.operand else {
            return false;
        };
        matches!(argument, Argument::One(Expression { term: Term::Number(n), .. }) if *n != want)
    };
    it.signature.name == call.name
        && (least..=parameters.len()).contains(&call.arguments.len())
        && !call.arguments.iter().zip(parameters).any(other)
}

fn statements<'a>(body: &'a [Item], found: &mut Vec<&'a Statement>) {
    for item in body {
        match item {
            Item::Statement(statement) => found.push(statement),
            Item::Repeat { body, .. } => statements(body, found),
        }
    }
}

impl Macro {
    /// Whether another macro has the same name and takes the same.
    #[must_use]
    pub fn replaces(&self, other: &Self) -> bool {
        let operands = |m: &Self| -> Vec<Operand> {
            m.signature.parameters.iter().map(|p| p.operand).collect()
        };
        self.signature.name == other.signature.name && operands(self) == operands(other)
    }

    /// Names of the registers that its body writes besides its parameters.
    #[must_use]
    pub fn scratch(&self, device: &Device) -> Vec<String> {
        let mut names = Vec::new();
        self.collect_scratch(device, &mut names, &mut Vec::new());
        names.sort();
        names.dedup();
        names
    }

    /// Each macro is looked at once, however often it is called.
    fn collect_scratch<'d>(
        &'d self,
        device: &'d Device,
        names: &mut Vec<String>,
        seen: &mut Vec<&'d Self>,
    ) {
        if seen.iter().any(|known| std::ptr::eq(*known, self)) {
            return;
        }
        seen.push(self);
        let roles = device.registers().roles;
        let mut calls = Vec::new();
        statements(&self.body, &mut calls);
        let own = |name: &str| self.signature.parameters.iter().any(|p| p.name == name);
        for call in calls {
            for callable in device.callables(&call.name) {
                let signature = callable.signature();
                match callable {
                    Callable::Macro(next) if !may_mean(call, next) => continue,
                    Callable::Macro(next) => next.collect_scratch(device, names, seen),
                    Callable::Primitive(Primitives::Square, _) => {
                        names.push(device.analog_name(device.news()));
                    }
                    Callable::Primitive(Primitives::Prop, _) => {
                        names.push(device.digital_name(roles.propagated));
                    }
                    _ => {}
                }
                for (i, argument) in call.arguments.iter().enumerate() {
                    let last = signature.parameters.len().saturating_sub(1);
                    let parameter = signature.parameters.get(i.min(last));
                    if parameter.is_none_or(|p| p.mode == Mode::In) {
                        continue;
                    }
                    let Argument::One(Expression { term, .. }) = argument else {
                        continue;
                    };
                    match term {
                        Term::Name(name) if !own(name) => names.push(name.clone()),
                        Term::Of { base, .. } if base == "X" => {
                            names.push(device.analog_name(device.news()));
                        }
                        Term::Of { .. } => {
                            names.extend(roles.enable.map(|r| device.digital_name(r)));
                        }
                        _ => {}
                    }
                }
            }
        }
    }

    /// Indices of the parameters that hold a result afterwards.
    pub fn results(&self) -> impl Iterator<Item = usize> {
        let parameters = self.signature.parameters.iter().enumerate();
        parameters
            .filter(|(_, p)| matches!(p.mode, Mode::Out | Mode::InOut))
            .map(|(i, _)| i)
    }

    /// Whether a parameter is a register.
    #[must_use]
    pub fn is_register(&self, index: usize) -> bool {
        let parameter = self.signature.parameters.get(index);
        parameter.is_some_and(|p| {
            matches!(
                p.operand,
                Operand::Areg | Operand::Target | Operand::Source | Operand::Dreg | Operand::Bit
            )
        })
    }
}
