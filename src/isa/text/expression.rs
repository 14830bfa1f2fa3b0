//! Statements and what stands between their parentheses.

use std::fmt;

use crate::config::{Fault, Place};

/// `name(argument, argument);`
#[derive(Clone, Debug, PartialEq)]
pub struct Statement {
    /// What is to be done, as the vendor writes it.
    pub name: String,
    /// Where the name stands.
    pub name_place: Place,
    /// On what.
    pub arguments: Vec<Argument>,
    /// From the name to the semicolon.
    pub place: Place,
    /// Where it is written, `file:line:column`, if that is another file than the one of its place.
    pub origin: Option<String>,
}

/// One argument of a statement.
#[derive(Clone, Debug, PartialEq)]
pub enum Argument {
    /// One value.
    One(Expression),
    /// Several between braces, as a generic bus takes them.
    Group {
        /// The values.
        items: Vec<Expression>,
        /// From brace to brace.
        place: Place,
    },
}

impl Argument {
    /// Where it stands.
    #[must_use]
    pub const fn place(&self) -> Place {
        match self {
            Self::One(expression) => expression.place,
            Self::Group { place, .. } => *place,
        }
    }

    /// Its values.
    #[must_use]
    pub fn items(&self) -> &[Expression] {
        match self {
            Self::One(one) => std::slice::from_ref(one),
            Self::Group { items, .. } => items,
        }
    }
}

/// A value as it is written.
#[derive(Clone, Debug, PartialEq)]
pub struct Expression {
    /// What is written.
    pub term: Term,
    /// Where in the text.
    pub place: Place,
}

/// What a value is made of.
#[derive(Clone, Debug, PartialEq)]
pub enum Term {
    /// A number, not negative.
    Number(f64),
    /// A register, a direction, a constant.
    Name(String),
    /// `-a`
    Negate(Box<Expression>),
    /// `a + b` and its kin.
    Binary {
        /// What is done with the two.
        operator: Operator,
        /// Left of it.
        left: Box<Expression>,
        /// Right of it.
        right: Box<Expression>,
    },
    /// `X[dir]`, `X[-dir]`, `R[dir]`: in macros only, something that belongs to a direction.
    Of {
        /// `X` or `R`.
        base: String,
        /// Of the opposite direction.
        opposite: bool,
        /// Name of the parameter that holds the direction.
        direction: String,
    },
}

/// Arithmetic on constants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operator {
    /// `+`
    Add,
    /// `-`
    Subtract,
    /// `*`
    Multiply,
    /// `/`
    Divide,
    /// `%`, with the sign of the left side, as in C.
    Remainder,
}

impl Operator {
    /// As it is written.
    #[must_use]
    pub const fn mark(self) -> &'static str {
        match self {
            Self::Add => "+",
            Self::Subtract => "-",
            Self::Multiply => "*",
            Self::Divide => "/",
            Self::Remainder => "%",
        }
    }

    /// Products bind tighter than sums.
    const fn binds_tightly(self) -> bool {
        matches!(self, Self::Multiply | Self::Divide | Self::Remainder)
    }

    /// What it does.
    #[must_use]
    pub fn apply(self, left: f64, right: f64) -> f64 {
        match self {
            Self::Add => left + right,
            Self::Subtract => left - right,
            Self::Multiply => left * right,
            Self::Divide => left / right,
            Self::Remainder => left % right,
        }
    }
}

impl Statement {
    /// A fault of it, that says where it is written.
    #[must_use]
    pub fn told(&self, fault: Fault) -> Fault {
        fault.written(self.origin.as_deref())
    }
}

impl fmt::Display for Statement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}(", self.name)?;
        for (i, argument) in self.arguments.iter().enumerate() {
            let comma = if i == 0 { "" } else { ", " };
            write!(f, "{comma}{argument}")?;
        }
        f.write_str(");")
    }
}

impl fmt::Display for Argument {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::One(expression) => expression.fmt(f),
            Self::Group { items, .. } => {
                f.write_str("{")?;
                for (i, item) in items.iter().enumerate() {
                    let comma = if i == 0 { "" } else { ", " };
                    write!(f, "{comma}{item}")?;
                }
                f.write_str("}")
            }
        }
    }
}

impl fmt::Display for Expression {
    /// With no more parentheses than are needed to read the same back.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.term {
            Term::Number(value) => write!(f, "{value}"),
            Term::Name(name) => f.write_str(name),
            Term::Negate(inner) => match inner.term {
                Term::Binary { .. } | Term::Negate(_) => write!(f, "-({inner})"),
                _ => write!(f, "-{inner}"),
            },
            Term::Binary {
                operator,
                left,
                right,
            } => {
                let loose = |e: &Expression| matches!(&e.term, Term::Binary { operator: inner, .. } if !inner.binds_tightly());
                let any = |e: &Expression| matches!(e.term, Term::Binary { .. });
                let wrap_left = operator.binds_tightly() && loose(left);
                let wrap_right = if operator.binds_tightly() {
                    any(right)
                } else {
                    loose(right)
                };
                write_wrapped(f, left, wrap_left)?;
                write!(f, " {} ", operator.mark())?;
                write_wrapped(f, right, wrap_right)
            }
            Term::Of {
                base,
                opposite,
                direction,
            } => {
                let sign = if *opposite { "-" } else { "" };
                write!(f, "{base}[{sign}{direction}]")
            }
        }
    }
}

fn write_wrapped(f: &mut fmt::Formatter<'_>, inner: &Expression, wrap: bool) -> fmt::Result {
    if wrap {
        write!(f, "({inner})")
    } else {
        write!(f, "{inner}")
    }
}
