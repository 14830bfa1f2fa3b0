//! A program as it is written: the tree that is parsed, printed and expanded.

use crate::config::Place;
use crate::isa::text::{Expression, Statement};

/// The text of a program, taken apart.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Syntax {
    /// The lines of settings at the top, without `//!`.
    pub header: Vec<String>,
    /// What it does.
    pub items: Vec<Item>,
    /// The lines of expectation at the bottom, without `//=`.
    pub footer: Vec<String>,
}

/// One item, with what a formatter must not lose.
#[derive(Clone, Debug, PartialEq)]
pub struct Item {
    /// What it is.
    pub node: Node,
    /// Whether a blank line stands before it.
    pub blank_before: bool,
    /// A comment behind it on the same line.
    pub trailing: Option<Comment>,
    /// Where it stands.
    pub place: Place,
}

/// What an item is.
#[derive(Clone, Debug, PartialEq)]
pub enum Node {
    /// A comment on a line of its own.
    Comment(Comment),
    /// `name(argument, argument);`
    Statement(Statement),
    /// `const name = value;`
    Const {
        /// The name.
        name: String,
        /// Where the name stands.
        name_place: Place,
        /// What it means.
        value: Expression,
    },
    /// `init { … }`: once, before the first frame.
    Init(Vec<Item>),
    /// `frame { … }`: for every frame.
    Frame(Vec<Item>),
    /// `repeat times { … }`
    Repeat {
        /// How often.
        times: Expression,
        /// The statements that are repeated.
        body: Vec<Item>,
    },
    /// A kernel of vendor C++, launched.
    Kernel(Kernel),
}

/// A kernel of vendor C++, with the words that it has at a launch.
#[derive(Clone, Debug, PartialEq)]
pub struct Kernel {
    /// Where it begins, among the texts of all files, and how many begin there before it.
    pub begins: (usize, usize),
    /// Where its words lie between its launches.
    pub kept: Kept,
    /// Its words.
    pub body: Vec<Item>,
}

/// Where the words of a kernel lie between its launches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kept {
    /// In the chip's store, from the first launch on.
    #[default]
    Store,
    /// Nowhere: they are recorded for each launch, and the store has their room back behind it.
    Launch,
    /// In the memory of the micro-controller.
    Heap,
}

/// A comment.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Comment {
    /// `// …`, without `//`.
    Line(String),
    /// `/* … */`, without the marks.
    Block(String),
}
