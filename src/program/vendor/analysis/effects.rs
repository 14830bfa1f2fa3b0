//! What a part of the text could do, without running it: for branches of which only the run
//! knows whether they are taken.

use std::{
    collections::{BTreeMap, BTreeSet},
    ops::Bound::{Included, Unbounded},
    rc::Rc,
};

use crate::program::vendor::{
    host::{self, ALGORITHMS, Role},
    interpreter::{
        machine::Machine,
        reason::Reason,
        scope::foreign,
        value::{Slot, Value},
    },
    syntax::{
        tree::{Declared, Expr, ExprNode, Function, Stmt, StmtNode, Word, last},
        walk::{Part, calls, tied, values, walk},
    },
};

/// Whether it changes anything in the array.
pub(in crate::program::vendor) fn changes(machine: &Machine<'_>, it: &Stmt) -> bool {
    asks(machine, it, &|role| matches!(role, Role::Sync | Role::Chip))
}

/// Whether it runs words that the chip is known to have.
pub(in crate::program::vendor) fn runs_words(machine: &Machine<'_>, it: &Stmt) -> bool {
    calls_any(machine, it, &|name, given| {
        let acts = matches!(host::role(name, given), Role::Sync | Role::Chip);
        acts && !machine.device.callables(name).is_empty()
    })
}

/// Whether it reads from the array into memory.
pub(in crate::program::vendor) fn reads(machine: &Machine<'_>, it: &Stmt) -> bool {
    asks(machine, it, &|role| role == Role::Read)
}

/// Whether it shows something of the array.
pub(in crate::program::vendor) fn shows(machine: &Machine<'_>, it: &Stmt) -> bool {
    asks(machine, it, &|role| role == Role::Show)
}

/// Whether it writes something for people.
pub(in crate::program::vendor) fn posts(machine: &Machine<'_>, it: &Stmt) -> bool {
    calls_any(machine, it, &|name, _| {
        name.starts_with("vs_post") || matches!(name, "printf" | "puts")
    })
}

/// Whether it asks something of the box or the array that is seen outside of the program.
pub(in crate::program::vendor) fn is_seen(machine: &Machine<'_>, it: &Stmt) -> bool {
    begins_kernel(machine, it)
        || calls_any(machine, it, &|name, given| match host::role(name, given) {
            Role::Library => {
                name.starts_with("vs_") || matches!(name, "printf" | "puts" | "display")
            }
            Role::Number | Role::Chip => false,
            _ => true,
        })
}

/// A value as a statement.
pub(in crate::program::vendor) fn statement(it: &Expr) -> Stmt {
    Stmt {
        node: StmtNode::Expr(it.clone()),
        place: it.place,
    }
}

/// Whether it calls something that has such a role, in the functions that it calls too.
fn asks(machine: &Machine<'_>, it: &Stmt, which: &dyn Fn(Role) -> bool) -> bool {
    calls_any(machine, it, &|name, given| which(host::role(name, given)))
}

/// Whether it calls any such name with so many arguments, in the functions that it calls too.
/// Always looks to the end: what is looked at counts.
fn calls_any(machine: &Machine<'_>, it: &Stmt, which: &dyn Fn(&str, usize) -> bool) -> bool {
    let mut found = false;
    reach(machine, it, &mut |_| {}, &mut |name, given| {
        found |= which(name, given);
    });
    found
}

/// What a call calls, as far as the text says it.
#[derive(Default)]
struct Callees {
    functions: Vec<Rc<Function>>,
    /// Names of the library or the chip.
    names: Vec<Word>,
}

/// Lambdas that have a name in what is looked at, and no variable yet.
type Locals = BTreeMap<Word, Vec<Rc<Function>>>;

impl Callees {
    fn of(machine: &Machine<'_>, locals: &Locals, callee: &Expr) -> Self {
        let mut all = Self::default();
        all.add(machine, locals, callee);
        all
    }

    fn add(&mut self, machine: &Machine<'_>, locals: &Locals, callee: &Expr) {
        match &callee.node {
            ExprNode::Lambda(function) => self.functions.push(Rc::clone(function)),
            ExprNode::Name(name) => {
                let local = locals.get(name);
                self.functions.extend(local.into_iter().flatten().cloned());
                if let Some(slot) = machine.find(name) {
                    self.found(machine, &machine.slots[slot]);
                } else if !self.named(machine, name) && local.is_none() {
                    self.names.push(last(name).into());
                }
            }
            ExprNode::Member(of, name) => {
                let name = last(name);
                self.functions.extend(members(machine, name));
                if let Some(slot) = base(of).and_then(|it| machine.find(&it)) {
                    self.launched(&machine.slots[slot]);
                    self.part(machine, &machine.slots[slot], name);
                }
            }
            ExprNode::Index(of, _)
            | ExprNode::Unary(_, of)
            | ExprNode::Convert(_, of)
            | ExprNode::Recast(_, of) => {
                self.add(machine, locals, of);
            }
            ExprNode::Choose(_, yes, no) => {
                self.add(machine, locals, yes);
                self.add(machine, locals, no);
            }
            _ => {}
        }
    }

    /// Functions of the file that have this name; whether there are any.
    fn named(&mut self, machine: &Machine<'_>, name: &str) -> bool {
        if foreign(name) {
            return false;
        }
        let name = last(name);
        let known = [
            machine.functions.get(name),
            machine.members.get(name),
            machine.specials.get(name),
        ];
        let before = self.functions.len();
        let all = known.into_iter().flatten().flatten();
        self.functions.extend(all.cloned());
        self.functions.len() > before
    }

    /// What a variable holds that can be called, or what it leads to.
    fn found(&mut self, machine: &Machine<'_>, value: &Value) {
        match value {
            Value::Pointer(slot, ..) | Value::Reference(slot, _) => {
                self.held(machine, &machine.slots[*slot]);
            }
            value => self.held(machine, value),
        }
    }

    /// What the member of an object holds that can be called.
    fn part(&mut self, machine: &Machine<'_>, value: &Value, name: &str) {
        let value = match value {
            Value::Pointer(slot, ..) | Value::Reference(slot, _) => &machine.slots[*slot],
            value => value,
        };
        match value {
            Value::List(all) => all.iter().for_each(|it| self.inner(machine, it, name)),
            value => self.inner(machine, value, name),
        }
    }

    fn inner(&mut self, machine: &Machine<'_>, value: &Value, name: &str) {
        let Value::Record(layout, all) = value else {
            return;
        };
        for (member, value) in layout.members.iter().zip(all) {
            if &*member.name == name {
                self.held(machine, value);
            } else {
                self.inner(machine, value, name);
            }
        }
    }

    /// A kernel that an object may hold.
    fn launched(&mut self, value: &Value) {
        if matches!(value, Value::Lambda(function) if function.words.is_some()) {
            self.names.push("scamp5_launch_kernel".into());
        }
    }

    /// What a value is that can be called.
    fn held(&mut self, machine: &Machine<'_>, value: &Value) {
        match value {
            Value::Lambda(function) if function.words.is_some() => self.launched(value),
            Value::Lambda(function) => self.functions.push(Rc::clone(function)),
            Value::Symbol(name) if !self.named(machine, name) => {
                self.names.push(last(name).into());
            }
            Value::List(all) => all.iter().for_each(|it| self.held(machine, it)),
            Value::Record(layout, _) if layout.names("operator()") => {
                self.functions.extend(members(machine, "operator()"));
            }
            _ => {}
        }
    }
}

/// Functions of classes that have this name.
pub(in crate::program::vendor) fn members(machine: &Machine<'_>, name: &str) -> Vec<Rc<Function>> {
    let name = last(name);
    let inside = machine.members.get(name).into_iter().flatten();
    let outside = machine.functions.get(name).into_iter().flatten();
    let outside = outside.filter(|it| it.qualified);
    inside.chain(outside).cloned().collect()
}

/// Every part of a statement and of the functions that it calls, which are given back, and every
/// call of something that the file does not define, with the number of its arguments.
fn reach(
    machine: &Machine<'_>,
    it: &Stmt,
    part: &mut dyn FnMut(&Part<'_>),
    leaf: &mut dyn FnMut(&str, usize),
) -> Vec<Rc<Function>> {
    let mut all = Vec::new();
    let mut locals = Locals::new();
    let mut seen = BTreeSet::new();
    let mut queue: Vec<Rc<Function>> = Vec::new();
    let mut parts = 0;
    let mut part = |it: &Part<'_>| {
        parts += 1;
        part(it);
    };
    scan(machine, it, &mut locals, &mut queue, &mut part, leaf);
    while let Some(function) = queue.pop() {
        if seen.insert(Rc::as_ptr(&function)) {
            took(machine, &function, &mut locals);
            for it in function.body.iter() {
                scan(machine, it, &mut locals, &mut queue, &mut part, leaf);
            }
            all.push(function);
        }
    }
    machine.looks(parts);
    all
}

/// The lambdas that a lambda took along.
fn took(machine: &Machine<'_>, function: &Function, locals: &mut Locals) {
    for (name, slot) in &function.held {
        if let Value::Lambda(inner) = &machine.slots[*slot] {
            let known = locals.entry(name.clone()).or_default();
            known.push(Rc::clone(inner));
        }
    }
}

fn scan(
    machine: &Machine<'_>,
    it: &Stmt,
    locals: &mut Locals,
    queue: &mut Vec<Rc<Function>>,
    part: &mut dyn FnMut(&Part<'_>),
    leaf: &mut dyn FnMut(&str, usize),
) {
    let defines = |all: &BTreeMap<Word, Vec<Rc<Function>>>| {
        let mut behind = all.range::<str, _>((Included("operator"), Unbounded));
        behind.next().is_some_and(|it| it.0.starts_with("operator"))
    };
    let operators = defines(&machine.functions) || defines(&machine.members);
    walk(it, false, &mut |it| {
        part(&it);
        match it {
            Part::Stmt(Stmt {
                node: StmtNode::Declare(all),
                ..
            }) => {
                for declared in all {
                    if let Some(ExprNode::Lambda(function)) =
                        declared.value.as_ref().map(|it| &it.node)
                    {
                        let known = locals.entry(declared.name.clone()).or_default();
                        known.push(Rc::clone(function));
                    }
                }
            }
            Part::Expr(Expr {
                node: ExprNode::Call(callee, given),
                ..
            }) => {
                let callees = Callees::of(machine, locals, callee);
                for name in &callees.names {
                    leaf(name, given.len());
                }
                let known = |name: &Word| ALGORITHMS.contains(&&**name);
                if !callees.functions.is_empty() || callees.names.iter().any(known) {
                    // A function that is given to a function may be called there.
                    let given = given.iter().map(|it| Callees::of(machine, locals, it));
                    queue.extend(given.flat_map(|it| it.functions));
                }
                queue.extend(callees.functions);
            }
            Part::Expr(it) if operators => {
                let mut callees = Callees::default();
                if let Some(name) = operator(it) {
                    callees.named(machine, &name);
                }
                queue.extend(callees.functions);
            }
            _ => {}
        }
    });
}

/// The operator of a class that a value may call.
fn operator(it: &Expr) -> Option<String> {
    Some(match &it.node {
        ExprNode::Binary(operator, ..) | ExprNode::Unary(operator, _) => {
            format!("operator{operator}")
        }
        ExprNode::Assign(operator, ..) => format!("operator{}=", operator.unwrap_or_default()),
        ExprNode::Index(..) => "operator[]".to_owned(),
        ExprNode::Step(_, by, _) => format!("operator{}", if *by > 0 { "++" } else { "--" }),
        _ => return None,
    })
}

/// The first variable of a value that only the run knows.
pub(in crate::program::vendor) fn unknown(machine: &Machine<'_>, it: &Expr) -> Option<Word> {
    let (mut found, mut objects) = (None, Vec::new());
    values(it, &mut |part| {
        let Part::Expr(own) = part else { return };
        let name = match &own.node {
            // Objects and arrays are not given values from outside.
            ExprNode::Member(of, _) | ExprNode::Index(of, _) => {
                objects.push(of.place);
                return;
            }
            ExprNode::Name(name) if !objects.contains(&own.place) => name,
            _ => return,
        };
        // Nor are texts.
        let slot = machine.find(name).filter(|it| !machine.string_at(*it, &[]));
        if found.is_none()
            && slot.is_some_and(|slot| matches!(machine.slots[slot], Value::Unknown(_)))
        {
            found = Some(name.clone());
        }
    });
    found
}

/// Whether it can leave the block that it is in.
pub(in crate::program::vendor) fn leaves(it: &Stmt) -> bool {
    leaves_switch(it) || holds(it, true, |node| matches!(node, StmtNode::Break))
}

/// Whether it can end the loop or the function that it is in.
pub(in crate::program::vendor) fn ends(it: &Stmt) -> bool {
    breaks(it) || returns(it)
}

/// Whether it can end the function that it is in.
pub(in crate::program::vendor) fn returns(it: &Stmt) -> bool {
    holds(it, false, |node| matches!(node, StmtNode::Return(_)))
}

/// Whether it can leave more than a `switch` around it: the loop's turn, or the function.
pub(in crate::program::vendor) fn leaves_switch(it: &Stmt) -> bool {
    holds(it, true, |node| matches!(node, StmtNode::Continue)) || returns(it)
}

/// Whether any statement in it is such a one; of `own`, outside of the loops in it.
fn holds(it: &Stmt, own: bool, is: impl Fn(&StmtNode) -> bool) -> bool {
    let mut found = false;
    walk(it, own, &mut |part| {
        found |= matches!(part, Part::Stmt(it) if is(&it.node));
    });
    found
}

/// Forgets what it assigns.
pub(in crate::program::vendor) fn forget(machine: &mut Machine<'_>, it: &Stmt, why: &Reason) {
    let Assigned {
        names,
        functions,
        moved,
        given,
        led,
        grows,
    } = assigned(machine, it);
    let mut slots: BTreeSet<Slot> = names.iter().flat_map(|it| machine.find_all(it)).collect();
    // What a lambda took along, it assigns wherever it is called.
    let held = functions.iter().flat_map(|it| &it.held);
    slots.extend(held.filter(|it| names.contains(&it.0)).map(|it| it.1));
    slots.extend(led);
    for slot in slots {
        match machine.slots[slot].clone() {
            Value::Pointer(slot, path, _) | Value::Reference(slot, path) => {
                forget_grown(machine, (slot, &path), grows, why);
            }
            // Of a reverse iterator, any element.
            Value::Back(slot, path, _) => {
                let array = path.split_last().map_or(&[][..], |it| it.1);
                machine.forget(slot, array, why);
            }
            Value::Symbol(_) | Value::Lambda(_) => {}
            _ => forget_grown(machine, (slot, &[]), grows, why),
        }
    }
    // Where a pointer leads afterwards is not known: what it led to and may lead to.
    for it in &given {
        machine.lose_led(it, why);
    }
    for (slot, path) in { moved.iter() }
        .filter_map(|it| machine.lies(it))
        .collect::<Vec<_>>()
    {
        match machine.peek(slot, &path).cloned() {
            Some(Value::Pointer(led, ..) | Value::Back(led, ..)) => machine.lose(led, why),
            Some(Value::Symbol(_) | Value::Lambda(_)) => {}
            _ => continue,
        }
        machine.put(slot, &path, Value::Unknown(why.clone()));
    }
}

/// Forgets a value; of an array of the language's library that may have other elements, its length
/// too.
fn forget_grown(
    machine: &mut Machine<'_>,
    (slot, path): (Slot, &[usize]),
    grows: bool,
    why: &Reason,
) {
    if grows && machine.is_library(slot, path) {
        machine.put(slot, path, Value::Unknown(why.clone()));
    } else if grows
        && let Some(Value::Record(layout, _)) = machine.peek(slot, path)
        && layout.entry.is_none()
    {
        let layout = Rc::clone(layout);
        for at in 0..layout.members.len() {
            forget_grown(machine, (slot, &[path, &[at]].concat()), true, why);
        }
    } else {
        machine.forget(slot, path, why);
    }
}

/// Whether the value that a member begins with changes variables.
pub(in crate::program::vendor) fn acts(machine: &Machine<'_>, it: &Declared) -> bool {
    let value = it.value.as_ref();
    let value = value.filter(|it| matches!(it.node, ExprNode::Call(..)));
    value.is_some_and(|it| {
        let names = assigned(machine, &statement(it)).names;
        names.iter().any(|it| !machine.find_all(it).is_empty())
    })
}

/// Whether it may assign to one of these variables.
pub(in crate::program::vendor) fn may_assign(
    machine: &Machine<'_>,
    it: &Stmt,
    slots: &BTreeSet<Slot>,
) -> bool {
    let Assigned {
        names,
        functions,
        moved,
        given,
        led,
        ..
    } = assigned(machine, it);
    let held = functions.iter().flat_map(|it| &it.held);
    let held = held.filter(|it| names.contains(&it.0)).map(|it| it.1);
    let named = names.iter().flat_map(|it| machine.find_all(it));
    let leads = |slot: Slot| match &machine.slots[slot] {
        Value::Pointer(to, ..) | Value::Reference(to, _) | Value::Back(to, ..) => *to,
        _ => slot,
    };
    let mut all = named.chain(held).chain(led);
    let moved = moved.iter().chain(&given);
    all.any(|it| slots.contains(&it) || slots.contains(&leads(it))) || { moved }
        .flat_map(|it| machine.leads_to(it))
        .any(|it| slots.contains(&it))
}

/// What a statement may assign to, and whether it is what that leads to.
pub(in crate::program::vendor) fn assigns(machine: &Machine<'_>, it: &Stmt) -> Vec<(Word, bool)> {
    let Assigned { names, moved, .. } = assigned(machine, it);
    let through = { moved.iter() }.filter(|it| !matches!(it.node, ExprNode::Name(_)));
    let through = through.filter_map(base).map(|it| (it, true));
    through
        .chain(names.into_iter().map(|it| (it, false)))
        .collect()
}

/// What a statement may assign to.
struct Assigned {
    names: Vec<Word>,
    /// The functions that it calls.
    functions: Vec<Rc<Function>>,
    /// What may lead elsewhere afterwards, and what it or a function gives.
    moved: Vec<Expr>,
    given: Vec<Expr>,
    /// What pointers lead to that are its own.
    led: Vec<Slot>,
    /// Whether arrays may have other elements afterwards.
    grows: bool,
}

/// Functions of an array after which it may have another length.
const GROW: [&str; 12] = [
    "push_back",
    "push_front",
    "pop_back",
    "pop_front",
    "emplace_back",
    "emplace_front",
    "emplace",
    "insert",
    "erase",
    "resize",
    "clear",
    "assign",
];

fn assigned(machine: &Machine<'_>, it: &Stmt) -> Assigned {
    let mut names = Vec::new();
    let (mut moved, mut given) = (Vec::new(), Vec::new());
    let (mut led, mut grows) = (Vec::new(), false);
    let list = |name: &Word| {
        let slot = machine.find(name);
        slot.is_some_and(|slot| {
            let held = &machine.slots[slot];
            matches!(
                held,
                Value::List(_) | Value::Pointer(..) | Value::Reference(..)
            )
        })
    };
    let object = |name: &Word| {
        let slot = machine.find(name);
        slot.is_some_and(|slot| matches!(machine.slots[slot], Value::Record(..)))
    };
    let mut part = |part: &Part<'_>| {
        let value = match part {
            Part::Expr(value) => value,
            Part::Stmt(it) => {
                if let StmtNode::Declare(all) = &it.node {
                    let own = all.iter().filter(|it| !it.constant);
                    let values = own.filter_map(|it| Some((it.reference, it.value.as_ref()?)));
                    for (reference, value) in values {
                        names.extend(base(value).filter(|_| reference));
                        led.extend(machine.leads_to(value));
                    }
                } else if let StmtNode::Return(Some(value)) = &it.node {
                    given.push(value.clone());
                }
                return;
            }
        };
        match &value.node {
            ExprNode::Assign(_, to, _) | ExprNode::Step(to, ..) => {
                if let ExprNode::Assign(_, _, value) = &value.node {
                    given.push((**value).clone());
                }
                let lies = machine.lies(to);
                grows |= lies.is_some_and(|(slot, path)| machine.is_library(slot, &path));
                moved.push((**to).clone());
                names.extend(base(to));
                names.extend(tied(to).into_iter().flatten().filter_map(base));
            }
            ExprNode::Unary("&", of) => names.extend(base(of)),
            // A map makes the element; an operator may change what is left of it.
            ExprNode::Index(of, _) | ExprNode::Binary("<<" | ">>", of, _) => {
                names.extend(base(of).filter(object));
            }
            ExprNode::Call(callee, given) => {
                // An array that is given may be written.
                let reads = matches!(&callee.node, ExprNode::Name(name) if last(name) == "vs_gui_read_slider");
                if !reads {
                    names.extend(given.iter().filter_map(base).filter(list));
                }
                // So may the object that is called, or that a function belongs to.
                names.extend(base(callee).filter(object));
                if let ExprNode::Member(of, name) = &callee.node {
                    grows |= GROW.contains(&&**name);
                    names.extend(base(of));
                }
                let callees = Callees::of(machine, &Locals::new(), callee);
                for function in callees.functions {
                    let all = function.parameters.iter().zip(given);
                    let references = all.filter(|(parameter, _)| parameter.reference);
                    names.extend(references.filter_map(|(_, it)| base(it)));
                }
            }
            _ => {}
        }
    };
    let functions = reach(machine, it, &mut part, &mut |_, _| {});
    Assigned {
        names,
        functions,
        moved,
        given,
        led,
        grows,
    }
}

/// The variable that is meant by a target.
fn base(it: &Expr) -> Option<Word> {
    match &it.node {
        ExprNode::Name(name) => Some(name.clone()),
        ExprNode::Member(of, _)
        | ExprNode::Index(of, _)
        | ExprNode::Unary(_, of)
        | ExprNode::Recast(_, of) => base(of),
        _ => None,
    }
}

/// Does what it shows and reads, where that is all it does to the array.
pub(in crate::program::vendor) fn show(machine: &mut Machine<'_>, it: &Stmt) {
    let mut shown = Vec::new();
    walk(it, false, &mut |part| {
        if let Part::Expr(value) = part
            && let ExprNode::Call(callee, given) = &value.node
            && let ExprNode::Name(name) = &callee.node
            && host::role(last(name), given.len()) == Role::Show
        {
            shown.push(value.clone());
        }
    });
    for call in shown {
        machine.value(&call);
    }
}

/// Whether frames begin in it.
pub(in crate::program::vendor) fn syncs(machine: &Machine<'_>, it: &Stmt) -> bool {
    asks(machine, it, &|role| role == Role::Sync)
}

/// Whether it can leave a loop that has no condition.
pub(in crate::program::vendor) fn breaks(it: &Stmt) -> bool {
    holds(it, true, |node| {
        matches!(node, StmtNode::Break | StmtNode::Return(_))
    })
}

/// Whether a kernel begins in it.
pub(in crate::program::vendor) fn begins_kernel(machine: &Machine<'_>, it: &Stmt) -> bool {
    let mut found = false;
    let mut part = |it: &Part<'_>| {
        let kernel = |it: &Stmt| matches!(it.node, StmtNode::Kernel(_));
        found |= matches!(it, Part::Stmt(it) if kernel(it));
    };
    reach(machine, it, &mut part, &mut |_, _| {});
    found
}

/// The functions that it calls.
pub(super) fn called(machine: &Machine<'_>, it: &Stmt) -> Vec<Rc<Function>> {
    reach(machine, it, &mut |_| {}, &mut |_, _| {})
}

/// Whether it asks the host for something on the array, which no kernel can hold.
pub(in crate::program::vendor) fn asks_host(machine: &Machine<'_>, it: &Stmt) -> bool {
    calls_any(machine, it, &|name, _| machine.is_host(name))
}

/// Whether a value asks for the size of something of this name.
pub(in crate::program::vendor) fn sizes(it: &Expr, name: &str) -> bool {
    let mut found = false;
    values(it, &mut |part| {
        if let Part::Expr(Expr {
            node: ExprNode::SizeOf(of),
            ..
        }) = part
        {
            found |= base(of).is_some_and(|it| &*it == name);
        }
    });
    found
}

/// Whether a function calls another.
pub(in crate::program::vendor) fn calls_function(it: &Function, name: &str) -> bool {
    let mut found = false;
    for statement in it.body.iter() {
        calls(statement, &mut |called, _| found |= called == name);
    }
    found && *it.name != *name
}

/// The names that a lambda uses, and those inside it.
pub(in crate::program::vendor) fn names(
    machine: &Machine<'_>,
    function: &Function,
) -> BTreeSet<Word> {
    let (mut found, mut parts) = (BTreeSet::new(), 0);
    for statement in function.body.iter() {
        walk(statement, false, &mut |part| {
            parts += 1;
            let Part::Expr(value) = part else { return };
            match &value.node {
                ExprNode::Name(name) => {
                    found.insert(name.clone());
                }
                ExprNode::Lambda(inner) => found.extend(names(machine, inner)),
                _ => {}
            }
        });
    }
    machine.looks(parts);
    found
}
