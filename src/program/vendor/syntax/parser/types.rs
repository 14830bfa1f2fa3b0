//! Types, as far as they matter.

use super::{Parser, expression};
use crate::{
    config::Place,
    program::vendor::{
        lexer::token::Token,
        syntax::tree::{Declared, Expr, ExprNode, Kind, Word},
    },
};

/// Words of a type that say nothing about its value.
pub(super) const QUALIFIERS: [&str; 17] = [
    "const",
    "static",
    "volatile",
    "inline",
    "constexpr",
    "extern",
    "register",
    "mutable",
    "struct",
    "class",
    "union",
    "enum",
    "typename",
    "virtual",
    "explicit",
    "friend",
    "thread_local",
];

/// Words that begin no declaration.
pub(super) const RESERVED: [&str; 14] = [
    "if", "for", "while", "do", "switch", "case", "default", "break", "continue", "return", "else",
    "goto", "new", "delete",
];

/// A type, as far as it matters.
#[allow(clippy::struct_excessive_bools)] // What was said, each on its own.
#[derive(Clone, PartialEq)]
pub(in crate::program::vendor) struct Type {
    pub kind: Kind,
    pub(super) constant: bool,
    pub(super) lasting: bool,
    pub(super) outside: bool,
    pub pointer: bool,
    pub(super) reference: bool,
    /// Whether it is an array of the language's library, and its lengths.
    pub(super) library: bool,
    pub(super) lengths: Vec<Option<Expr>>,
    pub(super) name: Word,
}

impl Default for Type {
    fn default() -> Self {
        Self {
            kind: Kind::Any,
            constant: false,
            lasting: false,
            outside: false,
            pointer: false,
            reference: false,
            library: false,
            lengths: Vec::new(),
            name: "".into(),
        }
    }
}

impl Type {
    /// Says more of it: a word such as `static`.
    pub(super) fn qualify(&mut self, word: &str) {
        self.constant |= matches!(word, "const" | "constexpr");
        self.lasting |= word == "static";
        self.outside |= word == "extern";
    }

    /// A variable of this type, without a value.
    pub(in crate::program::vendor) fn declares(&self, name: Word, place: Place) -> Declared {
        Declared {
            name,
            kind: if self.pointer { Kind::Any } else { self.kind },
            of: self.name.clone(),
            lengths: self.lengths.clone(),
            value: None,
            reference: self.reference,
            pointer: self.pointer,
            library: self.library && !self.pointer,
            outside: self.outside,
            constant: self.constant,
            lasting: self.lasting,
            place,
        }
    }

    /// A value that is converted to it.
    pub(in crate::program::vendor) fn converts(&self, value: Box<Expr>) -> ExprNode {
        match self.kind {
            Kind::Any | Kind::Analog | Kind::Digital => ExprNode::Convert(self.value_kind(), value),
            kind if self.pointer => ExprNode::Recast(kind, value),
            _ => ExprNode::Convert(self.value_kind(), value),
        }
    }

    /// The classes of a value of this type, and of its elements.
    pub(in crate::program::vendor) fn classes(&self) -> (Word, Word) {
        let none = || "".into();
        match (self.pointer || self.reference, self.library) {
            (true, _) => (none(), none()),
            (false, true) => (none(), self.name.clone()),
            (false, false) => (self.name.clone(), none()),
        }
    }

    /// The class of what it is, or of what it leads to.
    pub(in crate::program::vendor) fn class(&self) -> Word {
        self.name.clone()
    }

    /// Whether a function of this type gives back a variable itself.
    pub(in crate::program::vendor) const fn refers(&self) -> bool {
        self.reference && !self.pointer
    }

    /// What a number of this type becomes.
    pub(in crate::program::vendor) fn value_kind(&self) -> Kind {
        if self.pointer || self.library {
            Kind::Any
        } else {
            self.kind
        }
    }
}

impl Parser<'_> {
    /// What a number of the type of this name becomes.
    pub(in crate::program::vendor) fn kind_named(&self, name: &str) -> Kind {
        let at = self
            .template
            .iter()
            .position(|it| &*it.name == name && it.is_type);
        if let Some(at) = at {
            return Kind::Parameter(at);
        }
        self.aliases
            .get(name)
            .map_or_else(|| kind_of(name), Type::value_kind)
    }

    /// The type of the numbers of an enumeration, by its name or another.
    pub(in crate::program::vendor) fn enumeration_kind(&self, name: &str) -> Option<Kind> {
        let alias = self.aliases.get(name);
        let alias = alias.filter(|it| !it.pointer && !it.library && it.lengths.is_empty());
        let name = alias.map_or(name, |it| &it.name);
        self.enumerations.get(name).copied()
    }

    /// The enumeration that a name is another name of.
    pub(in crate::program::vendor) fn enumeration_named(&self, name: &str) -> Option<Word> {
        let alias = self.aliases.get(name)?;
        { self.enumerations.contains_key(&alias.name) }.then(|| alias.name.clone())
    }

    /// A value that is converted to a type: of an enumeration, to the type of its numbers.
    pub(in crate::program::vendor) fn converted(&self, of: &Type, value: Box<Expr>) -> ExprNode {
        let place = value.place;
        match self.enumeration_kind(&of.name) {
            Some(kind) if !of.pointer && !of.library && of.kind == Kind::Any => {
                let node = ExprNode::Convert(kind, value);
                // Outside it is no plain number.
                ExprNode::Convert(Kind::Any, Box::new(Expr { node, place }))
            }
            _ => of.converts(value),
        }
    }

    /// A type with a name behind it, if that stands here; the place is then at the name.
    pub(super) fn declared_type(&mut self) -> Option<Type> {
        let start = self.at;
        let found = self.read_type().filter(|_| {
            let name = self.word(0);
            !name.is_empty() && !RESERVED.contains(&name)
        });
        if found.is_none() {
            self.at = start;
        }
        found
    }

    /// The type that something is converted to, if one stands here.
    pub(in crate::program::vendor) fn read_cast(&mut self) -> Option<Type> {
        let start = self.at;
        let found = self.read_type();
        if found.is_none() {
            self.at = start;
        }
        found
    }

    pub(in crate::program::vendor) fn read_type(&mut self) -> Option<Type> {
        let mut it = Type::default();
        let (mut unsigned, mut named) = (None, false);
        loop {
            let word = self.word(0);
            if QUALIFIERS.contains(&word) {
                it.qualify(word);
                self.at += 1;
                continue;
            }
            if matches!(word, "unsigned" | "signed") {
                unsigned = Some(word == "unsigned");
                if !named {
                    it.kind = Kind::INT;
                }
                named = true;
                self.at += 1;
                continue;
            }
            let length = matches!(it.kind, Kind::Bits(..));
            if matches!(word, "int" | "long" | "short" | "char" | "double") && (!named || length) {
                it.kind = match (word, it.kind) {
                    ("double", _) => Kind::Real,
                    ("short", _) => Kind::Bits(16, true),
                    ("char", _) => Kind::Bits(8, true),
                    ("long", _) => Kind::Bits(64, true),
                    (_, Kind::Bits(bits, _)) => Kind::Bits(bits, true),
                    _ => Kind::INT,
                };
                named = true;
                self.at += 1;
                continue;
            }
            if named || word.is_empty() || RESERVED.contains(&word) {
                break;
            }
            named = true;
            self.type_name(&mut it);
            while self.sees("::") && !self.word(1).is_empty() {
                let class = it.name.clone();
                self.at += 1;
                let full = format!("{class}::{}", self.word(0));
                if self.aliases.contains_key(&*full) {
                    self.at += 1;
                    self.take_alias(&full, &mut it);
                } else {
                    self.type_name(&mut it);
                }
            }
        }
        if let (Some(true), Kind::Bits(bits, _)) = (unsigned, it.kind) {
            it.kind = Kind::Bits(bits, false);
        }
        loop {
            if self.take("*") {
                it.pointer = true;
            } else if self.take("&") || self.take("&&") {
                it.reference = true;
            } else if QUALIFIERS.contains(&self.word(0)) {
                it.constant |= self.word(0) == "const";
                self.at += 1;
            } else {
                break;
            }
        }
        named.then_some(it)
    }

    /// A type by another name of it, with what was said before.
    fn take_alias(&self, name: &str, it: &mut Type) -> bool {
        let Some(alias) = self.aliases.get(name) else {
            return false;
        };
        let (constant, lasting) = (it.constant, it.lasting);
        *it = alias.clone();
        it.constant |= constant;
        it.lasting |= lasting;
        true
    }

    /// The name of a type, with what stands in `<…>` behind it.
    fn type_name(&mut self, it: &mut Type) {
        let Some(name) = self.peek(0).and_then(Token::name).cloned() else {
            return;
        };
        self.at += 1;
        if !self.sees("<") && self.take_alias(&name, it) {
            return;
        }
        it.kind = self.kind_named(&name);
        if let Some(full) = self.container(&name) {
            it.name = full;
            return;
        }
        if matches!(&*name, "array" | "vector" | "deque") && self.sees("<") {
            let start = self.at;
            if let Some((kind, of, lengths)) = self.elements(&name) {
                (it.kind, it.name, it.lengths, it.library) = (kind, of, lengths, true);
                return;
            }
            (self.at, self.half) = (start, false);
        }
        it.name = name;
        self.angles();
    }

    /// The elements of `array<type, length>` or `vector<type>`.
    pub(in crate::program::vendor) fn elements(
        &mut self,
        of: &str,
    ) -> Option<(Kind, Word, Vec<Option<Expr>>)> {
        self.at += 1;
        let inner = self.deeper(|it| Ok(it.read_type())).ok()??;
        let mut lengths = vec![None];
        if of == "array" {
            if !self.take(",") {
                return None;
            }
            lengths[0] = Some(self.deeper(expression::sum).ok()?);
        }
        lengths.extend(inner.lengths.iter().cloned());
        let kind = if inner.pointer { Kind::Any } else { inner.kind };
        let of = if inner.pointer { "".into() } else { inner.name };
        self.close_angle().then_some((kind, of, lengths))
    }
}

/// What a number of this type becomes.
pub(in crate::program::vendor) fn kind_of(name: &str) -> Kind {
    match name {
        "bool" => Kind::Flag,
        "float" => Kind::Float,
        "double" => Kind::Real,
        "int8_t" | "char" => Kind::Bits(8, true),
        "uint8_t" => Kind::Bits(8, false),
        "int16_t" | "short" => Kind::Bits(16, true),
        "uint16_t" => Kind::Bits(16, false),
        "int" | "int32_t" | "signed" => Kind::INT,
        "uint32_t" | "unsigned" => Kind::Bits(32, false),
        "long" | "int64_t" | "ptrdiff_t" => Kind::Bits(64, true),
        "size_t" | "uint64_t" => Kind::Bits(64, false),
        "areg_t" | "AREG" | "ASRC" | "SCAMP5_MACRO_T_AREG" => Kind::Analog,
        "dreg_t" | "DREG" | "DSRC" | "SCAMP5_MACRO_T_DREG" => Kind::Digital,
        _ => Kind::Any,
    }
}
