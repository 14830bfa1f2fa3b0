//! Declarations: functions, classes and variables.

use std::rc::Rc;

use super::{
    call::Named,
    layout::{Layout, Member},
    lvalue::Reach,
    machine::{Location, Machine},
    reason::Reason,
    shape::{self, Leaf},
    value::{Slot, Value, unassigned},
};
use crate::{
    config::Place,
    program::vendor::{
        analysis::effects,
        frame::kernel,
        syntax::{
            parser::{REFERS, ended},
            tree::{Declared, Expr, ExprNode, Function, Kind, Struct, Word, last, qualifier},
        },
    },
};

/// Containers of the language's library that are not supported.
const UNREAD_CONTAINERS: [&str; 7] = [
    "map",
    "multimap",
    "unordered_map",
    "set",
    "multiset",
    "unordered_set",
    "priority_queue",
];

impl Machine<'_> {
    /// A function is declared, with its default arguments.
    pub(in crate::program::vendor) fn declare_function(&mut self, function: &Rc<Function>) {
        let known = self.prototypes.entry(function.name.clone()).or_default();
        if !known.contains(function) {
            known.push(std::rc::Rc::clone(function));
        }
    }

    /// A function is defined.
    pub(in crate::program::vendor) fn define(&mut self, function: &Rc<Function>) {
        if function.special.is_some() {
            let known = self.specials.entry(function.name.clone()).or_default();
            if !known.contains(function) {
                known.push(Rc::clone(function));
            }
            return;
        }
        let known = self.functions.entry(function.name.clone()).or_default();
        if known.contains(function) {
            return;
        }
        let alike = known.iter().find(|it| it.same_form(function));
        let alike = alike.map(|it| it.place);
        known.push(std::rc::Rc::clone(function));
        if let Some(before) = alike {
            self.stated_twice(&function.name, before, function.place);
        }
    }

    /// Files are read as one here: a name of one is a name of all.
    fn stated_twice(&mut self, name: &str, before: Place, place: Place) {
        if self.files.name(before) == self.files.name(place) {
            return;
        }
        let message = format!("`{name}` is also defined in {}", self.line(before));
        let help = "all files form one translation unit here: rename one of the two";
        self.error(place, message, "defined again", help);
    }

    /// The functions of a class.
    pub(in crate::program::vendor) fn define_members(&mut self, members: &[Rc<Function>]) {
        for function in members {
            let known = self.members.entry(function.name.clone()).or_default();
            if !known.contains(function) {
                known.push(std::rc::Rc::clone(function));
            }
        }
    }

    /// Objects are made and ended without a call that could be refused: what does that must leave
    /// the array alone.
    pub(super) fn check_members(&mut self, members: &[Rc<Function>]) {
        for function in { members.iter() }.filter(|it| it.hidden || it.is_operator()) {
            if function.body.iter().any(|it| effects::runs_words(self, it)) {
                self.error(
                    function.place,
                    format!(
                        "`{}` runs instructions of the array without an explicit call",
                        function.name.trim_start_matches('~')
                    ),
                    "a constructor, a destructor or an operator",
                    "make it a function outside the class, and call that",
                );
            }
        }
    }

    /// `std::vector<type> name(other);`: a copy, where one number would be a length.
    fn copies(&self, it: &Declared) -> Option<Declared> {
        let ([Some(of)], None) = (&it.lengths[..], &it.value) else {
            return None;
        };
        let (slot, path) = self.lies(of)?;
        let listed = matches!(self.peek(slot, &path), Some(Value::List(_)));
        (it.library && listed && matches!(of.node, ExprNode::Name(_) | ExprNode::Member(..))).then(
            || Declared {
                lengths: vec![None],
                value: Some(of.clone()),
                ..it.clone()
            },
        )
    }

    pub(super) fn declare(&mut self, it: &Declared) {
        if let Some(copy) = self.copies(it) {
            self.declared(&copy);
        } else {
            let left = self.begun(it);
            self.declared(&left);
        }
    }

    fn declared(&mut self, it: &Declared) {
        if it.value.is_none() && !it.lasting && self.home(&it.name).is_some() {
            // `extern`: the variable is there.
            return;
        }
        if it.outside && it.value.is_none() {
            let why = format!("`{}`, which is not defined", it.name);
            self.make(&it.name, Value::Unknown(why.into()), Kind::Any);
            return;
        }
        self.refuse_reference(it);
        if let Some(why) = self.unread_type(it) {
            if let Some(value) = &it.value {
                self.value(value);
            }
            self.made_unread(it, &why);
            let slot = self.make(&it.name, Value::Unknown(why.clone()), Kind::Any);
            self.not_followed.insert(slot, why);
            return;
        }
        let once = it.lasting.then(|| self.made_once(it));
        if let Some(slot) = once.as_ref().and_then(|it| self.lasting.get(it)) {
            let slot = *slot;
            if !self.apart.contains_key(&self.own_name(&it.name)) || self.scopes.len() > 1 {
                self.bind(&it.name, slot);
            }
            return;
        }
        let known = self.known_inside(it);
        // `auto`: of the type of its value.
        let given = { &it.value }
            .as_ref()
            .filter(|_| &*it.of == "auto" && !it.pointer);
        let mut given = given.map_or(Kind::Any, |value| self.kind_of(value));
        self.naming = Some(it.name.clone());
        let initial = match &it.value {
            // Another name for the same variable, or for an element.
            Some(value) if it.reference => match self.reach(value) {
                Reach::Location(slot, path) => {
                    self.naming = None;
                    self.refer_as(it, (slot, path));
                    return;
                }
                Reach::Value(Value::Unknown(why))
                    if !it.constant && matches!(value.node, ExprNode::Choose(..)) =>
                {
                    let message = format!("what `{}` refers to depends on {why}", it.name);
                    self.unknown(value.place, message, &why, None);
                    Some(Value::Unknown(why))
                }
                reached => Some(self.load(&reached, value)),
            },
            // Of the type of what a call, an index or a pointer leads to.
            Some(value) if &*it.of == "auto" && !it.pointer && leads(value) => {
                let argument = self.argument(value);
                if given == Kind::Any {
                    given = argument.kind;
                }
                Some(argument.value)
            }
            Some(value) => Some(self.within(it, |inner| inner.value(value))),
            None => None,
        };
        self.naming = None;
        let initial = match initial {
            Some(Value::Lambda(function))
                if last(&it.of) == kernel::CLASS && function.words.is_none() =>
            {
                Some(self.kernel_of(function))
            }
            Some(value) => Some(self.separate(value)),
            None => None,
        };
        let initial = initial.map(|value| self.sliced(it, value));
        let set = match initial {
            // Registers, arrays and texts are not set from outside.
            None
            | Some(
                Value::Whole(_)
                | Value::Wide(..)
                | Value::Real(_)
                | Value::Single(_)
                | Value::Unknown(_),
            ) if it.lengths.is_empty() => self.set(&it.name),
            _ => None,
        };
        let fixed = self.companion.is_some() && set.is_some();
        if let Some(set) = &set {
            self.set_within(&it.name, (set, self.resolved(it.kind)), it.place);
        }
        let value = match (set, initial) {
            (Some(value), _) | (None, Some(value)) => value,
            (None, None) if it.lengths.is_empty() => self.empty(it),
            (None, None) => self.objects(it).unwrap_or(Value::List(Vec::new())),
        };
        let value = self.shaped(it, value);
        let apart = self.settle(it);
        if let (true, Some(number)) = (it.constant, value.decimal()) {
            self.constants.entry(it.name.to_string()).or_insert(number);
        }
        let slot = self.keep(it, value, (known, given, fixed));
        if apart {
            self.apart.insert(self.own_name(&it.name), slot);
        } else if known.is_none() {
            self.bind(&it.name, slot);
        }
    }

    /// What a variable begins with to which nothing is assigned.
    fn empty(&self, it: &Declared) -> Value {
        // A variable of the file begins at 0; others hold what was there before.
        let empty = if self.scopes.len() == 1 || it.lasting {
            Value::Whole(0)
        } else {
            Value::Unknown(unassigned(&it.name))
        };
        match self.layouts.get(&it.of) {
            None if last(&it.of) == kernel::CLASS && !it.pointer => Self::empty_kernel(it.place),
            Some(layout) if !it.pointer => shape::fresh(layout, &empty),
            _ if self.is_string(&it.of) && !it.pointer => Value::Text("".into()),
            _ => empty,
        }
    }

    /// A variable of its own without a name, or the one that was made before: its type, where the
    /// declaration has none, and whether it keeps its value for good.
    fn keep(
        &mut self,
        it: &Declared,
        value: Value,
        (known, given, fixed): (Option<Slot>, Kind, bool),
    ) -> Slot {
        // What a function gives back, or a copy of another, where the type is that of the value.
        let copied = it.library || &*it.of == "auto" && !it.pointer;
        // Names of the elements of an array are those of a copy.
        let (value, bound) = match value {
            Value::Pointer(slot, path, _) if it.name.starts_with('[') && !it.reference => {
                let array = self.array_of(slot, &path).map(|it| it.0.to_vec());
                let array = array.unwrap_or(path);
                (self.at(slot, &array), self.kind_at(slot, &array))
            }
            value => (value, Kind::Any),
        };
        let copied = copied && matches!(value, Value::List(_));
        let kind = match self.resolved(it.kind) {
            Kind::Any if value.number().is_some() => given,
            // A temporary array says the type of its elements.
            Kind::Any if matches!(value, Value::List(_)) && given != Kind::Any => given,
            Kind::Any => bound,
            kind => kind,
        };
        let slot = match known {
            Some(slot) => {
                (self.slots[slot], self.kinds[slot]) = (value, kind);
                slot
            }
            None => self.hold(value, kind),
        };
        if fixed {
            self.fixed.insert(slot);
        }
        if copied {
            self.copied.insert(slot);
        }
        match &it.value {
            Some(value) if &*it.of == "auto" => {
                let named = match self.gives_string(value) {
                    Some(true) => Named::Of("string".into()),
                    _ => self.type_name(value, self.lies(value).as_ref()),
                };
                self.name_type(slot, &named);
            }
            _ if !it.pointer && !it.of.is_empty() => {
                self.classes.insert(slot, it.of.clone());
            }
            _ => {}
        }
        if it.lasting {
            let once = self.made_once(it);
            self.lasting.insert(once, slot);
        }
        slot
    }

    /// A variable whose own value names it: `sizeof(all[0])` in the braces of `all`, a function that
    /// calls itself.
    fn known_inside(&mut self, it: &Declared) -> Option<Slot> {
        let value = it.value.as_ref().filter(|_| !it.reference)?;
        let function = matches!(value.node, ExprNode::Lambda(_)) && last(&it.of) == "function";
        let sized = !it.lengths.is_empty() && effects::sizes(value, &it.name);
        let before = if function {
            Value::Unknown(unassigned(&it.name))
        } else if sized {
            // One element for those that are counted behind.
            let known = it.lengths.first().is_some_and(Option::is_some);
            let first = match it.lengths.len() {
                1 => Value::Whole(0),
                _ => Value::List(Vec::new()),
            };
            let all = if known { Vec::new() } else { vec![first] };
            self.shaped(it, Value::List(all))
        } else {
            return None;
        };
        let kind = self.resolved(it.kind);
        Some(self.make(&it.name, before, kind))
    }

    /// Refuses an object that has references as members: what it changes by them is not supported.
    pub(super) fn refuse_reference(&mut self, it: &Declared) {
        let of = last(&it.of);
        let what = self.unread.get(of).filter(|it| it.starts_with(REFERS));
        if let (Some(what), false, false) = (what, it.pointer, it.reference) {
            let message = format!("what an object of `{of}`, {what}, changes is not supported");
            let help = "make the member a pointer: `int *n`, with `&variable` where it is made";
            self.error(it.place, message, "this object", help);
        }
    }

    /// Refuses destructors that change what is not their object's, or that are seen outside:
    /// destructors are not run.
    pub(super) fn refuse_ends(&mut self, members: &[Rc<Function>]) {
        const HELP: &str =
            "do it in a member function, and call that at the end of the object's lifetime";
        for function in members {
            let Some(class) = function.name.strip_prefix('~') else {
                continue;
            };
            let does = if { function.body.iter() }.any(|it| effects::is_seen(self, it)) {
                "shows or posts something".to_owned()
            } else if let Some(name) = self.changed_at_end(class, function) {
                format!("changes `{name}`")
            } else {
                continue;
            };
            let message =
                format!("the destructor of `{class}` {does}, but destructors are not run");
            self.error(function.place, message, "this destructor", HELP);
        }
    }

    /// What a destructor changes that is not its object's.
    fn changed_at_end(&self, class: &str, function: &Function) -> Option<Word> {
        let layout = self.layouts.get(class);
        let member = |name: &Word| layout?.members.iter().find(|it| it.name == *name);
        let mut all = function
            .body
            .iter()
            .flat_map(|it| effects::assigns(self, it));
        let found = all.find(|(name, through)| match member(name) {
            Some(it) => *through && it.leads,
            None => self.find(name).is_some(),
        });
        found.map(|it| it.0)
    }

    /// Why nothing is known of a variable of this type.
    fn unread_type(&self, it: &Declared) -> Option<Reason> {
        let of = last(&it.of);
        if it.pointer || it.reference || self.layouts.contains_key(&it.of) {
            return None;
        }
        let what = match self.unread.get(of) {
            Some(what) => what.clone(),
            None if UNREAD_CONTAINERS.contains(&of) => format!("a `std::{of}`"),
            None => return None,
        };
        Some(Reason::never(&format!(
            "`{}`, {what}, which is not supported",
            it.name
        )))
    }

    /// Which variable it is, of those that are made once.
    fn made_once(&mut self, it: &Declared) -> (usize, String) {
        (
            it.place.start,
            self.instance(it.place, &format!("`{}`", it.name)),
        )
    }

    /// What the template is made for that this stands in, which is `static`.
    pub(in crate::program::vendor) fn instance(&mut self, place: Place, what: &str) -> String {
        self.made.clone().unwrap_or_else(|| {
            self.error(
                place,
                format!("it is not known which {what} this is: each type has its own"),
                "`static` in a template",
                "the template argument is not known here: use a function without a template, or make the `static` variable a global variable",
            );
            String::new()
        })
    }

    /// Another name for a variable, which may be of a class that its own is made from.
    fn refer_as(&mut self, it: &Declared, (slot, path): Location) {
        let part = match self.peek(slot, &path) {
            Some(Value::Record(layout, _)) => {
                layout.name != it.of && layout.line().any(|of| of.name == it.of)
            }
            _ => false,
        };
        if part {
            let own = self.make(&it.name, Value::Reference(slot, path), Kind::Any);
            self.classes.insert(own, it.of.clone());
        } else {
            self.refer(&it.name, (slot, path));
        }
    }

    /// A copy of the type that `auto` is: of a reference, the part that it names.
    fn sliced(&mut self, it: &Declared, value: Value) -> Value {
        let (Value::Record(layout, _), Some(from)) = (&value, &it.value) else {
            return value;
        };
        if &*it.of != "auto" || it.pointer || layout.base.is_none() {
            return value;
        }
        match &from.node {
            ExprNode::Name(name) => {
                let slot = self.find(name);
                let slot = slot.filter(|it| matches!(self.slots[*it], Value::Reference(..)));
                let class = slot.and_then(|it| self.classes.get(&it));
                match class.and_then(|it| self.layouts.get(it)) {
                    Some(layout) => shape::object(value, layout)
                        .unwrap_or_else(|why| Value::Unknown(why.into())),
                    None => value,
                }
            }
            ExprNode::Unary("*", _) => {
                let name = &layout.name;
                self.error(
                    it.place,
                    format!("`auto` may be an object of `{name}` or of its base here"),
                    "it depends on the pointer's type, which is not supported",
                    "write the class instead of `auto`",
                );
                value
            }
            _ => value,
        }
    }

    /// Forgets what the constructors and the destructor of a class could change that is not supported.
    fn made_unread(&mut self, it: &Declared, why: &Reason) {
        let class = last(&it.of);
        let callee = |name: Word| Expr {
            node: ExprNode::Name(name),
            place: it.place,
        };
        let given = match it.value.as_ref().map(|it| &it.node) {
            Some(ExprNode::Call(_, given) | ExprNode::Braces(given)) => &given[..],
            _ => &[],
        };
        self.forget_called(&callee(class.into()), given, why);
        self.forget_called(&callee(ended(class)), &[], why);
    }

    /// What an array of objects begins with, where a constructor makes each.
    fn objects(&mut self, it: &Declared) -> Option<Value> {
        let layout = self
            .layouts
            .get(&it.of)
            .filter(|it| it.constructs())?
            .clone();
        let lengths: Option<Vec<usize>> = self.lengths(it).ok()?.into_iter().collect();
        let count: usize = lengths?.into_iter().product();
        let mut all = Vec::new();
        while !it.pointer && all.len() < count && !self.done() {
            self.work(it.place);
            all.push(self.constructed(&layout, &[], it.place));
        }
        (!it.pointer).then_some(Value::List(all))
    }

    /// Where a variable of the file is declared, if that is where control is.
    fn home(&self, name: &str) -> Option<Place> {
        let outside = self.scopes.len() == 1;
        let full = format!("{}::{name}", self.space);
        self.homes.get(&*full).copied().filter(|_| outside)
    }

    /// A variable of the file is declared. Whether its file has it for itself, under a name that
    /// another file has too: one that is constant or `static`.
    fn settle(&mut self, it: &Declared) -> bool {
        if self.scopes.len() > 1 {
            return false;
        }
        let own = it.lasting || it.constant;
        let before = self.home(&it.name);
        if own && before.is_some_and(|before| self.files.name(before) != self.file) {
            return true;
        }
        let full = format!("{}::{}", self.space, it.name);
        self.homes.insert(full.into(), it.place);
        false
    }

    /// A value with the lengths and the type of what holds it.
    pub(super) fn shaped(&mut self, it: &Declared, value: Value) -> Value {
        let lengths = match self.lengths(it) {
            Ok(lengths) => lengths,
            Err(why) => return Value::Unknown(why),
        };
        let value = match value {
            // An array of the language's library is copied.
            Value::Pointer(slot, path, _) if it.library => self.at(slot, &path),
            // Pointers go over a constant text as it stands, where it is as long as its array.
            Value::Text(text) if it.constant && fills(&text, &lengths) => return Value::Text(text),
            value => value,
        };
        let layout = self.layouts.get(&it.of).filter(|_| !it.pointer).cloned();
        let value = self.with_keys(value, layout.as_deref());
        let leaf = Leaf {
            kind: self.resolved(it.kind),
            layout: layout.as_ref(),
            library: it.library,
            text: self.is_string(&it.of) && !it.pointer,
        };
        let made = shape::shaped(value, &lengths, leaf).unwrap_or_else(|message| {
            self.error(
                it.place,
                format!("`{}`: {message}", it.name),
                "this declaration",
                "give no more values than it holds",
            );
            Value::Whole(0)
        });
        self.with_texts(made, leaf.text)
    }

    /// A class is defined.
    pub(super) fn class(&mut self, it: &Struct, place: Place) {
        if let Some(what) = it.unread {
            let first = it.stops.map(|at| self.line(at));
            let first = first.map_or_else(String::new, |it| format!(" (the first in {it})"));
            let what = format!("{what} in {}{first}", self.line(place));
            self.unread.insert(it.name.clone(), what);
            self.refuse_ends(&it.functions);
            return;
        }
        if let Some(member) = it.members.iter().find(|it| effects::acts(self, it)) {
            let (name, line) = (&member.name, self.line(place));
            let what = format!(
                "a class whose member `{name}` has an initialiser with side effects, in {line}"
            );
            self.unread.insert(it.name.clone(), what);
            self.layouts.remove(&it.name);
            return;
        }
        let base = { it.base.as_ref() }.and_then(|it| self.layouts.get(it).cloned());
        if let Some(what) = base.as_ref().and_then(|base| hides(it, base)) {
            let what = format!("{what}, in {}", self.line(place));
            self.unread.insert(it.name.clone(), what);
            self.layouts.remove(&it.name);
            return;
        }
        let mut members = base.as_ref().map_or_else(Vec::new, |it| it.members.clone());
        // They know the constants of their class.
        let outer = std::mem::replace(&mut self.space, it.space.clone());
        members.extend(it.members.iter().map(|it| self.member_of(it)));
        self.space = outer;
        let values = shape::values(&members);
        if !self.fits(values, place) {
            self.layouts.remove(&it.name);
            return;
        }
        let mut layout = Layout {
            name: it.name.clone(),
            space: it.space.clone(),
            values,
            members,
            functions: it.functions.clone(),
            base,
            entry: None,
        };
        if it.map {
            let entry = Layout {
                name: "pair".into(),
                ..layout
            };
            layout = Layout::of_values(&it.name, Vec::new());
            layout.entry = Some(entry.into());
        }
        self.layouts.insert(it.name.clone(), layout.into());
        self.refuse_ends(&it.functions);
    }

    /// A member of a class, as it is declared.
    fn member_of(&mut self, it: &Declared) -> Member {
        let layout = self.layouts.get(&it.of).filter(|_| !it.pointer).cloned();
        let lengths = self.lengths(it);
        let text = self.is_string(&it.of) && !it.pointer;
        let empty = (text && it.lengths.is_empty()).then(|| Value::Text("".into()));
        let initial = it.value.as_ref().map(|value| self.value(value));
        let (lengths, initial) = match lengths {
            Ok(lengths) => (lengths, initial.or(empty)),
            Err(why) => (Vec::new(), Some(Value::Unknown(why))),
        };
        Member {
            name: it.name.clone(),
            kind: it.kind,
            leads: it.pointer || it.reference,
            library: it.library,
            text,
            default: initial.map(|value| self.shaped(it, value)),
            lengths,
            layout,
        }
    }

    /// Works in the class that the name of a variable begins with: what its objects share.
    fn within<T>(&mut self, it: &Declared, act: impl FnOnce(&mut Self) -> T) -> T {
        let Some(class) = qualifier(&it.name) else {
            return act(self);
        };
        let space = match &*self.space {
            "" => class.into(),
            outer => format!("{outer}::{class}").into(),
        };
        let outer = std::mem::replace(&mut self.space, space);
        let made = act(self);
        self.space = outer;
        made
    }

    /// The lengths of an array; none is known where it is too large. `Err` says what decides on one
    /// that is not known.
    fn lengths(&mut self, it: &Declared) -> Result<Vec<Option<usize>>, Reason> {
        let mut lengths = Vec::new();
        for length in &it.lengths {
            let Some(length) = length else {
                lengths.push(None);
                continue;
            };
            let value = match self.within(it, |inner| inner.value(length)) {
                Value::Symbol(name) => self.unheard(&name, length.place),
                value => value,
            };
            if let Value::Unknown(why) = value {
                return Err(why);
            }
            let whole = value.whole().and_then(|n| usize::try_from(n).ok());
            if whole.is_none() {
                let count = value
                    .whole()
                    .map_or_else(|| value.describe(), |it| it.to_string());
                let message = format!("an array of {count} elements");
                let help = "give it a length of 0 or more";
                self.error(length.place, message, "this length", help);
            }
            lengths.push(whole);
        }
        let layout = self.layouts.get(&it.of).filter(|_| !it.pointer);
        let one = layout.map_or(1, |it| it.values);
        if !self.fits(shape::count(one, &lengths), it.place) {
            lengths.fill(None);
        }
        Ok(lengths)
    }
}

/// Whether a text is as long as its array, with the 0 at its end.
fn fills(text: &str, lengths: &[Option<usize>]) -> bool {
    match lengths {
        [length] => length.is_none_or(|it| it == text.len() + 1),
        _ => false,
    }
}

/// What a class is that has something under a name of its base, where it depends on the type of a
/// pointer or a reference which of the two is meant.
fn hides(it: &Struct, base: &Layout) -> Option<String> {
    if let Some(member) = it.members.iter().find(|it| base.names(&it.name)) {
        return Some(format!("a class with a `{}` as its base", member.name));
    }
    let defaults = |it: &Rc<Function>| -> Vec<Option<Expr>> {
        it.parameters.iter().map(|it| it.default.clone()).collect()
    };
    let given = |it: &Rc<Function>| it.parameters.iter().any(|it| it.default.is_some());
    let differs = it.functions.iter().find(|it| {
        let mut all = std::iter::successors(Some(base), |it| it.base.as_deref());
        let above = all.find_map(|of| of.functions.iter().find(|of| of.overrides(it)));
        above.is_some_and(|of| {
            (given(it) || given(of)) && !alike(&defaults(it), &defaults(of)) && base.is_virtual(it)
        })
    });
    if let Some(it) = differs {
        return Some(format!(
            "a class whose `{}` has other default arguments than that of its base",
            it.name
        ));
    }
    let own = it.functions.iter();
    let mut own = own.filter(|of| of.name != it.name && !of.hidden);
    let hiding = own.find(|it| base.names(&it.name) && !base.is_virtual(it))?;
    Some(format!(
        "a class whose `{}` hides that of its base, which is not `virtual`",
        hiding.name
    ))
}

/// Whether default arguments are written the same.
fn alike(some: &[Option<Expr>], others: &[Option<Expr>]) -> bool {
    let same = |(a, b): (&Option<Expr>, &Option<Expr>)| match (a, b) {
        (Some(a), Some(b)) => match (&a.node, &b.node) {
            (ExprNode::Unary(one, a), ExprNode::Unary(other, b)) => {
                one == other && a.node == b.node
            }
            (a, b) => a == b,
        },
        (None, None) => true,
        _ => false,
    };
    some.len() == others.len() && some.iter().zip(others).all(same)
}

/// Whether a value may lie somewhere that only running it finds.
fn leads(it: &Expr) -> bool {
    matches!(
        it.node,
        ExprNode::Call(..)
            | ExprNode::Template(..)
            | ExprNode::Member(..)
            | ExprNode::Index(..)
            | ExprNode::Unary("*", _)
    )
}
