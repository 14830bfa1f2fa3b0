//! A call of a function of the program: its arguments become its parameters.

use std::{collections::BTreeMap, rc::Rc};

use super::overload::{Argument, Lost, Named};
use crate::{
    config::Place,
    program::vendor::{
        interpreter::{
            machine::{Flow, Machine},
            reason::Reason,
            shape,
            value::Value,
        },
        syntax::tree::{Expr, Function, Kind, Parameter, TemplateArgument, Word},
    },
};

/// Calls inside each other.
const DEPTH: usize = 64;

impl Machine<'_> {
    /// The default of a parameter, in its definition or a declaration.
    pub(in crate::program::vendor) fn default(
        &self,
        function: &Function,
        index: usize,
    ) -> Option<Expr> {
        let own = function.parameters.get(index)?.default.clone();
        own.or_else(|| {
            let declared = self.prototypes.get(&function.name)?.iter();
            let mut alike = declared.filter(|it| {
                let kinds =
                    |it: &Function| it.parameters.iter().map(|p| p.kind).collect::<Vec<_>>();
                it.space == function.space && kinds(it) == kinds(function)
            });
            alike.find_map(|it| it.parameters[index].default.clone())
        })
    }

    /// Runs a function with these arguments. A lambda has with it what it uses of the names around
    /// it.
    pub(in crate::program::vendor) fn enter(
        &mut self,
        function: &Rc<Function>,
        given: &[Expr],
        place: Place,
    ) -> Value {
        let given = given.iter().map(|it| self.argument(it)).collect();
        self.enter_with(function, given, None, place)
    }

    pub(in crate::program::vendor) fn enter_with(
        &mut self,
        function: &Rc<Function>,
        given: Vec<Argument>,
        angles: Option<Vec<TemplateArgument>>,
        place: Place,
    ) -> Value {
        if self.depth == DEPTH {
            self.error(
                place,
                format!("more than {DEPTH} nested calls"),
                "this call",
                "if the function calls itself, write a loop instead",
            );
            return Value::Whole(0);
        }
        // What its arguments begin with is worked out inside it.
        self.depth += 1;
        self.entered.insert(function.place.start);
        let mut scope: BTreeMap<Word, usize> = function.held.iter().cloned().collect();
        let types = if function.template.is_empty() {
            // A lambda inside a template has its types.
            function.name.is_empty().then(|| self.types.clone())
        } else {
            Some(self.template(
                function,
                &given,
                angles.unwrap_or_default(),
                &mut scope,
                place,
            ))
        };
        if let Some(special) = self.special((function, place), types.as_deref(), &scope) {
            self.depth -= 1;
            return self.enter_with(&special, given, None, place);
        }
        let made = self.made_for(function, &given, types.as_deref(), &scope);
        let outer = (
            std::mem::replace(&mut self.types, types.unwrap_or_default()),
            std::mem::replace(&mut self.made, made),
        );
        self.bind_parameters(function, given, &mut scope, place);
        let (base, maybe) = (self.base, self.maybe.clone());
        let space = std::mem::replace(&mut self.space, function.space.clone());
        let file = std::mem::replace(&mut self.file, self.files.name(function.place));
        self.base = self.scopes.len();
        self.scopes.push(scope);
        let refers = std::mem::replace(&mut self.refers, function.refers);
        let flow = self.statements(&function.body);
        self.refers = refers;
        self.depth -= 1;
        self.scopes.pop();
        self.base = base;
        (self.space, self.file) = (space, file);
        let returns = self.resolved(function.returns);
        (self.types, self.made) = outer;
        // Whether it returned early is its own affair, but for what it gives back.
        let unsure = std::mem::replace(&mut self.maybe, maybe.clone());
        self.referred = None;
        match (flow, unsure) {
            (flow, Some(why)) if maybe.is_none() => {
                if let Flow::Return(Value::Pointer(slot, ..)) = flow {
                    self.lose(slot, &why);
                }
                Value::Unknown(why)
            }
            (Flow::Return(Value::Reference(slot, path)), _) => {
                let value = self.decayed(slot, &path, &function.name);
                self.referred = Some((self.calls, (slot, path)));
                value
            }
            (Flow::Return(value), _) => self.given_of(function, value).converted(returns),
            (Flow::Next, _)
                if matches!(
                    returns,
                    Kind::Bits(..) | Kind::Flag | Kind::Float | Kind::Real
                ) =>
            {
                let name = Some(&*function.name).filter(|name| !name.is_empty());
                let name = name.map_or_else(|| "a lambda".to_owned(), |name| format!("`{name}`"));
                let why = format!("{name}, which ends without a `return`");
                Value::Unknown(Reason::never(&why))
            }
            _ => Value::Whole(0),
        }
    }

    /// Makes the parameters of a function.
    fn bind_parameters(
        &mut self,
        function: &Function,
        given: Vec<Argument>,
        scope: &mut BTreeMap<Word, usize>,
        place: Place,
    ) {
        let mut given = given.into_iter();
        for (i, parameter) in function.parameters.iter().enumerate() {
            let mut kind = self.resolved(parameter.kind);
            let next = given.next();
            if let Some(it) = &next
                && &*parameter.of == "auto"
                && kind == Kind::Any
                && !parameter.pointer
                && !matches!(it.value, Value::Pointer(..))
            {
                kind = self.element_kind(it);
            }
            let slot = match (next, self.default(function, i)) {
                (Some(it), _) => {
                    self.loses((&it, function), parameter, place);
                    self.given(it, kind, parameter)
                }
                (None, Some(default)) => {
                    // It sees the names of the file, not those of the caller.
                    let base = std::mem::replace(&mut self.base, self.scopes.len());
                    let space = std::mem::replace(&mut self.space, function.space.clone());
                    let value = self.value(&default);
                    (self.base, self.space) = (base, space);
                    self.taken(value, kind, parameter)
                }
                // What `main` is started with.
                (None, None) => {
                    let why = if parameter.pointer || kind == Kind::Any {
                        Reason::never(&format!("`{}`", parameter.name))
                    } else {
                        Reason::Started(parameter.name.clone())
                    };
                    self.hold(Value::Unknown(why), Kind::Any)
                }
            };
            scope.insert(parameter.name.clone(), slot);
        }
    }

    /// What a function gives back, as an object of the class that it says, or an array of them.
    fn given_of(&self, function: &Function, value: Value) -> Value {
        let made = |value: Value, class: &Word| match self.layouts.get(class) {
            Some(layout) => shape::element(value, Some(layout)),
            None => value,
        };
        if self.is_string(&function.gives) {
            return self.string_of(value);
        }
        let value = match value {
            Value::List(all) if self.layouts.contains_key(&function.element) => Value::List(
                { all.into_iter() }
                    .map(|it| made(it, &function.element))
                    .collect(),
            ),
            value => made(value, &function.gives),
        };
        self.with_texts(value, self.is_string(&function.element))
    }

    /// An argument that a function may change, of which only the run knows which variable it is.
    fn loses(
        &mut self,
        (it, function): (&Argument, &Function),
        parameter: &Parameter,
        place: Place,
    ) {
        let (Value::Unknown(why), Some(lost), true) = (&it.value, &it.lost, parameter.reference)
        else {
            return;
        };
        match lost {
            Lost::Element((slot, path)) => self.forget(*slot, path, why),
            Lost::Choice => {
                let name = match &*function.name {
                    "" => "a lambda".to_owned(),
                    name => format!("`{name}`"),
                };
                let message = format!("which variable {name} changes depends on {why}");
                self.unknown(place, message, why, None);
            }
        }
    }

    /// The variable that a parameter is: that which it refers to, or one of its own.
    fn given(&mut self, it: Argument, kind: Kind, parameter: &Parameter) -> usize {
        // A constant refers to what has its type; of anything else it is made anew.
        let same = parameter.alias && !parameter.pointer && self.is_of(&it, kind, parameter);
        match it.location {
            Some((slot, path)) if parameter.reference || same => {
                let part = match &it.value {
                    Value::Record(layout, _) => {
                        layout.name != parameter.of && self.layouts.contains_key(&parameter.of)
                    }
                    _ => false,
                };
                if path.is_empty() && !part {
                    return slot;
                }
                let own = self.hold(Value::Reference(slot, path), Kind::Any);
                if part {
                    self.classes.insert(own, parameter.of.clone());
                }
                own
            }
            _ => {
                let slot = self.taken(it.value, kind, parameter);
                if matches!(parameter.kind, Kind::Parameter(_)) {
                    self.name_type(slot, &it.named);
                }
                slot
            }
        }
    }

    /// A variable has the type of a number, whatever its declaration calls it.
    pub(in crate::program::vendor) fn name_type(&mut self, slot: usize, named: &Named) {
        let class = match named {
            Named::Number => return,
            Named::Of(of) => of.clone(),
            Named::Unclear => "".into(),
        };
        self.classes.insert(slot, class);
    }

    /// Whether an argument is of the type of a parameter, or of a class that is made from it.
    fn is_of(&self, it: &Argument, kind: Kind, parameter: &Parameter) -> bool {
        match &it.value {
            Value::Record(layout, _) => match self.layouts.get(&parameter.of) {
                Some(_) => layout.line().any(|it| it.name == parameter.of),
                None => true,
            },
            Value::List(_) => !self.layouts.contains_key(&parameter.of),
            Value::Whole(_) | Value::Wide(..) | Value::Real(_) | Value::Single(_) => {
                kind == Kind::Any || kind == it.kind
            }
            Value::Unknown(_) => kind == it.kind,
            // A text that a pointer leads to is copied.
            Value::Text(_) => {
                let held = it.location.as_ref();
                let text = held.is_some_and(|(slot, path)| self.string_at(*slot, path));
                kind == Kind::Any && (text || !self.is_string(&parameter.of))
            }
            _ => false,
        }
    }

    /// A variable of its own for a parameter.
    fn taken(&mut self, value: Value, kind: Kind, parameter: &Parameter) -> usize {
        let value = self.separate(value);
        let value = match (self.layouts.get(&parameter.of), value) {
            // A reference keeps the class of the object.
            (Some(_), value @ Value::Record(..)) if parameter.alias && !braces(&value) => value,
            (Some(layout), value @ (Value::List(_) | Value::Record(..))) if !parameter.pointer => {
                let made = shape::object(value, layout);
                made.unwrap_or_else(|why| Value::Unknown(why.into()))
            }
            (_, value) if !parameter.pointer && self.is_string(&parameter.of) => {
                self.string_of(value)
            }
            (_, value) => shape::deep(value, kind),
        };
        let texts = !parameter.pointer && self.is_string(&parameter.element);
        let value = self.with_texts(value, texts);
        let whole = matches!(value, Value::List(_));
        let slot = self.hold(value, kind);
        let of = if parameter.element.is_empty() {
            &parameter.of
        } else {
            &parameter.element
        };
        if !of.is_empty() && !parameter.pointer {
            self.classes.insert(slot, of.clone());
        }
        if whole {
            self.copied.insert(slot);
        }
        slot
    }

    /// What a template is made for, in words: each has variables of its own that are made once.
    fn made_for(
        &self,
        function: &Function,
        given: &[Argument],
        types: Option<&[Kind]>,
        scope: &BTreeMap<Word, usize>,
    ) -> Option<String> {
        if function.template.is_empty() {
            // A lambda inside a template has its types.
            let inner = function.name.is_empty();
            return if inner {
                self.made.clone()
            } else {
                Some(String::new())
            };
        }
        let mut words = Vec::new();
        for (at, parameter) in function.template.iter().enumerate() {
            let kind = types
                .and_then(|it| it.get(at))
                .copied()
                .unwrap_or(Kind::Any);
            words.push(match (scope.get(&parameter.name), parameter.is_type) {
                (Some(slot), false) => format!("{:?},", self.slots[*slot]),
                _ if kind != Kind::Any => format!("{kind:?},"),
                _ => {
                    let mut all = given.iter().zip(function.parameters.iter());
                    let it = all.find(|(_, to)| to.kind == Kind::Parameter(at))?.0;
                    match &it.value {
                        Value::Record(layout, _) => format!("{},", layout.name),
                        Value::Symbol(register) => {
                            format!("{:?},", self.register_kind(register)?)
                        }
                        _ => return None,
                    }
                }
            });
        }
        Some(words.concat())
    }

    /// Whether a template was only announced.
    fn is_announced(&self, function: &Rc<Function>) -> bool {
        let all = self.prototypes.get(&function.name).into_iter().flatten();
        function.body.is_empty() && { all }.any(|it| Rc::ptr_eq(it, function))
    }

    /// The body that a template has for what it is given here.
    fn special(
        &mut self,
        (function, place): (&Rc<Function>, Place),
        types: Option<&[Kind]>,
        scope: &BTreeMap<Word, usize>,
    ) -> Option<Rc<Function>> {
        if function.template.is_empty() {
            return None;
        }
        let all = self.specials.get(&function.name)?.clone();
        let of_class = all.iter().find(|it| {
            let angles = it.special.iter().flat_map(|it| it.iter());
            let mut pairs = angles.zip(&function.template);
            pairs.any(|(it, of)| of.is_type && matches!(it, TemplateArgument::Value(_)))
        });
        if let Some(it) = of_class {
            self.error(
                it.place,
                "a template specialised for a class is not supported".to_owned(),
                "behind `template <>`",
                "write it as a function with another name, and call that",
            );
            return None;
        }
        let count = function.parameters.len();
        let own = |it: &&Rc<Function>| it.space == function.space && it.parameters.len() == count;
        let found = all.iter().filter(own).find(|special| {
            let angles = special.special.clone().unwrap_or_default();
            function.template.iter().enumerate().all(|(at, parameter)| {
                let given = types.and_then(|it| it.get(at)).copied();
                // What is not said is taken from the parameters.
                let deduced = || {
                    let of = |it: &&Parameter| it.kind == Kind::Parameter(at);
                    let at = function.parameters.iter().position(|it| of(&it))?;
                    Some(special.parameters[at].kind)
                };
                match (angles.get(at), parameter.is_type) {
                    (Some(TemplateArgument::Type(kind)), true) => given == Some(*kind),
                    (None, true) => given.is_some() && given == deduced(),
                    (Some(TemplateArgument::Value(value)), false) => {
                        let wanted = self.value(value);
                        let held = scope.get(&parameter.name).map(|it| &self.slots[*it]);
                        held.is_some_and(|it| match (it.number(), wanted.number()) {
                            (Some(one), Some(other)) => one == other,
                            _ => *it == wanted,
                        })
                    }
                    _ => false,
                }
            })
        });
        if found.is_none() && self.is_announced(function) {
            self.error(
                place,
                format!("`{}` has no definition for these arguments", function.name),
                "this call",
                "only specialisations (`template <>`) are defined",
            );
        }
        found.cloned()
    }

    /// The type of a number that is given, or of those that a pointer or an array leads to.
    fn element_kind(&self, it: &Argument) -> Kind {
        let held = match &it.value {
            Value::Pointer(slot, path, _) => {
                let (slot, path) = self.pointed(*slot, path.clone());
                let kind = self.kind_at(slot, &path);
                return match self.peek(slot, &path) {
                    Some(value) if kind == Kind::Any => value.kind(),
                    _ => kind,
                };
            }
            Value::List(all) if it.kind == Kind::Any => all.first().map(Value::kind),
            _ => None,
        };
        held.unwrap_or(it.kind)
    }

    /// What the parameters of a template are: given in `<…>`, taken from the arguments, or their
    /// defaults. Values become variables, types are given back by position.
    fn template(
        &mut self,
        function: &Function,
        given: &[Argument],
        angles: Vec<TemplateArgument>,
        scope: &mut BTreeMap<Word, usize>,
        place: Place,
    ) -> Vec<Kind> {
        let mut types = Vec::new();
        let mut angles = angles.into_iter();
        for (at, parameter) in function.template.iter().enumerate() {
            let given_here = angles.next();
            let default = given_here.is_none();
            let given_here = given_here.or_else(|| parameter.default.clone());
            let deduced = || {
                let wanted = Kind::Parameter(at);
                let mut all = given.iter().zip(function.parameters.iter());
                let of = |to: &Parameter| {
                    let leads = to.pointer || !to.element.is_empty();
                    to.kind == wanted || leads && to.pointee == wanted
                };
                let it = all.find(|(_, to)| of(to))?.0;
                Some(TemplateArgument::Type(self.element_kind(it)))
            };
            let length = || {
                let mut all = given.iter().zip(function.parameters.iter());
                let (it, depth) = all.find_map(|(it, to)| {
                    let mut names = to.extents.iter();
                    Some((it, names.position(|it| *it == parameter.name)?))
                })?;
                let (slot, path) = it.location.as_ref()?;
                let mut held = self.peek(*slot, path)?;
                for _ in 0..depth {
                    let Value::List(all) = held else {
                        return None;
                    };
                    held = all.first()?;
                }
                let Value::List(all) = held else {
                    return None;
                };
                Some(Value::Whole(all.len() as i64))
            };
            if let (None, false, Some(length)) = (&given_here, parameter.is_type, length()) {
                let slot = self.hold(length, Kind::INT);
                scope.insert(parameter.name.clone(), slot);
                types.push(Kind::Any);
                continue;
            }
            let kind = match given_here.or_else(deduced) {
                Some(TemplateArgument::Type(kind)) => self.resolved(kind),
                Some(TemplateArgument::Value(value)) if !parameter.is_type => {
                    // A default knows the parameters before it.
                    let around = if default {
                        scope.clone()
                    } else {
                        BTreeMap::new()
                    };
                    self.scopes.push(around);
                    let value = self.value(&value);
                    self.scopes.pop();
                    let slot = self.hold(value, Kind::Any);
                    scope.insert(parameter.name.clone(), slot);
                    Kind::Any
                }
                _ if parameter.is_type => Kind::Any,
                _ => {
                    let name = &function.name;
                    self.error(
                        place,
                        format!(
                            "the template argument `{}` of `{name}` is missing",
                            parameter.name
                        ),
                        "this call",
                        &format!("write `{name}<value>(…)`"),
                    );
                    Kind::Any
                }
            };
            types.push(kind);
        }
        types
    }
}

/// Whether a value stands in braces, with the names of its members.
fn braces(value: &Value) -> bool {
    matches!(value, Value::Record(layout, _) if layout.is_designated())
}
