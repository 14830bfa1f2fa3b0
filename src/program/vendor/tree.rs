//! A text of vendor C++ as a tree: what of the language is understood.

use std::{rc::Rc, sync::Arc};

use crate::config::Place;

/// A name.
pub(super) type Word = Arc<str>;

/// A name without the namespaces and classes before it.
pub(super) fn last(name: &str) -> &str {
    name.rsplit("::").next().unwrap_or(name)
}

/// The namespaces or classes that are written before a name: empty for `::name`, nothing where
/// there are none.
pub(super) fn qualifier(name: &str) -> Option<&str> {
    name.rsplit_once("::").map(|it| it.0)
}

/// A value as it is written.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Expr {
    pub node: ExprNode,
    pub place: Place,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum ExprNode {
    Whole(i64),
    Real(f64),
    Text(Word),
    /// With the namespaces that are written before it.
    Name(Word),
    Call(Box<Expr>, Vec<Expr>),
    Member(Box<Expr>, Word),
    Index(Box<Expr>, Box<Expr>),
    /// `-`, `!`, `~`, `+`, `&` or `*` before a value.
    Unary(&'static str, Box<Expr>),
    /// `++` and `--`; whether the value is that after it.
    Step(Box<Expr>, i64, bool),
    Binary(&'static str, Box<Expr>, Box<Expr>),
    /// `=` or, with an operator, `+=` and its kin.
    Assign(Option<&'static str>, Box<Expr>, Box<Expr>),
    Choose(Box<Expr>, Box<Expr>, Box<Expr>),
    Braces(Vec<Expr>),
    Lambda(Rc<Function>),
    /// `({ … })`
    Block(Vec<Stmt>),
    /// `(type) value`, `type(value)`, `static_cast<type>(value)`.
    Convert(Kind, Box<Expr>),
}

/// What a number becomes when it is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// As it is.
    Any,
    /// Whole.
    Whole,
    /// 0 or 1.
    Flag,
    /// In so many bits, with a sign or without.
    Bits(u32, bool),
    /// Real.
    Real,
}

/// A statement.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Stmt {
    pub node: StmtNode,
    pub place: Place,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum StmtNode {
    Block(Vec<Stmt>),
    Namespace(Word, Vec<Stmt>),
    Declare(Vec<Declared>),
    Expr(Expr),
    If(Expr, Box<Stmt>, Option<Box<Stmt>>),
    /// Start, condition, step, body.
    For(Option<Box<Stmt>>, Option<Expr>, Option<Expr>, Box<Stmt>),
    /// `for (x : list)`
    Each(Word, Expr, Box<Stmt>),
    While(Expr, Box<Stmt>),
    DoWhile(Box<Stmt>, Expr),
    Switch(Expr, Vec<Stmt>),
    /// `case value:`, or `default:`.
    Case(Option<Expr>),
    Break,
    Continue,
    Return(Option<Expr>),
    Function(Rc<Function>),
    /// A function without its body, for its default arguments.
    Prototype(Rc<Function>),
    /// The functions of a class.
    Class(Vec<Rc<Function>>),
    /// Nothing that is of use here: `using`, `typedef`.
    Nothing,
}

/// A variable that is declared.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Declared {
    pub name: Word,
    pub kind: Kind,
    /// Lengths in brackets.
    pub lengths: Vec<Option<Expr>>,
    pub value: Option<Expr>,
    pub reference: bool,
    pub constant: bool,
    /// It is made once and stays.
    pub lasting: bool,
    pub place: Place,
}

/// A function, or a lambda, which has no name.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Function {
    pub name: Word,
    /// The namespace that it is in; empty for the file's own.
    pub space: Word,
    pub parameters: Vec<Parameter>,
    pub body: Vec<Stmt>,
    /// Whether it runs without a call by its name: a constructor, a destructor, an operator.
    pub hidden: bool,
    /// Whether it is stated as `name::name`, as functions of classes can be.
    pub qualified: bool,
    pub place: Place,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct Parameter {
    pub name: Word,
    pub kind: Kind,
    pub reference: bool,
    pub default: Option<Expr>,
}
