//! Functions of classes that hold data and nothing more: they are run with their object.

use std::rc::Rc;

use super::Argument;
use crate::{
    config::Place,
    program::vendor::{
        interpreter::{
            layout::Layout,
            lvalue::Reach,
            machine::{Location, Machine},
            reason::Reason,
            shape,
            value::{Slot, Value, unassigned},
        },
        syntax::{
            parser::UNREAD,
            tree::{Bound, Expr, ExprNode, Function, Kind, StmtNode, Word, last, qualifier},
        },
    },
    unit::counted,
};

impl Machine<'_> {
    /// Calls a function of an object; nothing where its class defines none that can be run.
    pub(in crate::program::vendor) fn member_call(
        &mut self,
        layout: &Rc<Layout>,
        object: &Reach,
        member: &str,
        given: &[Expr],
        place: Place,
    ) -> Option<Value> {
        // `Base::name`: that of this class, whatever the object is.
        let (base, member) = (qualifier(member), last(member));
        let class = match base {
            None => layout,
            Some(of) => layout.line().find(|it| *it.name == *last(of))?,
        };
        let fitting = self.own_functions(class, member, given.len());
        if fitting.is_empty() {
            return None;
        }
        let location = match object {
            Reach::Location(slot, path) => (*slot, path.clone()),
            Reach::Value(value) => (self.hold(value.clone(), Kind::Any), Vec::new()),
            Reach::Lost(..) | Reach::Beyond(_) => return None,
        };
        let given: Vec<_> = given.iter().map(|it| self.argument(it)).collect();
        let Some(function) = self.overload(member, &fitting, &given, place) else {
            return Some(Value::Whole(0));
        };
        Some(match base {
            None => self.enter_own(layout, &function, &location, given, place),
            Some(_) => self.enter_member(layout, &function, &location, given, place),
        })
    }

    /// Calls a function of the object whose function runs, by its name alone or by `Base::name`.
    pub(super) fn own_call(&mut self, name: &str, given: &[Expr], place: Place) -> Option<Value> {
        let location = self.this()?;
        let Some(Value::Record(layout, _)) = self.peek(location.0, &location.1) else {
            return None;
        };
        let layout = Rc::clone(layout);
        let class = match qualifier(name) {
            // As the class has it whose function runs.
            None => layout.line().find(|it| it.space == self.space)?,
            Some(of) => layout.line().find(|it| *it.name == *last(of))?,
        };
        let fitting = self.own_functions(class, last(name), given.len());
        if fitting.is_empty() {
            return None;
        }
        let given: Vec<_> = given.iter().map(|it| self.argument(it)).collect();
        let Some(function) = self.overload(last(name), &fitting, &given, place) else {
            return Some(Value::Whole(0));
        };
        Some(match qualifier(name) {
            None => self.enter_own(&layout, &function, &location, given, place),
            Some(_) => self.enter_member(&layout, &function, &location, given, place),
        })
    }

    /// The functions of this name of a class, or of the nearest that it is made from, which take so
    /// many arguments and can be run.
    pub(in crate::program::vendor) fn own_functions(
        &self,
        layout: &Rc<Layout>,
        name: &str,
        given: usize,
    ) -> Vec<Rc<Function>> {
        for class in layout.line().filter(|it| *it.name != *name) {
            let all = self.written_of(class, name);
            if !all.is_empty() {
                return all.into_iter().filter(|it| self.takes(it, given)).collect();
            }
        }
        Vec::new()
    }

    /// The functions of this name of a class itself, in it and behind it.
    fn written_of(&self, class: &Layout, name: &str) -> Vec<Rc<Function>> {
        let behind = self.functions.get(name).into_iter().flatten();
        let behind = behind.filter(|it| it.qualified && it.space == class.space);
        let inside = class.functions.iter().filter(|it| *it.name == *name);
        let mut all: Vec<_> = inside.chain(behind).cloned().collect();
        // What is only announced gives way to what stands behind the class.
        let whole = |it: &Rc<Function>| !matches!(it.bound, Bound::Pure | Bound::Announced);
        let bodies: Vec<_> = { all.iter() }.filter(|it| whole(it)).cloned().collect();
        all.retain(|it| whole(it) || !bodies.iter().any(|of| of.overrides(it)));
        all
    }

    /// Whether a function of a class takes so many arguments, and can be run.
    fn takes(&self, it: &Function, given: usize) -> bool {
        self.accepts(it, given) && runs(it)
    }

    fn accepts(&self, it: &Function, given: usize) -> bool {
        let parameters = 0..it.parameters.len();
        let least = parameters.filter(|i| self.default(it, *i).is_none());
        (least.count()..=it.parameters.len()).contains(&given)
    }

    /// Runs a function of an object, or the one that its class has in place of it.
    pub(in crate::program::vendor) fn enter_own(
        &mut self,
        layout: &Rc<Layout>,
        function: &Rc<Function>,
        object: &Location,
        given: Vec<Argument>,
        place: Place,
    ) -> Value {
        let mut function = Rc::clone(function);
        if layout.is_virtual(&function) {
            let count = function.parameters.len();
            let found = layout.line().find_map(|class| {
                let all = self.own_functions(class, &function.name, count);
                all.into_iter().find(|it| it.overrides(&function))
            });
            function = found.unwrap_or(function);
        }
        self.enter_member(layout, &function, object, given, place)
    }

    /// Runs a function of an object.
    fn enter_member(
        &mut self,
        layout: &Rc<Layout>,
        function: &Function,
        object: &Location,
        given: Vec<Argument>,
        place: Place,
    ) -> Value {
        let mut function = function.clone();
        function.held = self.members_of(layout, object);
        // Each name is a variable, and is looked up in the call.
        self.looks(8 * layout.members.len());
        self.enter_with(&function.into(), given, None, place)
    }

    /// Makes the part of an object that is of a base, or all of it by another constructor.
    pub(in crate::program::vendor) fn part_made(
        &mut self,
        layout: &Rc<Layout>,
        object: &Reach,
        class: &str,
        given: &[Expr],
        place: Place,
    ) -> Option<Value> {
        let class = layout.line().find(|it| *it.name == *class)?.clone();
        let made = if class.constructs() {
            self.constructed(&class, given, place)
        } else {
            let given = given.iter().map(|it| self.value(it)).collect();
            self.record(&class, given)
        };
        let Reach::Location(slot, path) = object else {
            return None;
        };
        match made {
            Value::Record(_, all) => {
                for (i, value) in all.into_iter().enumerate() {
                    self.put(*slot, &[&path[..], &[i]].concat(), value);
                }
            }
            Value::Unknown(why) => self.forget(*slot, path, &why),
            _ => {}
        }
        Some(Value::Whole(0))
    }

    /// An object of a class with constructors, made of these.
    pub(in crate::program::vendor) fn constructed(
        &mut self,
        layout: &Rc<Layout>,
        given: &[Expr],
        place: Place,
    ) -> Value {
        let name = &layout.name;
        let own = self.written_of(layout, name);
        let fitting: Vec<_> = { own.iter() }
            .filter(|it| self.takes(it, given.len()))
            .cloned()
            .collect();
        let announced =
            |it: &&Rc<Function>| it.bound == Bound::Announced && self.accepts(it, given.len());
        let announced = own.iter().find(announced).map(|it| it.place);
        let given: Vec<_> = given.iter().map(|it| self.argument(it)).collect();
        let same = |it: &Value| match it {
            Value::Record(of, _) => of.line().any(|it| it.name == *name),
            _ => false,
        };
        if let [only] = &given[..]
            && same(&only.value)
            && let Ok(copied) = shape::object(only.value.clone(), layout)
        {
            return copied;
        }
        let unknown = Value::Unknown(format!("an object of `{name}`").into());
        if let (true, Some(at)) = (fitting.is_empty(), announced) {
            let line = self.line(at);
            let why = format!("an object of `{name}`, whose constructor in {line} is not defined");
            return Value::Unknown(Reason::never(&why));
        }
        if fitting.is_empty() {
            let given = counted(given.len(), "value");
            self.error(
                place,
                format!("no constructor of `{name}` takes {given}"),
                "made here",
                "use the arguments of one of its constructors",
            );
            return unknown;
        }
        let Some(function) = self.overload(name, &fitting, &given, place) else {
            return unknown;
        };
        let fresh = shape::fresh(layout, &Value::Unknown(unassigned(name)));
        let slot = self.hold(fresh, Kind::Any);
        self.enter_member(layout, &function, &(slot, Vec::new()), given, place);
        self.slots[slot].clone()
    }

    /// What the functions of an object call its members by.
    pub(in crate::program::vendor) fn members_of(
        &mut self,
        layout: &Layout,
        (slot, path): &Location,
    ) -> Vec<(Word, Slot)> {
        let mut held: Vec<(Word, Slot)> = Vec::new();
        for (i, member) in layout.members.iter().enumerate() {
            let own = Value::Reference(*slot, [&path[..], &[i]].concat());
            held.push((member.name.clone(), self.hold(own, Kind::Any)));
        }
        let this = Value::Pointer(*slot, path.clone(), "this".into());
        held.push(("this".into(), self.hold(this, Kind::Any)));
        held
    }
}

/// Whether all of a function was understood.
fn runs(it: &Function) -> bool {
    it.template.is_empty()
        && !it.hidden
        && it.bound != Bound::Announced
        && it.body.iter().all(|part| match &part.node {
            StmtNode::Expr(Expr {
                node: ExprNode::Call(callee, _),
                ..
            }) => !matches!(&callee.node, ExprNode::Name(name) if name.starts_with(UNREAD)),
            _ => true,
        })
}
