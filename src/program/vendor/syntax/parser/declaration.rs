//! Variables, arrays and pointers.

use std::rc::Rc;

use super::{
    Parsed, Parser,
    expression::{arguments, template_arguments},
    types::{QUALIFIERS, RESERVED, Type},
};
use crate::{
    config::Fault,
    program::vendor::{
        host::Random,
        lexer::token::Token,
        syntax::tree::{Declared, Expr, ExprNode, FILLED, Kind, OF_OTHERS, StmtNode, Word, last},
    },
};

/// How members get names.
const BINDING: &str = "a structured binding is `auto [a, b] = value;`";

impl Parser<'_> {
    /// A declaration, if one stands here.
    pub(super) fn declaration(&mut self) -> Parsed<Option<StmtNode>> {
        let start = self.at;
        let ahead = (0..3).find(|at| !QUALIFIERS.contains(&self.word(*at)));
        if ahead.is_some_and(|at| self.word(at) == "decltype") {
            let message = "`decltype` is not supported";
            let help = "write the type itself, or `auto`";
            return Err(Fault::error(self.place(), message, "this type").help(help));
        }
        if let Some(node) = self.function_pointer()? {
            return Ok(Some(node));
        }
        if let Some(node) = self.binding()? {
            return Ok(Some(node));
        }
        let Some(first) = self.declared_type() else {
            return Ok(None);
        };
        let (mut name_at, mut name_place) = (self.at, self.place());
        let mut name = self.name("the name of what is declared")?;
        if !self.operator(&mut name) {
            self.at = start;
            return Ok(None);
        }
        // A function of a class.
        let mut qualified = Vec::new();
        while self.sees("::") && !self.word(1).is_empty() {
            qualified.push(self.word_before());
            self.at += 1;
            (name_at, name_place) = (self.at, self.place());
            name = self.name("a name")?;
            if !self.operator(&mut name) {
                self.at = start;
                return Ok(None);
            }
        }
        let special = if self.special && self.sees("<") {
            Some(template_arguments(self)?)
        } else {
            None
        };
        let next = self.peek(0);
        let fits = next.is_none_or(|t| {
            t.first
                || ["=", ";", ",", "[", "(", "{", ":"]
                    .iter()
                    .any(|punctuator| t.is(punctuator))
        });
        // Two names side by side that are no declaration: something is missing between them.
        let strange = first.kind == Kind::Any && !self.is_known(&first.name);
        let unknown = strange && start + 2 == self.at;
        let ends = next.is_none_or(|t| t.first && !["{", "=", "("].iter().any(|it| t.is(it)));
        if !fits || unknown && ends {
            self.at = start;
            return Ok(None);
        }
        if self.sees("(") {
            // A word, and a statement in the next line.
            let apart = unknown && self.tokens[name_at].first;
            let class = qualified.last().copied().unwrap_or_default();
            let read = |it: &mut Self| it.function(&name, name_place, &first, &qualified);
            if let Some(node) = self.of_class(class, read)? {
                return Ok(Some(match node {
                    StmtNode::Prototype(_) if apart => {
                        self.at = start;
                        return Ok(None);
                    }
                    StmtNode::Function(mut function) if self.special => {
                        let special = special.unwrap_or_default().into();
                        Rc::make_mut(&mut function).special = Some(special);
                        StmtNode::Function(function)
                    }
                    node => node,
                }));
            }
            if apart {
                self.at = start;
                return Ok(None);
            }
        }
        self.at = name_at;
        let mut all = self.declarators(&first)?;
        self.end_statement()?;
        if !qualified.is_empty() {
            // What the objects of a class share, or a variable of a namespace.
            let name = &all[0].name;
            all[0].name = format!("{}::{name}", qualified.join("::")).into();
        }
        Ok(Some(StmtNode::Declare(all)))
    }

    /// Whether a type that is no number's is known so far.
    fn is_known(&self, name: &Word) -> bool {
        matches!(&**name, "void" | "auto" | "string")
            || self.classes.contains(name)
            || self.enumerations.contains_key(name)
    }

    /// Makes the name of an operator whole; false where that is not supported.
    fn operator(&mut self, name: &mut Word) -> bool {
        if &**name != "operator" {
            return true;
        }
        let full = self.operator_name();
        if let Some(full) = &full {
            *name = full.clone();
        }
        full.is_some()
    }

    /// `auto [a, b] = value;`, if that stands here: names of the members of a value.
    fn binding(&mut self) -> Parsed<Option<StmtNode>> {
        let Some((mut whole, members)) = self.bound_names()? else {
            return Ok(None);
        };
        self.expect("=", BINDING)?;
        whole.value = Some(self.assignment()?);
        self.end_statement()?;
        let mut all = vec![whole];
        all.extend(members);
        Ok(Some(StmtNode::Declare(all)))
    }

    /// `auto [a, b]`, if that stands here: what has no name of its own, and its members.
    pub(super) fn bound_names(&mut self) -> Parsed<Option<(Declared, Vec<Declared>)>> {
        let (start, place) = (self.at, self.place());
        while self.word(0) == "const" {
            self.at += 1;
        }
        let auto = self.word(0) == "auto";
        self.at += usize::from(auto);
        let reference = auto && (self.take("&") || self.take("&&"));
        if !(auto && self.sees("[")) {
            self.at = start;
            return Ok(None);
        }
        self.at += 1;
        let mut names = Vec::new();
        loop {
            let place = self.place();
            names.push((self.name("the name of a member")?, place));
            if !self.take(",") {
                break;
            }
        }
        self.expect("]", BINDING)?;
        let of = Type {
            reference,
            ..Type::default()
        };
        let whole: Word = format!("[{}]", names[0].0).into();
        let member = Type {
            reference: true,
            ..Type::default()
        };
        let members = names.into_iter().enumerate().map(|(at, (name, place))| {
            let node = ExprNode::Name(whole.clone());
            let node = ExprNode::Member(Box::new(Expr { node, place }), at.to_string().into());
            let mut it = member.declares(name, place);
            it.value = Some(Expr { node, place });
            it
        });
        let members = members.collect();
        Ok(Some((of.declares(whole, place), members)))
    }

    /// The variables of a declaration, behind its type.
    pub(super) fn declarators(&mut self, first: &Type) -> Parsed<Vec<Declared>> {
        let mut all = Vec::new();
        let mut of = first.clone();
        loop {
            let place = self.place();
            let name = self.name("the name of what is declared")?;
            let lengths = self.read_lengths()?;
            let mut declared = of.declares(name, place);
            declared.lengths.splice(0..0, lengths);
            let makes = self.makes(&declared);
            if self.take("=") || self.sees("{") {
                let value = self.assignment()?;
                declared.value = Some(match value.node {
                    ExprNode::Braces(given) if makes => {
                        Expr::made(&declared.of, given, value.place)
                    }
                    node @ ExprNode::Designated(_) if makes => {
                        let place = value.place;
                        Expr::made(&declared.of, vec![Expr { node, place }], place)
                    }
                    node => Expr { node, ..value },
                });
            } else if self.sees("(") {
                self.constructed(&mut declared)?;
            } else if makes {
                declared.value = Some(Expr::made(&declared.of, Vec::new(), place));
            }
            declared.place = place.to(self.before());
            if !declared.constant {
                self.variables.insert(declared.name.clone());
            }
            all.push(declared);
            if !self.take(",") {
                return Ok(all);
            }
            // A `*` belongs to its own name.
            (of.pointer, of.reference) = (false, false);
            loop {
                if self.take("*") {
                    of.pointer = true;
                } else if self.take("&") {
                    of.reference = true;
                } else {
                    break;
                }
            }
        }
    }

    /// Whether it is one object, made by a call: one that draws random numbers, or of a class with
    /// constructors.
    pub(in crate::program::vendor) fn makes(&self, it: &Declared) -> bool {
        let plain = it.lengths.is_empty() && !it.pointer && !it.reference && !it.outside;
        plain && (Random::named(last(&it.of)).is_some() || self.constructs(&it.of))
    }

    /// `(*)[…])`, the rest of the type of a pointer to an array, if that stands here.
    pub(in crate::program::vendor) fn array_pointer(&mut self) -> bool {
        let start = self.at;
        if self.take("(") && self.take("*") && self.take(")") && self.sees("[") {
            while self.sees("[") {
                self.skip_group();
            }
            if self.take(")") {
                return true;
            }
        }
        self.at = start;
        false
    }

    /// The name in `(*name)(…)`, behind the type that the function gives back: a pointer to a
    /// function, or an array of them. In `(*name)[…]` it is one to an array, in `(&name)[…]` another
    /// name of one.
    pub(super) fn pointer_name(&mut self) -> Option<(Word, Pointed)> {
        let start = self.at;
        let open = self.take("(");
        let reference = open && self.take("&");
        let open = reference || open && self.take("*");
        let name = if reference && self.sees(")") {
            Some("".into())
        } else {
            let found = self.peek(0).and_then(Token::name).cloned();
            self.at += 1;
            found
        };
        let array = self.sees("[");
        if array {
            self.skip_group();
        }
        let closed = open && self.take(")");
        let pointed = if closed && reference {
            (!array && self.sees("[")).then_some(Pointed::Reference)
        } else if closed && self.sees("(") {
            self.skip_group();
            if array {
                Some(Pointed::Functions)
            } else {
                Some(Pointed::Function)
            }
        } else if closed && !array && self.sees("[") {
            while self.sees("[") {
                self.skip_group();
            }
            let ends = ["=", ",", ")", ";"]
                .iter()
                .any(|punctuator| self.sees(punctuator));
            ends.then_some(Pointed::Array)
        } else {
            None
        };
        if pointed.is_none() {
            self.at = start;
        }
        name.zip(pointed)
    }

    /// The lengths of an array, in brackets behind its name.
    pub(super) fn read_lengths(&mut self) -> Parsed<Vec<Option<Expr>>> {
        let mut lengths = Vec::new();
        while self.take("[") {
            let length = if self.sees("]") {
                None
            } else {
                Some(self.expression()?)
            };
            self.expect("]", "an array is `type name[length];`")?;
            lengths.push(length);
        }
        Ok(lengths)
    }

    /// Over the lengths of an array.
    fn skip_lengths(&mut self) {
        while self.sees("[") {
            self.skip_group();
        }
    }

    /// `type (*name)(types) = function;` or `type (*name)[length] = &array;`, if that stands here.
    fn function_pointer(&mut self) -> Parsed<Option<StmtNode>> {
        let (start, place) = (self.at, self.place());
        let typed = !RESERVED.contains(&self.word(0)) && self.read_type().is_some();
        let Some((name, pointed)) = typed.then(|| self.pointer_name()).flatten() else {
            self.at = start;
            return Ok(None);
        };
        if pointed == Pointed::Reference {
            self.skip_lengths();
        }
        let mut value = if self.take("=") {
            Some(self.assignment()?)
        } else {
            None
        };
        // Of a pointer to a whole array, `&array`, `*name` is the array: the first of these.
        let whole = |it: &Expr| match &it.node {
            ExprNode::Unary("&", of) => matches!(of.node, ExprNode::Name(_)),
            node => matches!(node, ExprNode::Convert(..)),
        };
        let whole = pointed == Pointed::Array && value.as_ref().is_some_and(whole);
        if whole {
            value = value.map(|it| Expr {
                place: it.place,
                node: ExprNode::Braces(vec![it]),
            });
        }
        let declared = Declared {
            name,
            kind: Kind::Any,
            of: "".into(),
            lengths: if whole || pointed == Pointed::Functions {
                vec![None]
            } else {
                Vec::new()
            },
            value,
            reference: pointed == Pointed::Reference,
            pointer: pointed != Pointed::Reference,
            outside: false,
            library: false,
            constant: false,
            lasting: false,
            place: place.to(self.before()),
        };
        self.end_statement()?;
        Ok(Some(StmtNode::Declare(vec![declared])))
    }

    /// `name(value)`: a value for numbers, something of its own for objects.
    fn constructed(&mut self, it: &mut Declared) -> Parsed<()> {
        let place = self.place();
        let mut given = arguments(self, "write `type name(value);`")?;
        let number =
            it.kind != Kind::Any || matches!(&*it.of, "scamp5_kernel" | "auto" | "AREG" | "DREG");
        it.value = match (it.library, given.len()) {
            (true, 1) => {
                it.lengths = vec![given.pop()];
                None
            }
            (true, 2) => Some(Expr::made(FILLED, given, place)),
            (_, length) if length != 1 && last(&it.of) == "string" && !it.pointer => {
                Some(Expr::made("std::string", given, place))
            }
            _ if number || it.pointer || last(&it.of) == "string" => given.into_iter().next(),
            _ if self.makes(it) || self.classes.contains(&it.of) => {
                Some(Expr::made(&it.of, given, place))
            }
            _ if self.enumeration_kind(&it.of).is_some() => given.into_iter().next(),
            // Of the language's library, or of what is defined elsewhere.
            _ => Some(Expr::made(OF_OTHERS, given, place)),
        };
        Ok(())
    }
}

/// What a pointer in parentheses leads to.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Pointed {
    Function,
    /// There is an array of such pointers.
    Functions,
    Array,
    /// It is another name of an array.
    Reference,
}
