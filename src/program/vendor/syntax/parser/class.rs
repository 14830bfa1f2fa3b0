//! Classes, structs and enumerations.

use std::{collections::BTreeMap, rc::Rc};

use super::{
    Parsed, Parser,
    constructor::copies,
    expression::unexpected,
    types::{QUALIFIERS, RESERVED, Type},
    within,
};
use crate::{
    config::Place,
    program::vendor::{
        lexer::token::{Token, TokenKind},
        syntax::tree::{
            Bound, Declared, Expr, ExprNode, Function, Kind, Parameter, Stmt, StmtNode, Struct,
            Word, last, qualifier,
        },
    },
};

/// What stands between the braces of a class.
struct Body {
    /// Its data, where nothing else matters when an object is made.
    data: Option<Vec<Declared>>,
    functions: Vec<Rc<Function>>,
    /// Whether a member is a reference.
    refers: bool,
    /// The first member that is not understood.
    stops: Option<Place>,
}

/// Words that begin a type that is defined where it is used.
const TYPES: [&str; 4] = ["class", "struct", "union", "enum"];

impl Parser<'_> {
    /// The constants of an enumeration, and the variables of it that are declared with it, of a type
    /// that these words say more of.
    pub(super) fn enumeration(
        &mut self,
        named_behind: bool,
        more: Type,
    ) -> Parsed<(StmtNode, Option<StmtNode>)> {
        self.at += 1;
        // The names of an `enum class` are only its own.
        let scoped = self.take_word("class") || self.take_word("struct");
        let of: Word = self.word(0).into();
        let own = Some(&*of).filter(|it| scoped && !it.is_empty());
        let outer = self.inside.as_deref();
        let all: Vec<&str> = outer.into_iter().chain(own).collect();
        let space = Some(all.join("::")).filter(|it| !it.is_empty());
        let mut kind = Kind::INT;
        while self.peek(0).is_some() && !self.sees("{") && !self.sees(";") {
            let numbers = if self.take(":") {
                self.read_type()
            } else {
                self.at += 1;
                None
            };
            kind = numbers.map_or(kind, |it| it.kind);
        }
        if !of.is_empty() {
            self.enumerations.insert(of.clone(), kind);
        }
        let mut all: Vec<Declared> = Vec::new();
        if self.take("{") {
            while !self.take("}") {
                let place = self.place();
                let name = self.name("the name of a constant")?;
                let name = match &space {
                    Some(space) => format!("{space}::{name}").into(),
                    None => name,
                };
                let whole = |value| Expr {
                    node: ExprNode::Whole(value),
                    place,
                };
                let value = if self.take("=") {
                    let mut value = self.assignment()?;
                    if let Some(space) = &space {
                        own_names(&mut value, space, &all);
                    }
                    value
                } else {
                    match all.last() {
                        None => whole(0),
                        Some(before) => {
                            let node = ExprNode::Name(before.name.clone());
                            let before = Box::new(Expr { node, place });
                            let node = ExprNode::Binary("+", before, Box::new(whole(1)));
                            Expr { node, place }
                        }
                    }
                };
                all.push(Declared {
                    name,
                    kind: Kind::INT,
                    of: of.clone(),
                    lengths: Vec::new(),
                    value: Some(value),
                    reference: false,
                    pointer: false,
                    library: false,
                    outside: false,
                    constant: true,
                    lasting: false,
                    place,
                });
                if !self.take(",") && !self.sees("}") {
                    let place = self.place();
                    return Err(unexpected(
                        self.peek(0),
                        place,
                        "`,` or `}`",
                        "write `enum { A, B };`",
                    ));
                }
            }
        }
        if named_behind && let Some(name) = self.peek(0).and_then(Token::name).cloned() {
            self.enumerations.insert(name.clone(), kind);
            let unnamed = all.iter_mut().filter(|it| it.of.is_empty());
            unnamed.for_each(|it| it.of = name.clone());
        }
        if named_behind {
            self.skip_past(";");
            return Ok((StmtNode::Declare(all), None));
        }
        let unnamed = of.is_empty();
        let variables = self.declared_behind(Type {
            kind: if unnamed { kind } else { Kind::Any },
            name: of,
            ..more
        })?;
        Ok((StmtNode::Declare(all), variables))
    }

    /// Whether the function that makes or ends an object of a class is defined here.
    pub(super) fn is_constructor(&mut self) -> bool {
        let start = self.at;
        while QUALIFIERS.contains(&self.word(0)) {
            self.at += 1;
        }
        let mut names = Vec::new();
        while !self.word(0).is_empty() {
            names.push(self.word(0));
            self.at += 1;
            if !self.take("::") {
                break;
            }
            if self.take("~") {
                names.push("~");
            }
        }
        let named = match &names[..] {
            [.., class, "~", name] | [.., class, name] => class == name,
            _ => false,
        };
        let found = named && self.sees("(") && {
            self.skip_group();
            self.take_word("noexcept");
            self.sees("{") || self.sees(":") || self.no_body()
        };
        self.at = start;
        found
    }

    /// Whether a class or an enumeration is defined here, with its members; words such as `static`
    /// may stand before it.
    pub(super) fn is_definition(&self) -> bool {
        let Some(mut at) = self.type_word() else {
            return false;
        };
        at += 1;
        if self.word(at - 1) == "enum" && matches!(self.word(at), "class" | "struct") {
            at += 1;
        }
        let (mut before, mut angles) = ("", 0_usize);
        while let Some(token) = self.peek(at) {
            let word = self.word(at);
            match word {
                _ if token.is("<") => angles += 1,
                _ if token.is(">") => angles = angles.saturating_sub(1),
                _ if angles > 0 => {}
                // `struct name variable {value}`
                _ if !word.is_empty() && self.classes.contains(before) => return word == "final",
                _ if !word.is_empty() || token.is("::") => before = word,
                _ => return token.is("{") || token.is(":"),
            }
            at += 1;
        }
        false
    }

    /// Whether a type is only announced here: `class name;`, `enum name : int;`
    pub(super) fn is_announced(&self) -> bool {
        let scoped = self.word(0) == "enum" && matches!(self.word(1), "class" | "struct");
        let behind = 2 + usize::from(scoped);
        match self.peek(behind) {
            _ if self.word(behind - 1).is_empty() => false,
            Some(t) if t.is(";") => true,
            Some(t) if t.is(":") => self.peek(behind + 2).is_some_and(|t| t.is(";")),
            _ => false,
        }
    }

    /// How many words stand before `class`, `struct`, `union` or `enum`, if one of them comes next.
    fn type_word(&self) -> Option<usize> {
        let mut words = (0..).map(|ahead| self.word(ahead));
        let at = words.position(|it| TYPES.contains(&it) || !QUALIFIERS.contains(&it))?;
        TYPES.contains(&self.word(at)).then_some(at)
    }

    /// A class or an enumeration, and variables of it that are declared with it:
    /// `static const struct { int n; } all[2] = {…};`
    pub(super) fn defined_type(&mut self) -> Parsed<StmtNode> {
        let mut of = Type::default();
        while !TYPES.contains(&self.word(0)) {
            of.qualify(self.word(0));
            self.at += 1;
        }
        if self.word(0) != "enum" {
            return self.class(false, of);
        }
        let place = self.place();
        match self.enumeration(false, of)? {
            (constants, None) => Ok(constants),
            (node, Some(variables)) => {
                self.pending.push(Stmt { node, place });
                Ok(variables)
            }
        }
    }

    /// Variables that are declared behind the braces of their type, if there are any.
    fn declared_behind(&mut self, mut of: Type) -> Parsed<Option<StmtNode>> {
        loop {
            if self.take("*") {
                of.pointer = true;
            } else if QUALIFIERS.contains(&self.word(0)) {
                of.qualify(self.word(0));
                self.at += 1;
            } else {
                break;
            }
        }
        // Behind what was not understood something else may stand in a line of its own.
        if self.word(0).is_empty() {
            self.skip_past(";");
            return Ok(None);
        }
        let all = self.declarators(&of)?;
        self.end_statement()?;
        Ok(Some(StmtNode::Declare(all)))
    }

    /// `typedef type name;`
    pub(super) fn typedef(&mut self) -> Parsed<StmtNode> {
        self.at += 1;
        if self.word(0) == "enum" && self.is_definition() {
            return Ok(self.enumeration(true, Type::default())?.0);
        }
        if self.is_definition() {
            return self.class(true, Type::default());
        }
        let start = self.at;
        if self.read_type().is_some()
            && let Some(name) = self.peek(0).and_then(Token::name).cloned()
        {
            self.at = start;
            self.alias(name);
        }
        self.skip_past(";");
        Ok(StmtNode::Nothing)
    }

    /// A type that stands here has this name from now on.
    pub(super) fn alias(&mut self, name: Word) {
        if let Some(mut it) = self.read_type() {
            // Of a `typedef` the name stands between the two.
            self.take_word(&name);
            if let Ok(lengths) = self.read_lengths() {
                it.lengths.splice(0..0, lengths);
            }
            self.aliases.insert(name, it);
        }
    }

    /// A class. Where its members are data and plain functions its objects are known, else they are
    /// taken for unknown. Objects that are declared with it are of a type that these words say more of.
    pub(super) fn class(&mut self, named_behind: bool, more: Type) -> Parsed<StmtNode> {
        let place = self.place();
        let union = self.word(0) == "union";
        self.at += 1;
        let mut name: Word = match self.peek(0).and_then(Token::name) {
            Some(name) => name.clone(),
            None => format!("the class of {}", place.start).into(),
        };
        let mut special = false;
        while self.peek(0).is_some() && !self.sees("{") && !self.sees(":") {
            special |= self.sees("<");
            self.at += 1;
        }
        let base = self.base_class();
        let unread = match (union, special, &base) {
            (true, ..) => Some("a union"),
            (_, true, _) => Some("a class template specialisation"),
            _ if !self.template.is_empty() => Some("a class template"),
            (.., Err(what)) => Some(*what),
            _ => None,
        };
        let plain = unread.is_none();
        let outer = std::mem::replace(&mut self.base, base.ok().flatten());
        while self.peek(0).is_some() && !self.sees("{") {
            self.at += 1;
        }
        // It is known inside of itself.
        let known = !plain || named_behind || !self.classes.insert(name.clone());
        let body = self.at;
        let Body {
            data,
            functions,
            refers,
            stops,
        } = self.class_body(&name, plain);
        if !known && data.is_none() {
            self.classes.remove(&name);
        }
        let base = std::mem::replace(&mut self.base, outer);
        let space = within(&self.space, &[&*name]).into();
        let shared = std::mem::take(&mut self.shared);
        self.pending.extend(shared);
        if named_behind && let Some(behind) = self.peek(0).and_then(Token::name) {
            name = behind.clone();
        }
        if data.is_some() {
            self.classes.insert(name.clone());
        }
        let bit_fields = self.has_bit_fields(body, self.at);
        let unread = unread.or_else(|| {
            let is_operator = |it: &Rc<Function>| &*it.name == "operator";
            let copies = |it: &Rc<Function>| it.name == name && copies(&name, &it.parameters);
            Some(if refers {
                REFERS
            } else if functions.iter().any(copies) {
                "a class with a copy constructor"
            } else if functions.iter().any(is_operator) {
                "a class with unsupported operators"
            } else if bit_fields {
                "a class with bit fields"
            } else {
                UNCLEAR
            })
        });
        let node = StmtNode::Struct(Rc::new(Struct {
            name: name.clone(),
            unread: unread.filter(|_| data.is_none()),
            stops: stops.filter(|_| unread == Some(UNCLEAR)),
            members: data.unwrap_or_default(),
            functions: functions.clone(),
            base,
            space,
            map: false,
        }));
        let place = place.to(self.before());
        let functions = Stmt {
            node: StmtNode::Class(functions),
            place,
        };
        if named_behind {
            self.skip_past(";");
            self.pending.push(functions);
            return Ok(node);
        }
        match self.declared_behind(Type { name, ..more })? {
            None => {
                self.pending.push(functions);
                Ok(node)
            }
            Some(objects) => {
                self.pending.extend([functions, Stmt { node, place }]);
                Ok(objects)
            }
        }
    }

    /// Whether a member of so many bits stands between two places: `name : 3;`.
    fn has_bit_fields(&self, from: usize, to: usize) -> bool {
        let tokens: Vec<&Token> = self.between(from, to).collect();
        tokens.windows(4).any(|it| {
            let is_first = |token: &Token| token.is(";") || token.is("{") || token.is(",");
            let (bits, ends) = (matches!(it[2].kind, TokenKind::Whole(..)), is_first(it[3]));
            it[0].name().is_some() && it[1].is(":") && bits && ends
        })
    }

    /// What stands between the braces of a class.
    fn class_body(&mut self, class: &str, plain: bool) -> Body {
        let (start, mut stops) = (self.at, None);
        self.skip_group();
        let end = std::mem::replace(&mut self.at, start + 1);
        let (mut data, mut functions) = (Vec::new(), Vec::new());
        let (mut plain, around) = (plain, self.aliases.clone());
        while plain && self.at + 1 < end {
            let (bound, place) = (self.bound(), self.place());
            let member = match self.constructor(class) {
                None => self.plain_member(class),
                Some(read) => read.ok(),
            };
            match member {
                Some(StmtNode::Declare(more)) => data.extend(more),
                Some(StmtNode::Function(mut function)) => {
                    Rc::make_mut(&mut function).bound = bound;
                    functions.push(function);
                }
                Some(StmtNode::Prototype(mut function)) => {
                    let place = function.place;
                    let node = StmtNode::Prototype(Rc::clone(&function));
                    self.shared.push(Stmt { node, place });
                    Rc::make_mut(&mut function).bound = match bound {
                        Bound::Own => Bound::Announced,
                        _ => Bound::Pure,
                    };
                    functions.push(function);
                }
                Some(_) => {}
                None => (plain, stops) = (false, Some(place)),
            }
        }
        while self.at + 1 < end {
            if !self.word(0).is_empty()
                && let Some(member) = self.member(class)
            {
                functions.push(member);
            } else {
                self.at += 1;
            }
        }
        self.at = end;
        self.own_types(class, around);
        // Arrays of objects with constructors are made in more steps than are followed.
        let empty = |it: &Declared| it.library && matches!(it.lengths[..], [None]);
        let whole = |it: &Declared| {
            let single = it.lengths.is_empty() || empty(it);
            !it.reference && (it.pointer || single || !self.constructs(&it.of))
        };
        let refers = data.iter().any(|it| it.reference);
        let mut plain = plain && data.iter().all(whole);
        if plain {
            functions.extend(self.inherited(class, &functions));
            plain = self.begin(class, &mut data, &mut functions);
        }
        let constructors = |it: &&mut Rc<Function>| *it.name == *class && !it.hidden;
        for constructor in functions.iter_mut().filter(constructors) {
            Rc::make_mut(constructor).hidden = !plain;
            if plain {
                self.constructed.insert(class.into());
            }
        }
        Body {
            data: plain.then_some(data),
            functions,
            refers,
            stops,
        }
    }

    /// Whether what is declared here belongs to the class, not to its objects: `inline static int n;`.
    fn is_shared(&self) -> bool {
        let words = (0..).map(|ahead| self.word(ahead));
        words
            .take_while(|it| QUALIFIERS.contains(it))
            .any(|it| it == "static")
    }

    /// `typedef type name;` or `using name = type;` in a class; nothing where it defines a class, or
    /// is of a base.
    fn own_type(&mut self) -> Option<StmtNode> {
        if self.word(0) == "typedef" {
            self.at += 1;
            let defines = self.is_definition();
            self.at -= 1;
            return if defines { None } else { self.typedef().ok() };
        }
        let name = self.peek(1).and_then(Token::name).cloned();
        let name = name.filter(|_| self.peek(2).is_some_and(|t| t.is("=")))?;
        self.at += 3;
        self.alias(name);
        self.skip_past(";");
        Some(StmtNode::Nothing)
    }

    /// The names that a class has for types are its own: outside they are known behind its name.
    fn own_types(&mut self, class: &str, around: BTreeMap<Word, Type>) {
        let inside = std::mem::replace(&mut self.aliases, around);
        for (name, it) in inside {
            let full: Word = format!("{class}::{name}").into();
            if qualifier(&name).is_some() {
                self.aliases.insert(name, it);
            } else if self.aliases.get(&name) != Some(&it) {
                self.aliases.insert(full, it);
            }
        }
    }

    /// Reads what stands behind a class and belongs to it, which knows its names for types.
    pub(super) fn of_class<T>(&mut self, class: &str, read: impl FnOnce(&mut Self) -> T) -> T {
        let own = |it: &(&Word, &Type)| qualifier(it.0) == Some(class);
        let own: Vec<(Word, Type)> = { self.aliases.iter() }
            .filter(own)
            .map(|(name, it)| (last(name).into(), it.clone()))
            .collect();
        if class.is_empty() || own.is_empty() {
            return read(self);
        }
        let around = self.aliases.clone();
        self.aliases.extend(own);
        let made = read(self);
        self.aliases = around;
        made
    }

    fn is_friend(&self) -> bool {
        let words = (0..).map(|ahead| self.word(ahead));
        let mut before = words.take_while(|it| QUALIFIERS.contains(it));
        before.any(|it| it == "friend")
    }

    /// What a class makes its friend: a function with a body here is one of the namespace.
    fn befriended(&mut self) -> Option<StmtNode> {
        let (start, place, told) = (self.at, self.place(), self.faults.len());
        let node = self.declaration();
        let clean = self.faults.len() == told;
        self.faults.truncate(told);
        if let Ok(Some(node @ StmtNode::Function(_))) = node {
            self.shared.push(Stmt { node, place });
            return clean.then_some(StmtNode::Nothing);
        }
        // `friend class Name;`, or a function that stands elsewhere.
        self.at = start;
        let rest = self.tokens.get(start..).unwrap_or_default();
        let named = rest.iter().find(|t| t.is("{") || t.is(";"))?.is(";");
        self.skip_past(";");
        named.then_some(StmtNode::Nothing)
    }

    /// A class inside of another, and the data that is declared with it.
    fn inner_class(&mut self, named: bool) -> Option<StmtNode> {
        let (place, told) = (self.place(), self.faults.len());
        let shared = std::mem::take(&mut self.shared);
        let node = self.class(false, Type::default());
        self.shared = shared;
        let clean = self.faults.len() == told;
        self.faults.truncate(told);
        match node.ok().filter(|_| clean)? {
            node @ StmtNode::Declare(_) => Some(node),
            node if named => {
                self.pending.push(Stmt { node, place });
                Some(StmtNode::Nothing)
            }
            // Its members are those of the class around it.
            _ => None,
        }
    }

    /// A member of a class that is data or a plain function; nothing where it is more than that.
    fn plain_member(&mut self, class: &str) -> Option<StmtNode> {
        if matches!(self.word(0), "public" | "private" | "protected") {
            self.at += 2;
            return Some(StmtNode::Nothing);
        }
        if self.take(";") {
            return Some(StmtNode::Nothing);
        }
        let space: Word = within(&self.space, &[class]).into();
        if self.word(0) == "enum" && self.is_definition() {
            let place = self.place();
            let outer = self.inside.replace(space);
            let read = self.enumeration(false, Type::default());
            self.inside = outer;
            let (node, data) = read.ok()?;
            self.shared.push(Stmt { node, place });
            return Some(data.unwrap_or(StmtNode::Nothing));
        }
        if self.is_friend() {
            return self.befriended();
        }
        if matches!(self.word(0), "typedef" | "using") {
            return self.own_type();
        }
        if matches!(self.word(0), "struct" | "class") {
            let named = !self.word(1).is_empty();
            if self.peek(1 + usize::from(named)).is_some_and(|t| t.is("{")) {
                return self.inner_class(named);
            }
        }
        let mut words = (0..).map(|ahead| self.word(ahead));
        // It says what its objects become.
        if words.find(|it| !QUALIFIERS.contains(it)) == Some("operator") {
            return None;
        }
        let (told, shared) = (self.faults.len(), self.is_shared());
        self.in_class = true;
        let place = self.place();
        let node = self.declaration();
        self.in_class = false;
        let clean = self.faults.len() == told;
        self.faults.truncate(told);
        if shared {
            // A function of the class, or what its objects share.
            let mut all = match node {
                Ok(Some(StmtNode::Declare(all))) => all,
                Ok(Some(StmtNode::Function(mut function))) if clean => {
                    // It knows the constants of its class.
                    Rc::make_mut(&mut function).space = space;
                    // By the name of the class, or of an object.
                    let node = StmtNode::Function(Rc::clone(&function));
                    let node = StmtNode::Namespace(class.into(), vec![Stmt { node, place }]);
                    self.shared.push(Stmt { node, place });
                    return Some(StmtNode::Function(function));
                }
                Ok(Some(StmtNode::Prototype(mut function))) if clean => {
                    Rc::make_mut(&mut function).space = space;
                    return Some(StmtNode::Prototype(function));
                }
                _ => return None,
            };
            if !clean {
                return None;
            }
            for it in &mut all {
                it.name = format!("{class}::{}", it.name).into();
                it.lasting = false;
            }
            let node = StmtNode::Declare(all);
            self.shared.push(Stmt { node, place });
            return Some(StmtNode::Nothing);
        }
        match node {
            Ok(Some(StmtNode::Function(mut function))) if clean => {
                Rc::make_mut(&mut function).space = space;
                Some(StmtNode::Function(function))
            }
            Ok(Some(StmtNode::Prototype(mut function))) if clean => {
                Rc::make_mut(&mut function).space = space;
                Some(StmtNode::Prototype(function))
            }
            Ok(Some(node @ StmtNode::Declare(_))) if clean => Some(node),
            _ => None,
        }
    }

    /// A function of a class, if the place is at its name and it has a body. Classes are not run:
    /// what does not parse in the body is no fault as long as nobody calls it.
    pub(super) fn member(&mut self, class: &str) -> Option<Rc<Function>> {
        let (start, place) = (self.at, self.place());
        let name = self.peek(0)?.name()?.clone();
        let ends = start > 0 && self.tokens[start - 1].is("~");
        self.at += 1;
        if &*name == "operator" {
            while self.peek(0).is_some_and(|t| !t.is("(") && !t.is(";")) {
                self.at += 1;
            }
        }
        let called = self.sees("(") && !RESERVED.contains(&&*name);
        let parameters = self.taken();
        while self.sees("(") {
            self.skip_group();
        }
        self.skip_to_body();
        if !called || !self.sees("{") {
            self.at = start;
            return None;
        }
        let body = self.member_body(&name);
        let hidden = *name == *class || &*name == "operator";
        let name = if ends { ended(&name) } else { name };
        Some(Rc::new(Function {
            body: body.into(),
            parameters: parameters.into(),
            hidden,
            ..Function::new(name, place)
        }))
    }

    /// The parameters that stand here, as far as they are understood; no step ahead.
    fn taken(&mut self) -> Vec<Parameter> {
        let (start, told) = (self.at, self.faults.len());
        let found = if self.take("(") {
            self.parameters()
        } else {
            Ok(Vec::new())
        };
        self.faults.truncate(told);
        self.at = start;
        found.unwrap_or_default()
    }

    /// A body in braces; one that does not parse calls something unknown.
    pub(super) fn member_body(&mut self, name: &Word) -> Vec<Stmt> {
        let (start, place, faults) = (self.at, self.place(), self.faults.len());
        self.skip_group();
        let end = std::mem::replace(&mut self.at, start);
        let body = self.body(name).unwrap_or_default();
        let understood = self.faults.len() == faults && self.at == end;
        self.faults.truncate(faults);
        self.at = end;
        if understood {
            return body;
        }
        let callee = ExprNode::Name(format!("{UNREAD}{name}").into());
        let callee = Expr {
            node: callee,
            place,
        };
        let node = ExprNode::Call(Box::new(callee), Vec::new());
        vec![Stmt {
            node: StmtNode::Expr(Expr { node, place }),
            place,
        }]
    }

    /// From behind the parameters of a function of a class to its body, if it has one: over
    /// `const`, `-> type`, and what a constructor sets.
    fn skip_to_body(&mut self) {
        if self.take(":") {
            while self.peek(0).is_some() && !self.sees("{") && !self.sees(";") {
                while !self.word(0).is_empty() || self.sees("::") {
                    self.at += 1;
                    self.angles();
                }
                self.skip_group();
                if !self.take(",") {
                    return;
                }
            }
            return;
        }
        while !self.word(0).is_empty()
            || ["->", "::", "*", "&", "<", ">"]
                .iter()
                .any(|punctuator| self.sees(punctuator))
        {
            self.at += 1;
        }
        if self.sees(":") {
            self.skip_to_body();
        }
    }
}

/// Names of an enumeration's constants in the value of a later one, as they are known outside.
fn own_names(it: &mut Expr, space: &str, all: &[Declared]) {
    match &mut it.node {
        ExprNode::Name(name) => {
            let full: Word = format!("{space}::{name}").into();
            if all.iter().any(|it| it.name == full) {
                *name = full;
            }
        }
        ExprNode::Unary(_, of) | ExprNode::Convert(_, of) => own_names(of, space, all),
        ExprNode::Binary(_, a, b) => {
            own_names(a, space, all);
            own_names(b, space, all);
        }
        ExprNode::Choose(a, b, c) => {
            for it in [a, b, c] {
                own_names(it, space, all);
            }
        }
        _ => {}
    }
}

/// The name of the destructor of a class.
pub(in crate::program::vendor) fn ended(class: &str) -> Word {
    format!("~{class}").into()
}

/// What a class is of which a member says more than is read.
const UNCLEAR: &str = "a class with unreadable members";

/// What a class is whose objects change what they were made of.
pub(in crate::program::vendor) const REFERS: &str = "a class with a reference as a member";

/// What the name begins with of what a function of a class calls whose body is not understood.
pub(in crate::program::vendor) const UNREAD: &str = "the body of ";
