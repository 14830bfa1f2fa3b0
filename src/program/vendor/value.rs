//! What the micro-controller's variables hold, as far as it is known before the program runs.

use std::{rc::Rc, sync::Arc};

use super::{
    constant,
    tree::{Function, Kind, Word},
};

/// The index of a variable.
pub(super) type Slot = usize;

/// Why a variable to which nothing was assigned has no value.
pub(super) fn unassigned(name: &str) -> Arc<str> {
    format!("`{name}`, to which nothing was assigned,").into()
}

/// A value.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    Whole(i64),
    Real(f64),
    /// Only the run knows: why.
    Unknown(Arc<str>),
    /// A register, a direction, a display: something with a name.
    Symbol(Word),
    /// Directions that were joined with `|`.
    Symbols(Vec<Word>),
    Text(Word),
    List(Vec<Value>),
    /// A variable, or an element of it, with the name that it was given.
    Pointer(Slot, Vec<usize>, Word),
    Lambda(Rc<Function>),
}

impl Value {
    pub(super) fn flag(value: bool) -> Self {
        Self::Whole(i64::from(value))
    }

    pub(super) fn number(&self) -> Option<f64> {
        match self {
            Self::Whole(value) => Some(*value as f64),
            Self::Real(value) => Some(*value),
            _ => None,
        }
    }

    pub(super) fn whole(&self) -> Option<i64> {
        match self {
            Self::Whole(value) => Some(*value),
            Self::Real(value) if value.is_finite() => Some(*value as i64),
            _ => None,
        }
    }

    pub(super) fn from_number(value: f64) -> Self {
        if value.fract() == 0.0 && value.abs() < 1e15 {
            Self::Whole(value as i64)
        } else {
            Self::Real(value)
        }
    }

    /// Whether a condition holds; the reason where only the run knows.
    pub(super) fn truth(&self) -> Result<bool, Arc<str>> {
        match self {
            Self::Unknown(why) => Err(Arc::clone(why)),
            other => Ok(other.number().is_none_or(|value| value != 0.0)),
        }
    }

    /// As a variable of this type holds it.
    pub(super) fn converted(self, kind: Kind) -> Self {
        match (kind, &self) {
            (Kind::Whole, Self::Real(value)) => Self::Whole(*value as i64),
            (Kind::Real, Self::Whole(value)) => Self::Real(*value as f64),
            (Kind::Flag, Self::Whole(_) | Self::Real(_)) => {
                Self::flag(self.number().is_some_and(|value| value != 0.0))
            }
            (Kind::Bits(bits, signed), Self::Whole(_) | Self::Real(_)) => {
                let value = self.whole().unwrap_or_default();
                let low = value & ((1 << bits) - 1);
                let negative = signed && low >> (bits - 1) & 1 == 1;
                Self::Whole(if negative { low - (1 << bits) } else { low })
            }
            _ => self,
        }
    }

    /// Arithmetic of C++; `Err` says why there is none.
    pub(super) fn binary(mark: &str, left: &Self, right: &Self) -> Result<Self, String> {
        use Value::{Pointer, Real, Symbol, Symbols, Unknown, Whole};
        let names = |value: &Self| match value {
            Symbol(name) => Some(vec![name.clone()]),
            Symbols(names) => Some(names.clone()),
            _ => None,
        };
        Ok(match (left, right) {
            // `0 * x` and `false && x` are not worth knowing better.
            (Unknown(why), _) | (_, Unknown(why)) => Unknown(Arc::clone(why)),
            (Whole(a), Whole(b)) => Whole(
                constant::apply(mark, *a, *b)
                    .ok_or_else(|| format!("{a} {mark} {b} has no value"))?,
            ),
            (Whole(_) | Real(_), Whole(_) | Real(_)) => {
                let (a, b) = (left.number().unwrap_or(0.0), right.number().unwrap_or(0.0));
                match mark {
                    "+" => Real(a + b),
                    "-" => Real(a - b),
                    "*" => Real(a * b),
                    "/" => Real(a / b),
                    "<" => Self::flag(a < b),
                    ">" => Self::flag(a > b),
                    "<=" => Self::flag(a <= b),
                    ">=" => Self::flag(a >= b),
                    "==" => Self::flag(a == b),
                    "!=" => Self::flag(a != b),
                    "&&" => Self::flag(a != 0.0 && b != 0.0),
                    "||" => Self::flag(a != 0.0 || b != 0.0),
                    _ => return Err(format!("`{mark}` is for whole numbers")),
                }
            }
            (Pointer(slot, path, name), Whole(by)) if matches!(mark, "+" | "-") => {
                let by = if mark == "-" { -by } else { *by };
                let mut path = path.clone();
                let last = path.pop().unwrap_or_default() as i64 + by;
                let last = usize::try_from(last).map_err(|_| "before its array".to_owned())?;
                path.push(last);
                Pointer(*slot, path, name.clone())
            }
            _ if matches!(mark, "==" | "!=") => Self::flag((left == right) == (mark == "==")),
            _ if mark == "&&" || mark == "||" => {
                let (a, b) = (left.truth().unwrap_or(true), right.truth().unwrap_or(true));
                Self::flag(if mark == "&&" { a && b } else { a || b })
            }
            _ => match (mark, names(left), names(right)) {
                ("|" | "+", Some(mut a), Some(b)) => {
                    a.extend(b);
                    Symbols(a)
                }
                _ => {
                    return Err(format!(
                        "`{mark}` between {} and {}",
                        left.describe(),
                        right.describe()
                    ));
                }
            },
        })
    }

    pub(super) fn describe(&self) -> String {
        match self {
            Self::Whole(value) => format!("the number {value}"),
            Self::Real(value) => format!("the number {value}"),
            Self::Unknown(why) => format!("a value of which {why} decides"),
            Self::Symbol(name) | Self::Pointer(_, _, name) => format!("`{name}`"),
            Self::Symbols(names) => format!("`{}`", names.join(" | ")),
            Self::Text(_) => "a text".to_owned(),
            Self::List(_) => "an array".to_owned(),
            Self::Lambda(_) => "a function".to_owned(),
        }
    }
}
