//! The forms of a statement: its name and what may stand between its parentheses.
//!
//! ```text
//! sub(out y: areg, x0: source, x1: source)
//! OR(out d: dreg, s: bit * 2..4)                       two to four of them
//! bus({out y: target * 1..}, {x: source * 0..})        one or more, in braces
//! scamp5_in(out a: areg, v: lsb[-128..127], trash t: areg = NEWS)
//! DNEWS(out a: dreg, x: bit, dir: dirs, 1)             this number and no other
//! ```

use std::fmt;

use crate::config::{Fault, Place};
use crate::limit::ARGUMENTS;

use super::{
    Bit, Source, Value,
    text::{Cursor, Expression, Token, TokenKind},
};

/// How a statement uses a register argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Reads it.
    In,
    /// Leaves the result in it.
    Out,
    /// Reads it and leaves the result in it.
    InOut,
    /// Overwrites it as scratch.
    Trash,
}

/// What an argument must be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Operand {
    /// An analogue register.
    Areg,
    /// An analogue register or a neighbour's NEWS cell.
    Target,
    /// Anything that an analogue bus can read.
    Source,
    /// A one-bit register.
    Dreg,
    /// Anything that a one-bit operation can read.
    Bit,
    /// One direction.
    Direction,
    /// One direction or `alldir`.
    Directions,
    /// A number, bounds included.
    Number(f64, f64),
    /// A whole number, bounds included.
    Integer(f64, f64),
    /// A name that only the host knows, such as a buffer.
    Word,
    /// This number.
    Literal(f64),
}

/// One parameter of a form.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Its name; empty for a literal.
    pub name: String,
    /// What is done to it.
    pub mode: Mode,
    /// What it must be.
    pub operand: Operand,
    /// How many arguments it takes, at least and at most.
    pub count: (usize, usize),
    /// Whether they stand in braces.
    pub group: bool,
    /// What is meant when it is left out.
    pub default: Option<Expression>,
}

/// One form of a statement.
#[derive(Clone, Debug, PartialEq)]
pub struct Signature {
    /// The name.
    pub name: String,
    /// What it takes.
    pub parameters: Vec<Parameter>,
    /// Where it was written.
    pub place: Place,
}

/// An argument that was given.
#[derive(Clone, Debug)]
pub struct Given {
    /// Its values; several only in braces.
    pub values: Vec<Value>,
    /// Whether it stood in braces.
    pub group: bool,
    /// Where it stood.
    pub place: Place,
}

/// Why arguments do not fit.
#[derive(Clone, Debug)]
pub enum Mismatch {
    /// No form takes so many, or none in braces.
    Shape,
    /// One of them is of another kind.
    Argument {
        /// Which argument.
        index: usize,
        /// What is wrong with it.
        message: String,
    },
}

/// The values of one parameter; empty when it was left out and has a default.
pub type Bound = Vec<Value>;

impl Signature {
    /// Reads a form that stands alone in a text.
    ///
    /// # Errors
    /// What was expected instead.
    pub fn parse(text: &str) -> Result<Self, Fault> {
        let (tokens, mut faults) = super::text::lex(text);
        if let Some(fault) = faults.pop() {
            return Err(fault);
        }
        let mut cursor = Cursor::new(&tokens, text.len());
        let signature = Self::read(&mut cursor)?;
        match cursor.peek() {
            None => Ok(signature),
            Some(_) => Err(cursor.unexpected("the end", "a form is `name(parameter, parameter)`")),
        }
    }

    /// Reads a form.
    ///
    /// # Errors
    /// What was expected instead.
    pub fn read(cursor: &mut Cursor<'_>) -> Result<Self, Fault> {
        const HELP: &str = "a form is `name(parameter, parameter)`";
        let (name, place) = cursor.name("the name of a statement", HELP)?;
        cursor.expect("(", HELP)?;
        let mut parameters = Vec::new();
        if !cursor.take(")") {
            loop {
                let start = cursor.place();
                let several = parameters.last().is_some_and(Parameter::is_open);
                parameters.push(parameter(cursor)?);
                if several || parameters.len() > ARGUMENTS {
                    let what = if several {
                        "only the last parameter can take several arguments".to_owned()
                    } else {
                        format!("a form has {ARGUMENTS} arguments at most")
                    };
                    return Err(Fault::error(start, what, "this parameter").help(HELP));
                }
                if cursor.take(")") {
                    break;
                }
                cursor.expect(",", HELP)?;
            }
        }
        Ok(Self {
            name,
            parameters,
            place: place.to(cursor.before()),
        })
    }

    /// Whether arguments of this number and these braces fit.
    #[must_use]
    pub fn takes(&self, given: &[Given]) -> bool {
        self.split(given)
            .is_some_and(|parts| parts.len() == self.parameters.len())
    }

    /// How many of its parameters are one number and no other.
    #[must_use]
    pub fn literals(&self) -> usize {
        let operands = self.parameters.iter().map(|it| it.operand);
        operands
            .filter(|it| matches!(it, Operand::Literal(_)))
            .count()
    }

    /// Whether it takes whatever another form takes.
    #[must_use]
    pub fn covers(&self, other: &Self) -> bool {
        let (own, others) = (self.counts(), other.counts());
        if own.start() > others.start() || own.end() < others.end() {
            return false;
        }
        let longest = self.parameters.len().max(other.parameters.len());
        (0..longest.min(*others.end())).all(|place| match (self.at(place), other.at(place)) {
            (Some(wide), Some(narrow)) => wide.covers(narrow),
            _ => false,
        })
    }

    /// The parameter of an argument; only the last can take several.
    #[must_use]
    pub fn at(&self, argument: usize) -> Option<&Parameter> {
        self.parameters.get(argument).or(self.parameters.last())
    }

    /// How many arguments it takes.
    #[must_use]
    pub fn counts(&self) -> std::ops::RangeInclusive<usize> {
        let (mut fewest, mut most) = (0, 0);
        for parameter in &self.parameters {
            let (least, last) = if parameter.group {
                (1, 1)
            } else {
                parameter.count
            };
            fewest += if parameter.default.is_some() {
                0
            } else {
                least
            };
            most += last;
        }
        fewest..=most
    }

    /// Splits the arguments between the parameters; `None` where their number does not fit.
    fn split<'a>(&self, given: &'a [Given]) -> Option<Vec<&'a [Given]>> {
        let mut rest = given;
        let mut parts = Vec::new();
        for (i, parameter) in self.parameters.iter().enumerate() {
            let take = if parameter.group || parameter.count == (1, 1) {
                usize::from(!rest.is_empty())
            } else {
                // Only the last parameter can take several.
                debug_assert_eq!(i + 1, self.parameters.len());
                rest.len()
            };
            let (part, tail) = rest.split_at(take);
            let braces = part.iter().all(|g| g.group == parameter.group);
            let count = if parameter.group {
                part.iter().map(|g| g.values.len()).sum()
            } else {
                take
            };
            let (least, most) = parameter.count;
            let enough = count >= least && (!parameter.group || take == 1);
            let left_out = take == 0 && parameter.default.is_some();
            if !braces || count > most || !(enough || left_out) {
                return None;
            }
            parts.push(part);
            rest = tail;
        }
        rest.is_empty().then_some(parts)
    }

    /// Gives each parameter its values.
    ///
    /// # Errors
    /// When number, braces or kinds do not fit.
    pub fn bind(&self, given: &[Given]) -> Result<Vec<Bound>, Mismatch> {
        let parts = self.split(given).ok_or(Mismatch::Shape)?;
        let mut index = 0;
        let mut bound = Vec::new();
        for (parameter, part) in self.parameters.iter().zip(parts) {
            let mut values = Vec::new();
            for argument in part {
                for value in &argument.values {
                    parameter.operand.accepts(value).map_err(|message| {
                        match parameter.operand {
                            Operand::Literal(_) => Mismatch::Shape,
                            _ => Mismatch::Argument { index, message },
                        }
                    })?;
                    values.push(value.clone());
                }
                index += 1;
            }
            bound.push(values);
        }
        Ok(bound)
    }
}

impl Operand {
    /// Whether it takes whatever another takes.
    fn covers(self, other: Self) -> bool {
        match (self, other) {
            (Self::Number(low, high), Self::Number(from, to) | Self::Integer(from, to))
            | (Self::Integer(low, high), Self::Integer(from, to)) => low <= from && to <= high,
            (_, Self::Literal(number)) => self.accepts(&Value::Number(number)).is_ok(),
            (Self::Target | Self::Source, Self::Areg)
            | (Self::Source, Self::Target)
            | (Self::Bit, Self::Dreg)
            | (Self::Directions, Self::Direction) => true,
            _ => self == other,
        }
    }

    pub(super) fn accepts(self, value: &Value) -> Result<(), String> {
        let fits = match (self, value) {
            (Self::Areg, Value::Source(Source::Register(_)))
            | (Self::Target, Value::Source(Source::Register(_) | Source::Neighbour(_)))
            | (Self::Source, Value::Source(_))
            | (Self::Dreg, Value::Bit(Bit::Register(_)))
            | (Self::Bit, Value::Bit(_))
            | (Self::Directions, Value::Directions(_))
            | (Self::Word, Value::Word(_)) => true,
            // NULL, or an array's first element, as C has them.
            (Self::Word, Value::Number(number)) => *number == 0.0,
            (Self::Direction, Value::Directions(all)) => all.len() == 1,
            (Self::Number(low, high), Value::Number(number)) => {
                if !(low..=high).contains(number) {
                    return Err(format!("{number} is not between {low} and {high}"));
                }
                true
            }
            (Self::Integer(low, high), Value::Number(number)) => {
                if !(low..=high).contains(number) || number.fract() != 0.0 {
                    return Err(format!(
                        "{number} is not a whole number between {low} and {high}"
                    ));
                }
                true
            }
            (Self::Literal(want), Value::Number(number)) => want == *number,
            _ => false,
        };
        if fits {
            return Ok(());
        }
        Err(format!(
            "expected {}, found {}",
            self.describe(),
            value.describe()
        ))
    }

    /// What it must be, for messages.
    #[must_use]
    pub fn describe(self) -> String {
        match self {
            Self::Areg => "an analogue register".to_owned(),
            Self::Target => "an analogue register or a neighbour's cell".to_owned(),
            Self::Source => "an analogue source".to_owned(),
            Self::Dreg => "a one-bit register".to_owned(),
            Self::Bit => "a one-bit source".to_owned(),
            Self::Direction => "one of north, east, south, west".to_owned(),
            Self::Directions => "north, east, south, west or alldir".to_owned(),
            Self::Number(low, high) => format!("a number between {low} and {high}"),
            Self::Integer(low, high) => format!("a whole number between {low} and {high}"),
            Self::Word => "the name of a buffer".to_owned(),
            Self::Literal(value) => format!("{value}"),
        }
    }
}

/// Stands for "any number" of arguments.
const OPEN: f64 = 1e6;

impl Parameter {
    /// Whether it takes whatever another takes in its place.
    fn covers(&self, other: &Self) -> bool {
        let group = self.group == other.group;
        let count = !self.group || self.count.0 <= other.count.0 && other.count.1 <= self.count.1;
        group && count && self.operand.covers(other.operand)
    }

    /// Whether it takes arguments up to the last.
    fn is_open(&self) -> bool {
        !self.group && self.count != (1, 1)
    }
}

fn parameter(cursor: &mut Cursor<'_>) -> Result<Parameter, Fault> {
    const HELP: &str = "a parameter is `[out|inout|trash] name: kind [* least..most] [= default]`";
    let start = cursor.place();
    if cursor.take("{") {
        let inner = cursor.deeper(parameter)?;
        cursor.expect("}", HELP)?;
        if inner.group {
            let fault = Fault::error(start, "braces inside braces", "this parameter");
            return Err(fault.help("one pair of braces is enough"));
        }
        return Ok(Parameter {
            group: true,
            ..inner
        });
    }
    if let Some(&Token {
        kind: TokenKind::Number(value),
        ..
    }) = cursor.peek()
    {
        cursor.advance();
        return Ok(Parameter {
            name: String::new(),
            mode: Mode::In,
            operand: Operand::Literal(value),
            count: (1, 1),
            group: false,
            default: None,
        });
    }
    let mode = if cursor.take_word("out") {
        Mode::Out
    } else if cursor.take_word("inout") {
        Mode::InOut
    } else if cursor.take_word("trash") {
        Mode::Trash
    } else {
        Mode::In
    };
    let (name, _) = cursor.name("the name of a parameter", HELP)?;
    cursor.expect(":", HELP)?;
    let operand = operand(cursor)?;
    let count = if cursor.take("*") {
        let least = number(cursor)?;
        cursor.expect("..", HELP)?;
        let open = matches!(
            cursor.peek(),
            Some(Token {
                kind: TokenKind::Mark(_),
                ..
            }) | None
        );
        let most = if open { OPEN } else { number(cursor)? };
        let whole = |count: f64| count.fract() == 0.0 && count >= 0.0;
        let limit = ARGUMENTS as f64;
        if !(whole(least) && whole(most) && least <= most && least <= limit)
            || !open && most > limit
        {
            return Err(Fault::error(
                start.to(cursor.before()),
                format!("`{least}..{most}` is no number of arguments: least and most are whole, {ARGUMENTS} arguments at most"),
                "this parameter",
            )
            .help("write `source * 0..2` for none to two of them"));
        }
        (least as usize, most as usize)
    } else {
        (1, 1)
    };
    let default = if cursor.take("=") {
        Some(cursor.expression()?)
    } else {
        None
    };
    Ok(Parameter {
        name,
        mode,
        operand,
        count,
        group: false,
        default,
    })
}

fn operand(cursor: &mut Cursor<'_>) -> Result<Operand, Fault> {
    const KINDS: &str = "kinds are areg, target, source, dreg, bit, dir, dirs, lsb, int and word";
    let (kind, place) = cursor.name("a kind", KINDS)?;
    let mut bounds = (f64::MIN, f64::MAX);
    if cursor.take("[") {
        let low = number(cursor)?;
        cursor.expect("..", "bounds are `[low..high]`")?;
        bounds = (low, number(cursor)?);
        cursor.expect("]", "bounds are `[low..high]`")?;
        if bounds.0 > bounds.1 {
            let what = format!("no number is from {} to {}", bounds.0, bounds.1);
            let fault = Fault::error(place.to(cursor.before()), what, "these bounds");
            return Err(fault.help("swap them"));
        }
    }
    Ok(match kind.as_str() {
        "areg" => Operand::Areg,
        "target" => Operand::Target,
        "source" => Operand::Source,
        "dreg" => Operand::Dreg,
        "bit" => Operand::Bit,
        "dir" => Operand::Direction,
        "dirs" => Operand::Directions,
        "lsb" => Operand::Number(bounds.0, bounds.1),
        "int" => Operand::Integer(bounds.0, bounds.1),
        "word" => Operand::Word,
        _ => {
            return Err(
                Fault::error(place, format!("unknown kind `{kind}`"), "this kind").help(KINDS),
            );
        }
    })
}

fn number(cursor: &mut Cursor<'_>) -> Result<f64, Fault> {
    let negative = cursor.take("-");
    if let Some(&Token {
        kind: TokenKind::Number(value),
        ..
    }) = cursor.peek()
    {
        cursor.advance();
        return Ok(if negative { -value } else { value });
    }
    Err(cursor.unexpected("a number", "counts and bounds are written as `least..most`"))
}

impl fmt::Display for Signature {
    /// As a person would call it: `OR(d, s, s[, s[, s]])`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}(", self.name)?;
        for (i, parameter) in self.parameters.iter().enumerate() {
            let comma = if i == 0 { "" } else { ", " };
            let Parameter { name, count, .. } = parameter;
            match parameter.operand {
                Operand::Literal(value) => write!(f, "{comma}{value}")?,
                _ if parameter.group => write!(f, "{comma}{{{name}, …}}")?,
                _ if parameter.default.is_some() => write!(f, "[{comma}{name}]")?,
                _ => {
                    for n in 0..count.0 {
                        let comma = if i + n == 0 { "" } else { ", " };
                        write!(f, "{comma}{name}")?;
                    }
                    if count.1 > count.0 {
                        let more = count.1 - count.0;
                        let comma = if i + count.0 == 0 { "" } else { ", " };
                        write!(f, "[{comma}up to {more} {name}]")?;
                    }
                }
            }
        }
        f.write_str(")")
    }
}
