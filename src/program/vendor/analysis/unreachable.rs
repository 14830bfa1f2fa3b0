//! Kernels that no run of the program reaches: they are named, and so is what of them cannot be meant.

use std::{collections::BTreeSet, fmt::Write as _};

use crate::{
    config::{Fault, Place},
    program::vendor::{
        host::{self, Role, chip, vendors},
        interpreter::machine::Machine,
        syntax::{
            tree::{Declared, Expr, ExprNode, Function, Kernel, Kind, Stmt, StmtNode, last},
            walk::{Part, values, walk},
        },
    },
};

/// Kernels that are listed.
const LISTED: usize = 8;

/// What has to happen for a kernel to run.
#[derive(Clone, Default)]
struct Waits<'a> {
    /// These conditions have to hold, or to fail, from the outside in.
    conditions: Vec<(&'a Expr, bool)>,
    /// The function that has to run.
    function: Option<&'a Function>,
    /// Whether somebody has to act at the GUI.
    callback: bool,
}

impl<'a> Waits<'a> {
    /// Inside what depends on a condition.
    fn on(&self, condition: &'a Expr, holds: bool) -> Self {
        let mut inner = self.clone();
        inner.conditions.push((condition, holds));
        inner
    }
}

/// Warns of kernels that did not run, and of words in them that the chip does not have.
pub(in crate::program::vendor) fn tell(machine: &mut Machine<'_>, statements: &[Stmt]) {
    let mut found = Found::default();
    for statement in statements {
        found.statement(statement, &Waits::default());
    }
    let Found {
        kernels,
        declared,
        variables,
    } = found;
    let settable: BTreeSet<&str> = { variables.iter() }
        .filter(|it| takes_number(machine, it))
        .map(|it| &*it.name)
        .collect();
    let idle = { kernels.into_iter() }.filter(|(kernel, _)| !machine.ran.contains(&key(kernel)));
    let idle: Vec<_> = idle.collect();
    for (kernel, _) in &idle {
        for statement in &kernel.body {
            check(machine, statement, &declared);
        }
    }
    list(machine, &idle, &settable);
}

/// Which kernel it is.
pub(in crate::program::vendor) const fn key(it: &Kernel) -> (usize, usize) {
    (it.begin.start, it.ordinal)
}

/// Whether a number can be set from outside for what is declared so: for one number with a name.
fn takes_number(machine: &Machine<'_>, it: &Declared) -> bool {
    let number = !matches!(it.kind, Kind::Analog | Kind::Digital);
    let object = it.kind == Kind::Any
        && (machine.is_string(&it.of)
            || machine.layouts.contains_key(&it.of)
            || machine.unread.contains_key(&it.of));
    number && !object && it.lengths.is_empty() && !it.pointer && !it.reference
}

/// Lists kernels that did not run. What a header has that this program does not call is no matter.
fn list(machine: &mut Machine<'_>, idle: &[(&Kernel, Waits<'_>)], variables: &BTreeSet<&str>) {
    let told = idle.iter().filter(|(kernel, waits)| {
        let own = machine.files.name(kernel.begin).is_none();
        own || uncalled(machine, waits).is_none()
    });
    let told: Vec<_> = told.collect();
    let Some((first, _)) = told.first() else {
        return;
    };
    let mut lines: Vec<String> = Vec::new();
    for (kernel, waits) in &told {
        let mut line = machine.line(kernel.begin);
        if let Some(way) = way(machine, waits, variables) {
            let _ = write!(line, " ({way})");
        }
        if !lines.contains(&line) {
            lines.push(line);
        }
    }
    let more = lines.len().saturating_sub(LISTED);
    lines.truncate(LISTED);
    let mut help = lines.join(", ");
    if more > 0 {
        let _ = write!(help, ", and {more} more");
    }
    let message = match told.len() {
        1 => "this kernel never runs".to_owned(),
        kernels => format!("{kernels} kernels never run"),
    };
    let fault = Fault::warning(first.begin, message, "this one does not");
    machine.fault(fault.help(help));
}

/// The function that nothing calls, where a kernel waits for that.
fn uncalled<'a>(machine: &Machine<'_>, waits: &Waits<'a>) -> Option<&'a Function> {
    let entered = |it: &&Function| machine.entered.contains(&it.place.start);
    waits.function.filter(|it| !waits.callback && !entered(it))
}

/// What would run a kernel.
fn way(machine: &Machine<'_>, waits: &Waits<'_>, variables: &BTreeSet<&str>) -> Option<String> {
    if waits.callback {
        return Some("when somebody acts at the GUI".to_owned());
    }
    if let Some(function) = uncalled(machine, waits) {
        return Some(match &*function.name {
            "" => "in a lambda that nothing calls".to_owned(),
            name => format!("in `{name}`, which nothing calls"),
        });
    }
    let mut conditions = waits.conditions.iter().rev();
    let set = conditions.find_map(|(of, holds)| settable((of, *holds), waits.function, variables));
    match set {
        Some(set) => Some(set),
        None if waits.conditions.is_empty() => None,
        None => Some("behind a condition".to_owned()),
    }
}

/// What would make a condition hold: a variable that can be set from outside, with a value, or
/// what the function is called with.
fn settable(
    (of, holds): (&Expr, bool),
    function: Option<&Function>,
    variables: &BTreeSet<&str>,
) -> Option<String> {
    let (of, holds) = match &of.node {
        ExprNode::Unary("!", of) => (&**of, !holds),
        _ => (of, holds),
    };
    let parameter = |name: &str| {
        let all = function.map_or(&[][..], |it| &it.parameters);
        all.iter().any(|it| &*it.name == name)
    };
    let mut found = None;
    values(of, &mut |part| {
        if let Part::Expr(Expr {
            node: ExprNode::Name(name),
            ..
        }) = part
            && (parameter(last(name)) || variables.contains(last(name)))
        {
            found.get_or_insert_with(|| last(name).to_owned());
        }
    });
    let name = found?;
    Some(match (&of.node, function) {
        (_, Some(it)) if parameter(&name) => match &*it.name {
            "" => format!("by a call with another `{name}`"),
            function => format!("by a call of `{function}` with another `{name}`"),
        },
        (ExprNode::Name(_), _) => format!("`--const {name}={}`", i32::from(holds)),
        _ => format!("`--const {name}=VALUE`"),
    })
}

/// Tells of words that nobody has, and of registers that the chip does not have, as far as that can be
/// known of what does not run.
fn check(machine: &mut Machine<'_>, it: &Stmt, declared: &BTreeSet<&str>) {
    let mut wrong: Vec<(Place, String)> = Vec::new();
    walk(it, false, &mut |part| {
        let Part::Expr(Expr {
            node: ExprNode::Call(callee, given),
            ..
        }) = part
        else {
            return;
        };
        let ExprNode::Name(name) = &callee.node else {
            return;
        };
        let plain = last(name);
        let chips = host::role(plain, given.len()) == Role::Chip
            && plain == &**name
            && !declared.contains(plain)
            && !defines(machine, plain);
        if chips && !chip::is_known(machine, plain, given.len()) && !vendors(plain) {
            wrong.push((callee.place, format!("unknown statement `{plain}`")));
        }
        for it in given {
            if let ExprNode::Name(name) = &it.node
                && like_a_register(name)
                && machine.device.value_of(name).is_none()
                && machine.find(name).is_none()
                && !declared.contains(&**name)
            {
                wrong.push((it.place, format!("`{name}` is not declared")));
            }
        }
    });
    for (place, message) in wrong {
        let message = format!("{message}, in a kernel that never runs");
        let fault = Fault::warning(place, message, "this would be an error if it ran");
        machine.fault(fault.help("see docs/scamp5.md for the words and registers of the chip"));
    }
}

/// Whether the file has a function or a class of this name.
fn defines(machine: &Machine<'_>, name: &str) -> bool {
    machine.functions.contains_key(name)
        || machine.members.contains_key(name)
        || machine.specials.contains_key(name)
        || machine.prototypes.contains_key(name)
        || machine.layouts.contains_key(name)
        || machine.unread.contains_key(name)
}

/// Whether a name is written as a register's: a capital letter and perhaps a number.
fn like_a_register(name: &str) -> bool {
    let mut letters = name.chars();
    letters.next().is_some_and(|it| it.is_ascii_uppercase())
        && letters.all(|it| it.is_ascii_digit())
}

/// What a text holds.
#[derive(Default)]
struct Found<'a> {
    kernels: Vec<(&'a Kernel, Waits<'a>)>,
    /// Names of variables and parameters, wherever they are declared.
    declared: BTreeSet<&'a str>,
    /// Variables that are declared by themselves.
    variables: Vec<&'a Declared>,
}

impl<'a> Found<'a> {
    fn statement(&mut self, it: &'a Stmt, waits: &Waits<'a>) {
        match &it.node {
            StmtNode::Kernel(kernel) => {
                self.kernels.push((kernel, waits.clone()));
                self.all(&kernel.body, waits);
            }
            StmtNode::Block(all) | StmtNode::Namespace(_, all) => self.all(all, waits),
            StmtNode::Switch(on, all) => {
                self.value(on, waits);
                self.all(all, &waits.on(on, true));
            }
            StmtNode::If(condition, yes, no) => {
                self.value(condition, waits);
                self.statement(yes, &waits.on(condition, true));
                if let Some(no) = no {
                    self.statement(no, &waits.on(condition, false));
                }
            }
            StmtNode::For(start, condition, step, body) => {
                if let Some(start) = start {
                    self.statement(start, waits);
                }
                for it in condition.iter().chain(step) {
                    self.value(it, waits);
                }
                self.statement(body, waits);
            }
            StmtNode::Each(it, list, body) => {
                self.declared.insert(&it.name);
                self.value(list, waits);
                self.statement(body, waits);
            }
            StmtNode::While(condition, body) | StmtNode::DoWhile(body, condition) => {
                self.value(condition, waits);
                self.statement(body, &waits.on(condition, true));
            }
            StmtNode::Declare(all) => {
                for it in all {
                    self.declared.insert(&it.name);
                    self.variables.push(it);
                    if let Some(value) = &it.value {
                        self.value(value, waits);
                    }
                }
            }
            StmtNode::Expr(value) | StmtNode::Return(Some(value)) => self.value(value, waits),
            StmtNode::Function(function) => self.function(function, false),
            StmtNode::Class(all) => {
                for function in all {
                    self.function(function, false);
                }
            }
            StmtNode::Struct(class) => {
                self.declared
                    .extend(class.members.iter().map(|it| &*it.name));
            }
            StmtNode::Case(_)
            | StmtNode::Break
            | StmtNode::Continue
            | StmtNode::Return(None)
            | StmtNode::Prototype(_)
            | StmtNode::Nothing => {}
        }
    }

    fn all(&mut self, all: &'a [Stmt], waits: &Waits<'a>) {
        for it in all {
            self.statement(it, waits);
        }
    }

    fn function(&mut self, it: &'a Function, callback: bool) {
        let parameters = it.parameters.iter();
        self.declared.extend(parameters.map(|it| &*it.name));
        let waits = Waits {
            conditions: Vec::new(),
            function: Some(it),
            callback,
        };
        self.all(&it.body, &waits);
    }

    /// The lambdas in a value.
    fn value(&mut self, it: &'a Expr, waits: &Waits<'a>) {
        match &it.node {
            ExprNode::Lambda(function) => self.function(function, false),
            ExprNode::Block(all) => self.all(all, waits),
            ExprNode::Call(callee, given) => {
                self.value(callee, waits);
                let callback = matches!(&callee.node, ExprNode::Name(name)
                    if last(name).starts_with("vs_on_"));
                for it in given {
                    match &it.node {
                        ExprNode::Lambda(function) if callback => {
                            self.function(function, true);
                        }
                        _ => self.value(it, waits),
                    }
                }
            }
            ExprNode::Unary(_, of) | ExprNode::Convert(_, of) | ExprNode::Template(_, of) => {
                self.value(of, waits);
            }
            ExprNode::Binary(_, a, b) | ExprNode::Assign(_, a, b) => {
                self.value(a, waits);
                self.value(b, waits);
            }
            ExprNode::Choose(condition, yes, no) => {
                self.value(condition, waits);
                self.value(yes, &waits.on(condition, true));
                self.value(no, &waits.on(condition, false));
            }
            ExprNode::Braces(all) => {
                for it in all {
                    self.value(it, waits);
                }
            }
            _ => {}
        }
    }
}
