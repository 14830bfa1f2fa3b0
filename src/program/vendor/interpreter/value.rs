//! What the micro-controller's variables hold, as far as it is known before the program runs.

use std::{cmp::Ordering, rc::Rc};

use super::{layout::Layout, reason::Reason};
use crate::{
    limit::VENDOR_VALUES,
    program::vendor::{
        host::Random,
        lexer::constant,
        syntax::tree::{Function, Kind, Width, Word},
    },
};

/// Asking for memory and giving it back takes about as long as copying so many values.
const OWN_MEMORY: usize = 16;

/// The index of a variable.
pub(in crate::program::vendor) type Slot = usize;

/// Why a variable to which nothing was assigned has no value.
pub(super) fn unassigned(name: &str) -> Reason {
    format!("`{name}`, which is not initialised").into()
}

/// A value.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::program::vendor) enum Value {
    /// An `int`.
    Whole(i64),
    /// A whole number of another type.
    Wide(i64, Width),
    Real(f64),
    /// A real number of 32 bits.
    Single(f32),
    /// Only the run knows: why.
    Unknown(Reason),
    /// A register, a direction, a display: something with a name.
    Symbol(Word),
    /// Directions that were joined with `|`.
    Symbols(Vec<Word>),
    Text(Word),
    List(Vec<Value>),
    /// A variable, or an element of it, with the name that it was given.
    Pointer(Slot, Vec<usize>, Word),
    /// A reverse iterator: the element is the one before, with the name of the array.
    Back(Slot, Vec<usize>, Word),
    Lambda(Rc<Function>),
    /// An object of the language's library that draws random numbers, with its parameters.
    Random(Random, [f64; 2]),
    /// An object, with the values of its members.
    Record(Rc<Layout>, Vec<Value>),
    /// Another name for an element of a variable.
    Reference(Slot, Vec<usize>),
}

impl Value {
    pub(in crate::program::vendor) fn flag(value: bool) -> Self {
        Self::Whole(i64::from(value))
    }

    /// A number of bytes or of elements.
    pub(in crate::program::vendor) const fn size_t(value: i64) -> Self {
        Self::Wide(value, Width::UnsignedLong)
    }

    /// How many values there are in it.
    pub(in crate::program::vendor) fn size(&self) -> usize {
        match self {
            Self::List(all) | Self::Record(_, all) => 1 + all.iter().map(Self::size).sum::<usize>(),
            Self::Text(text) => 1 + text.len() / 64,
            _ => 1,
        }
    }

    /// What copying it takes, in values: one that holds others has memory of its own.
    pub(in crate::program::vendor) fn weight(&self) -> usize {
        match self {
            Self::List(all) | Self::Record(_, all) => {
                OWN_MEMORY + all.iter().map(Self::weight).sum::<usize>()
            }
            other => other.size(),
        }
    }

    /// How many values a variable with it holds, as its declaration is counted: one more for each
    /// object.
    pub(super) fn held(&self) -> usize {
        match self {
            Self::List(all) => all.iter().map(Self::held).sum(),
            Self::Record(_, all) => 1 + all.iter().map(Self::held).sum::<usize>(),
            _ => 1,
        }
    }

    /// How many values there are in it that hold no others.
    pub(super) fn leaves(&self) -> usize {
        match self {
            Self::List(all) | Self::Record(_, all) => all.iter().map(Self::leaves).sum(),
            _ => 1,
        }
    }

    pub(in crate::program::vendor) fn number(&self) -> Option<f64> {
        match self {
            Self::Wide(value, Width::UnsignedLong) => Some(*value as u64 as f64),
            Self::Whole(value) | Self::Wide(value, _) => Some(*value as f64),
            Self::Real(value) => Some(*value),
            Self::Single(value) => Some(f64::from(*value)),
            _ => None,
        }
    }

    /// A number as it is written: of 32 bits, the shortest that stands for it.
    pub(in crate::program::vendor) fn decimal(&self) -> Option<f64> {
        match self {
            Self::Single(value) => value.to_string().parse().ok(),
            other => other.number(),
        }
    }

    /// A number in letters; nothing for what is none.
    pub(in crate::program::vendor) fn written(&self) -> String {
        match self {
            Self::Wide(value, Width::UnsignedLong) => (*value as u64).to_string(),
            Self::Whole(value) | Self::Wide(value, _) => value.to_string(),
            Self::Real(value) => value.to_string(),
            Self::Single(value) => value.to_string(),
            _ => String::new(),
        }
    }

    pub(in crate::program::vendor) fn whole(&self) -> Option<i64> {
        match self {
            Self::Whole(value) | Self::Wide(value, _) => Some(*value),
            Self::Real(value) if value.is_finite() => Some(*value as i64),
            Self::Single(value) if value.is_finite() => Some(*value as i64),
            _ => None,
        }
    }

    pub(in crate::program::vendor) fn from_number(value: f64) -> Self {
        if value.fract() == 0.0 && value.abs() < 1e15 {
            match i32::try_from(value as i64) {
                Ok(value) => Self::Whole(value.into()),
                Err(_) => Self::Wide(value as i64, Width::Long),
            }
        } else {
            Self::Real(value)
        }
    }

    /// Whether a condition holds; the reason where only the run knows.
    pub(in crate::program::vendor) fn truth(&self) -> Result<bool, Reason> {
        match self {
            Self::Unknown(why) => Err(why.clone()),
            other => Ok(other.number().is_none_or(|value| value != 0.0)),
        }
    }

    /// As a variable of this type holds it.
    pub(in crate::program::vendor) fn converted(self, kind: Kind) -> Self {
        match kind {
            _ if self.number().is_none() => self,
            Kind::Float => Self::Single(self.single()),
            Kind::Real => Self::Real(self.number().unwrap_or_default()),
            Kind::Flag => Self::flag(self.number().is_some_and(|value| value != 0.0)),
            Kind::Bits(bits, signed) => {
                Self::fitted(self.whole().unwrap_or_default(), bits, signed)
            }
            Kind::Any | Kind::Analog | Kind::Digital | Kind::Parameter(_) => self,
        }
    }

    /// A number in 32 bits, as real; 0 where it is none.
    fn single(&self) -> f32 {
        match self {
            Self::Single(value) => *value,
            // Not by way of 64 bits, which would round twice.
            Self::Wide(value, Width::UnsignedLong) => *value as u64 as f32,
            Self::Whole(value) | Self::Wide(value, _) => *value as f32,
            other => other.number().unwrap_or_default() as f32,
        }
    }

    /// A whole number in so many bits.
    fn fitted(value: i64, bits: u32, signed: bool) -> Self {
        let unused = 64 - bits.clamp(1, 64);
        let value = if signed {
            value << unused >> unused
        } else {
            ((value as u64) << unused >> unused) as i64
        };
        match (bits, signed) {
            (64, true) => Self::Wide(value, Width::Long),
            (64, false) => Self::Wide(value, Width::UnsignedLong),
            (32, false) => Self::Wide(value, Width::Unsigned),
            _ => Self::Whole(value),
        }
    }

    /// The type of a number.
    pub(in crate::program::vendor) fn kind(&self) -> Kind {
        match self {
            Self::Whole(_) => Kind::INT,
            Self::Wide(_, Width::Unsigned) => Kind::Bits(32, false),
            Self::Wide(_, Width::Long) => Kind::Bits(64, true),
            Self::Wide(_, Width::UnsignedLong) => Kind::Bits(64, false),
            Self::Real(_) => Kind::Real,
            Self::Single(_) => Kind::Float,
            _ => Kind::Any,
        }
    }

    /// A whole number, and its type where that is no `int`.
    const fn parts(&self) -> Option<(i64, Option<Width>)> {
        match self {
            Self::Whole(value) => Some((*value, None)),
            Self::Wide(value, width) => Some((*value, Some(*width))),
            _ => None,
        }
    }

    /// A whole number of a type of its own.
    fn of_width(value: i64, width: Option<Width>) -> Self {
        match width {
            None => Self::fitted(value, 32, true),
            Some(Width::Unsigned) => Self::fitted(value, 32, false),
            Some(wide) => Self::Wide(value, wide),
        }
    }

    /// What stands before a number: `-`, `~` or `+`.
    pub(in crate::program::vendor) fn signed(&self, operator: &str) -> Option<Self> {
        if let (Self::Real(value), "-" | "+") = (self, operator) {
            return Some(Self::Real(if operator == "-" { -value } else { *value }));
        }
        if let (Self::Single(value), "-" | "+") = (self, operator) {
            return Some(Self::Single(if operator == "-" { -value } else { *value }));
        }
        let (value, width) = self.parts()?;
        let value = match operator {
            "-" => value.wrapping_neg(),
            "~" => !value,
            _ => value,
        };
        Some(Self::of_width(value, width))
    }

    /// Whole numbers under an operator: both become the wider of their types, as in C++.
    fn of_whole(operator: &str, left: &Self, right: &Self) -> Option<Self> {
        let ((a, of_a), (b, of_b)) = (left.parts()?, right.parts()?);
        if matches!(operator, "<<" | ">>") {
            let bits = match of_a {
                None | Some(Width::Unsigned) => 32,
                Some(_) => 64,
            };
            let by = u32::try_from(b).ok().filter(|by| *by < bits)?;
            let value = match (operator, of_a) {
                ("<<", _) => a << by,
                (_, Some(Width::UnsignedLong)) => (a as u64 >> by) as i64,
                _ => a >> by,
            };
            return Some(Self::of_width(value, of_a));
        }
        let width = of_a.max(of_b);
        let own = |value| Self::of_width(value, width).parts().map(|it| it.0);
        let (a, b) = (own(a)?, own(b)?);
        let (low, high) = (a as u64, b as u64);
        let value = match operator {
            "/" if width == Some(Width::UnsignedLong) => low.checked_div(high)? as i64,
            "%" if width == Some(Width::UnsignedLong) => low.checked_rem(high)? as i64,
            "<" | ">" | "<=" | ">=" if width == Some(Width::UnsignedLong) => {
                // The order of numbers without a sign.
                constant::apply(operator, a ^ i64::MIN, b ^ i64::MIN)?
            }
            _ => constant::apply(operator, a, b)?,
        };
        let width =
            width.filter(|_| matches!(operator, "+" | "-" | "*" | "/" | "%" | "&" | "|" | "^"));
        Some(Self::of_width(value, width))
    }

    /// Texts under `+` and `-`: one behind the other, or as pointers to characters, each of which is
    /// the rest of its text; nothing where they are none.
    fn of_texts(operator: &str, left: &Self, right: &Self) -> Option<Result<Self, String>> {
        let apart = |a: &Word, b: &Word| {
            let inside = b.ends_with(&**a);
            inside.then(|| Self::Wide((b.len() - a.len()) as i64, Width::Long))
        };
        match (operator, left, right) {
            ("+", Self::Text(a), Self::Text(b)) if a.len() + b.len() > VENDOR_VALUES => Some(Err(
                format!("a text of more than {VENDOR_VALUES} characters"),
            )),
            ("+", Self::Text(a), Self::Text(b)) => Some(Ok(Self::Text(format!("{a}{b}").into()))),
            ("+", Self::Text(text), Self::Whole(by) | Self::Wide(by, _))
            | ("+", Self::Whole(by) | Self::Wide(by, _), Self::Text(text)) => {
                let rest = usize::try_from(*by).ok().and_then(|by| text.get(by..));
                let rest = rest.map(|it| Self::Text(it.into()));
                Some(rest.ok_or_else(|| {
                    format!("{by} characters from here is past the end of the string")
                }))
            }
            ("-", Self::Text(a), Self::Text(b)) => {
                let back = || apart(b, a).and_then(|it| it.signed("-"));
                apart(a, b).or_else(back).map(Ok)
            }
            _ => None,
        }
    }

    /// Arithmetic of C++; `Err` says why there is none.
    pub(in crate::program::vendor) fn binary(
        operator: &str,
        left: &Self,
        right: &Self,
    ) -> Result<Self, String> {
        use Value::{Back, Pointer, Real, Single, Symbol, Symbols, Unknown, Whole, Wide};
        if let Some(made) = Self::of_texts(operator, left, right) {
            return made;
        }
        let are_compared = matches!(
            (left, right),
            (Self::Text(_), Self::Text(_)) | (Self::List(_), Self::List(_))
        );
        if are_compared && let Some(found) = left.compared(operator, right) {
            return Ok(found);
        }
        let names = |value: &Self| match value {
            Symbol(name) => Some(vec![name.clone()]),
            Symbols(names) => Some(names.clone()),
            _ => None,
        };
        Ok(match (left, right) {
            // `0 * x` and `false && x` are not worth knowing better.
            (Unknown(why), _) | (_, Unknown(why)) => Unknown(why.clone()),
            (Whole(a) | Wide(a, _), Whole(b) | Wide(b, _)) => Self::of_whole(operator, left, right)
                .ok_or_else(|| format!("{a} {operator} {b} is undefined"))?,
            (
                Whole(_) | Wide(..) | Real(_) | Single(_),
                Whole(_) | Wide(..) | Real(_) | Single(_),
            ) => {
                // Of 32 bits where neither has more.
                let narrow = !matches!((left, right), (Real(_), _) | (_, Real(_)));
                let of = |value: &Self| {
                    if narrow {
                        f64::from(value.single())
                    } else {
                        value.number().unwrap_or(0.0)
                    }
                };
                let (a, b) = (of(left), of(right));
                // What 64 bits make of two numbers of 32 rounds to what 32 bits make of them.
                let made = |value: f64| {
                    if narrow {
                        Single(value as f32)
                    } else {
                        Real(value)
                    }
                };
                match operator {
                    "+" => made(a + b),
                    "-" => made(a - b),
                    "*" => made(a * b),
                    "/" => made(a / b),
                    "<" => Self::flag(a < b),
                    ">" => Self::flag(a > b),
                    "<=" => Self::flag(a <= b),
                    ">=" => Self::flag(a >= b),
                    "==" => Self::flag(a == b),
                    "!=" => Self::flag(a != b),
                    "&&" => Self::flag(a != 0.0 && b != 0.0),
                    "||" => Self::flag(a != 0.0 || b != 0.0),
                    _ => return Err(format!("`{operator}` needs integers")),
                }
            }
            (Pointer(slot, path, name), Whole(by) | Wide(by, _))
                if matches!(operator, "+" | "-") =>
            {
                let by = if operator == "-" { -by } else { *by };
                let path = moved(path, by)
                    .ok_or_else(|| format!("a pointer before the array `{name}`"))?;
                Pointer(*slot, path, name.clone())
            }
            (Back(slot, path, name), Whole(by) | Wide(by, _)) if matches!(operator, "+" | "-") => {
                let by = if operator == "+" { -by } else { *by };
                let path = moved(path, by)
                    .ok_or_else(|| format!("a pointer before the array `{name}`"))?;
                Back(*slot, path, name.clone())
            }
            (Whole(_) | Wide(..), Pointer(..)) if operator == "+" => {
                Self::binary(operator, right, left)?
            }
            _ if matches!(operator, "==" | "!=") => {
                Self::flag((left == right) == (operator == "=="))
            }
            _ if operator == "&&" || operator == "||" => {
                let (a, b) = (left.truth().unwrap_or(true), right.truth().unwrap_or(true));
                Self::flag(if operator == "&&" { a && b } else { a || b })
            }
            _ => match (operator, names(left), names(right)) {
                ("|" | "+", Some(mut a), Some(b)) => {
                    for name in b {
                        if !a.contains(&name) {
                            a.push(name);
                        }
                    }
                    Symbols(a)
                }
                _ => {
                    return Err(format!(
                        "`{operator}` between {} and {}",
                        left.describe(),
                        right.describe()
                    ));
                }
            },
        })
    }

    /// Two texts or arrays of the language's library under an operator that compares; nothing
    /// under another one, or where they hold what has no order.
    fn compared(&self, operator: &str, other: &Self) -> Option<Self> {
        let holds = match operator {
            "==" => Ordering::is_eq,
            "!=" => Ordering::is_ne,
            "<" => Ordering::is_lt,
            ">" => Ordering::is_gt,
            "<=" => Ordering::is_le,
            ">=" => Ordering::is_ge,
            _ => return None,
        };
        if let Some(order) = self.order(other) {
            return Some(Self::flag(holds(order)));
        }
        let unknown = self.unknown().or_else(|| other.unknown());
        unknown.map(|why| Self::Unknown(why.clone()))
    }

    /// Why something in it is not known.
    fn unknown(&self) -> Option<&Reason> {
        match self {
            Self::Unknown(why) => Some(why),
            Self::List(all) | Self::Record(_, all) => all.iter().find_map(Self::unknown),
            _ => None,
        }
    }

    /// Which of two numbers, texts, pairs or arrays comes first; nothing where that is not known.
    pub(in crate::program::vendor) fn order(&self, other: &Self) -> Option<Ordering> {
        match (self, other) {
            (Self::Text(a), Self::Text(b)) => Some(a.as_bytes().cmp(b.as_bytes())),
            (Self::Record(_, one), Self::Record(_, other))
            | (Self::List(one), Self::List(other)) => {
                for (a, b) in one.iter().zip(other) {
                    let order = a.order(b)?;
                    if order.is_ne() {
                        return Some(order);
                    }
                }
                Some(one.len().cmp(&other.len()))
            }
            _ => self.number()?.partial_cmp(&other.number()?),
        }
    }

    pub(in crate::program::vendor) fn describe(&self) -> String {
        match self {
            Self::Whole(_) | Self::Wide(..) | Self::Real(_) | Self::Single(_) => {
                format!("the number {}", self.written())
            }
            Self::Unknown(why) => format!("a value that depends on {why}"),
            Self::Symbol(name) | Self::Pointer(_, _, name) | Self::Back(_, _, name) => {
                format!("`{name}`")
            }
            Self::Symbols(names) => format!("`{}`", names.join(" | ")),
            Self::Text(_) => "a text".to_owned(),
            Self::List(_) => "an array".to_owned(),
            Self::Lambda(_) => "a function".to_owned(),
            Self::Random(..) => "a source of random numbers".to_owned(),
            Self::Record(layout, _) => format!("an object of `{}`", layout.name),
            Self::Reference(..) => "a reference".to_owned(),
        }
    }
}

/// The place so many elements further in an array; `None` before it begins.
pub(super) fn moved(path: &[usize], by: i64) -> Option<Vec<usize>> {
    let mut path = path.to_vec();
    let last = path.pop().unwrap_or_default() as i64;
    path.push(usize::try_from(last.checked_add(by)?).ok()?);
    Some(path)
}
