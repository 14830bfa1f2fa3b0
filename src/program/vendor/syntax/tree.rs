//! A text of vendor C++ as a tree: what of the language is understood.

use std::{rc::Rc, sync::Arc};

use crate::{
    config::Place,
    program::syntax::{Item, Kept},
};

/// A name.
pub(in crate::program::vendor) type Word = Arc<str>;

/// The call that makes an array of a length, filled with a value.
pub(in crate::program::vendor) const FILLED: &str = "a filled vector";

/// The call that stands for what an object is given whose class the parser does not know.
pub(in crate::program::vendor) const OF_OTHERS: &str = "an object of others";

/// The call that gives a limit of the numbers of a type: its name, and a value of the type.
pub(in crate::program::vendor) const LIMIT: &str = "a limit";

/// A name without the namespaces and classes before it.
pub(in crate::program::vendor) fn last(name: &str) -> &str {
    name.rsplit("::").next().unwrap_or(name)
}

/// The namespaces or classes that are written before a name: empty for `::name`, nothing where
/// there are none.
pub(in crate::program::vendor) fn qualifier(name: &str) -> Option<&str> {
    name.rsplit_once("::").map(|it| it.0)
}

/// A value as it is written.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::program::vendor) struct Expr {
    pub node: ExprNode,
    pub place: Place,
}

impl Expr {
    /// An object of a class, made of these.
    pub(super) fn made(class: &str, given: Vec<Self>, place: Place) -> Self {
        let node = ExprNode::Name(class.into());
        let callee = Box::new(Self { node, place });
        let node = ExprNode::Call(callee, given);
        Self { node, place }
    }
}

#[derive(Clone, Debug, PartialEq)]
pub(in crate::program::vendor) enum ExprNode {
    Whole(i64),
    /// A whole number that is no `int`.
    Wide(i64, Width),
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
    /// `{.member = value}`
    Designated(Vec<(Word, Expr)>),
    Lambda(Rc<Function>),
    /// `({ … })`
    Block(Vec<Stmt>),
    /// `(type) value`, `type(value)`, `static_cast<type>(value)`.
    Convert(Kind, Box<Expr>),
    /// `(type *) value`: memory seen as numbers of this type.
    Recast(Kind, Box<Expr>),
    /// `sizeof value`
    SizeOf(Box<Expr>),
    /// `new type`, `new type[length]`.
    New(Box<Declared>),
    /// `name<…>(…)`: the call, and what its template is given.
    Template(Vec<TemplateArgument>, Box<Expr>),
}

/// What a template is given in `<…>`.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::program::vendor) enum TemplateArgument {
    Type(Kind),
    Value(Expr),
}

/// What a number becomes when it is stored, and which register a name may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::program::vendor) enum Kind {
    /// Stored as it is.
    Any,
    /// 0 or 1.
    Flag,
    /// In so many bits, with a sign or without.
    Bits(u32, bool),
    /// Real, of 32 bits.
    Float,
    /// Real.
    Real,
    /// `areg_t`
    Analog,
    /// `dreg_t`
    Digital,
    /// The type that a template is given at this position.
    Parameter(usize),
}

impl Kind {
    /// `int`
    pub(in crate::program::vendor) const INT: Self = Self::Bits(32, true);
    /// `char`
    pub(in crate::program::vendor) const CHARACTER: Self = Self::Bits(8, true);

    /// What `sizeof` gives, where that is known.
    pub(in crate::program::vendor) const fn bytes(self) -> Option<i64> {
        match self {
            Self::Flag => Some(1),
            Self::Bits(bits, _) => Some(bits as i64 / 8),
            Self::Float => Some(4),
            Self::Real => Some(8),
            Self::Any | Self::Analog | Self::Digital | Self::Parameter(_) => None,
        }
    }
}

/// The type of a whole number that is no `int`, from those that give way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::program::vendor) enum Width {
    Unsigned,
    Long,
    UnsignedLong,
}

/// A statement.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::program::vendor) struct Stmt {
    pub node: StmtNode,
    pub place: Place,
}

#[derive(Clone, Debug, PartialEq)]
pub(in crate::program::vendor) enum StmtNode {
    Block(Vec<Stmt>),
    Kernel(Kernel),
    Namespace(Word, Vec<Stmt>),
    Declare(Vec<Declared>),
    Expr(Expr),
    If(Expr, Box<Stmt>, Option<Box<Stmt>>),
    /// Start, condition, step, body.
    For(Option<Box<Stmt>>, Option<Expr>, Option<Expr>, Box<Stmt>),
    /// `for (x : list)`
    Each(Box<Declared>, Expr, Box<Stmt>),
    While(Expr, Box<Stmt>),
    DoWhile(Box<Stmt>, Expr),
    Switch(Expr, Vec<Stmt>),
    /// `case value:`, `case {first, last}:` for all between them, or `default:`.
    Case(Option<Expr>),
    Break,
    Continue,
    Return(Option<Expr>),
    Function(Rc<Function>),
    /// A function without its body, for its default arguments.
    Prototype(Rc<Function>),
    /// `struct name { members };`
    Struct(Rc<Struct>),
    /// The functions of a class.
    Class(Vec<Rc<Function>>),
    /// Nothing that is of use here: `using`, `typedef`.
    Nothing,
}

/// A kernel, between its beginning and its end.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::program::vendor) struct Kernel {
    /// Whether it is `static`: recorded once, where it is launched first.
    pub fixed: bool,
    /// How many kernels begin at its place before it, as those of a macro do.
    pub ordinal: usize,
    pub body: Vec<Stmt>,
    /// Where it begins.
    pub begin: Place,
}

/// A variable that the block of a kernel reads, or a member of an object.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::program::vendor) struct Read {
    pub of: Expr,
    /// The namespace of the function that reads it, where that is a variable of the file.
    pub space: Option<Word>,
}

/// Which kernel it is that was recorded: where it begins, which of those that begin there, and what
/// the template is made for that it stands in.
pub(in crate::program::vendor) type Recorded = (usize, usize, String);

/// Words that were recorded.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::program::vendor) struct Words {
    pub items: Rc<[Item]>,
    /// Where they lie between launches.
    pub kept: Kept,
    /// Which of what the machine keeps was read of variables while they were recorded.
    pub read: Option<usize>,
}

/// A variable that is declared.
#[allow(clippy::struct_excessive_bools)] // What was said, each on its own.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::program::vendor) struct Declared {
    pub name: Word,
    pub kind: Kind,
    /// The type's own name.
    pub of: Word,
    /// Lengths in brackets.
    pub lengths: Vec<Option<Expr>>,
    pub value: Option<Expr>,
    pub reference: bool,
    pub pointer: bool,
    /// Whether it is an array of the language's library, which is copied with its name.
    pub library: bool,
    /// `extern`: it is defined elsewhere.
    pub outside: bool,
    pub constant: bool,
    /// It is made once and stays.
    pub lasting: bool,
    pub place: Place,
}

/// A class whose members are data, nothing else that matters when an object is made.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::program::vendor) struct Struct {
    pub name: Word,
    pub members: Vec<Declared>,
    pub functions: Vec<Rc<Function>>,
    /// The class that it is made from.
    pub base: Option<Word>,
    /// The namespace of what belongs to it: its own name, behind those of its namespaces.
    pub space: Word,
    /// Whether these are the members of each element of a map.
    pub map: bool,
    /// What it is, where its objects are not supported.
    pub unread: Option<&'static str>,
    /// The first member that is not understood.
    pub stops: Option<Place>,
}

/// A function, or a lambda, which has no name.
#[allow(clippy::struct_excessive_bools)] // What was said, each on its own.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::program::vendor) struct Function {
    pub name: Word,
    /// The namespace that it is in; empty for the file's own.
    pub space: Word,
    pub parameters: Rc<[Parameter]>,
    pub body: Rc<[Stmt]>,
    /// Whether it runs without a call by its name: a constructor, a destructor, an operator.
    pub hidden: bool,
    /// Whether it is defined as `name::name`, as functions of classes can be.
    pub qualified: bool,
    pub place: Place,
    /// What the number that it gives back becomes.
    pub returns: Kind,
    /// The class of what it gives back, and of the elements, where that is an array.
    pub gives: Word,
    pub element: Word,
    /// Whether it gives back a variable itself: `type &name(…)`.
    pub refers: bool,
    /// Whether it leaves its object as it is: `type name(…) const`.
    pub constant: bool,
    /// What stands in `template <…>`.
    pub template: Vec<TemplateParameter>,
    /// What stands in the brackets of a lambda.
    pub captures: Captures,
    /// The variables that a lambda was made with, by name.
    pub held: Vec<(Word, usize)>,
    /// Whether a class that is made from its own may have another in its place.
    pub bound: Bound,
    /// What a template is given for which it stands in place of the template's own body.
    pub special: Option<Rc<[TemplateArgument]>>,
    /// The words of a kernel, as they were when it was made.
    pub words: Option<Words>,
}

impl Function {
    /// One that takes nothing and does nothing.
    pub(in crate::program::vendor) fn new(name: Word, place: Place) -> Self {
        Self {
            name,
            space: "".into(),
            parameters: Rc::default(),
            body: Rc::default(),
            hidden: false,
            qualified: false,
            place,
            returns: Kind::Any,
            gives: "".into(),
            element: "".into(),
            refers: false,
            constant: false,
            template: Vec::new(),
            captures: Captures::default(),
            held: Vec::new(),
            bound: Bound::Own,
            special: None,
            words: None,
        }
    }

    /// Whether a call cannot tell the two apart.
    pub(in crate::program::vendor) fn same_form(&self, other: &Self) -> bool {
        self.space == other.space && self.overrides(other)
    }

    /// Whether it has the name and the parameters of another, of whatever class.
    pub(in crate::program::vendor) fn overrides(&self, other: &Self) -> bool {
        let form = |it: &Self| -> Vec<(Kind, bool, Word)> {
            let all = it.parameters.iter();
            all.map(|it| (it.kind, it.pointer, it.of.clone())).collect()
        };
        self.name == other.name && self.constant == other.constant && form(self) == form(other)
    }

    /// Whether it is an operator that is called by more than parentheses.
    pub(in crate::program::vendor) fn is_operator(&self) -> bool {
        self.name.starts_with("operator") && &*self.name != "operator()"
    }
}

/// Which function of a class is meant, where an object of a class is at hand that is made from it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::program::vendor) enum Bound {
    Own,
    /// `virtual`: that of the object's class.
    Virtual,
    /// `virtual` without a body in the class.
    Pure,
    /// Without a body in the class, which may stand behind it.
    Announced,
}

/// A name in `template <…>`.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::program::vendor) struct TemplateParameter {
    pub name: Word,
    /// Whether it is a type, rather than a value.
    pub is_type: bool,
    pub default: Option<TemplateArgument>,
}

/// What a lambda takes with it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::program::vendor) struct Captures {
    /// Whether what is not named is copied.
    pub copies: bool,
    /// `[*this]`: the object is copied.
    pub object: bool,
    /// Whether it may change what it has copied, which each copy of it then has for itself.
    pub mutable: bool,
    pub named: Vec<Capture>,
}

impl Captures {
    /// Whether a variable of this name is copied.
    pub(in crate::program::vendor) fn copies(&self, name: &str) -> bool {
        let named = self.named.iter().find(|it| &*it.name == name);
        name != "this" && named.map_or(self.copies, |it| !it.reference)
    }
}

#[derive(Clone, Debug, PartialEq)]
pub(in crate::program::vendor) struct Capture {
    pub name: Word,
    pub reference: bool,
    pub value: Option<Expr>,
}

#[derive(Clone, Debug, PartialEq)]
pub(in crate::program::vendor) struct Parameter {
    pub name: Word,
    pub kind: Kind,
    /// The type's own name.
    pub of: Word,
    /// The class of the elements, where it is an array of the language's library.
    pub element: Word,
    /// The type as it is written, without what says that it is constant.
    pub written: Word,
    /// The type of what a pointer leads to.
    pub pointee: Kind,
    pub reference: bool,
    /// Whether it is a reference, to a constant too.
    pub alias: bool,
    /// Whether it is a pointer, or an array.
    pub pointer: bool,
    /// The names in `(&name)[extent]` and `array<type, extent>`, which a template may be after;
    /// empty where there is none.
    pub extents: Vec<Word>,
    pub default: Option<Expr>,
}
