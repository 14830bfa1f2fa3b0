//! Texts: pointers to characters, arrays of characters that end with a 0, and what the language's
//! library does with them.

use crate::{
    config::Place,
    program::vendor::{
        interpreter::{machine::Machine, value::Value},
        syntax::tree::{Expr, ExprNode, Kind, Width},
    },
};

impl Machine<'_> {
    /// The characters of a text, or of an array of them up to its 0.
    fn text_of(&self, value: &Value) -> Option<String> {
        let (slot, path) = match value {
            Value::Text(text) => return Some(text.to_string()),
            Value::Pointer(slot, path, _) => self.pointed(*slot, path.clone()),
            _ => return None,
        };
        if !matches!(self.kind_at(slot, &path), Kind::Bits(8, _)) {
            return None;
        }
        let (array, first, length) = self.array_of(slot, &path)?;
        let mut bytes = Vec::new();
        for at in first..length {
            let code = self.at(slot, &[array, &[at]].concat()).whole()? as u8;
            if code == 0 {
                return String::from_utf8(bytes).ok();
            }
            bytes.push(code);
        }
        None
    }

    /// An array of characters as the text that it holds; anything else as it is.
    pub(in crate::program::vendor) fn as_text(&self, value: &Value) -> Value {
        let text = self.text_of(value);
        text.map_or_else(|| value.clone(), |it| Value::Text(it.into()))
    }

    /// Writes characters to where a pointer leads, and tells where they have no room; nothing where
    /// it is not known where that is.
    fn spell(&mut self, name: &str, to: &Value, bytes: &[u8], place: Place) -> Option<()> {
        let Value::Pointer(slot, path, _) = to else {
            return None;
        };
        let (slot, path) = self.pointed(*slot, path.clone());
        let (array, first, length) = self.array_of(slot, &path)?;
        let (array, room) = (array.to_vec(), length.saturating_sub(first));
        if bytes.len() > room {
            let wants = crate::unit::counted(bytes.len(), "character");
            self.error(
                place,
                format!(
                    "`{name}` writes {wants} with the terminating 0, but the buffer has room for {room}"
                ),
                "this call",
                "give it a larger array, or write less",
            );
            return Some(());
        }
        for (at, byte) in bytes.iter().enumerate() {
            let path = [&array[..], &[first + at]].concat();
            let kind = self.kind_at(slot, &path);
            self.put(slot, &path, Value::Whole(i64::from(*byte)).converted(kind));
        }
        Some(())
    }

    /// A function of the language's library that reads or writes texts, or looks at characters or
    /// bits; nothing where it is another, or not all that it is given is known.
    pub(super) fn of_text(&mut self, name: &str, given: &[Value], place: Place) -> Option<Value> {
        let number = |at: usize| given.get(at).and_then(Value::whole);
        let size = |at: usize| number(at).and_then(|it| usize::try_from(it).ok());
        let text = |it: &Self, at: usize| it.text_of(given.get(at)?);
        let ended = |text: &str| [text.as_bytes(), &[0]].concat();
        Some(match name {
            "strlen" => Value::size_t(text(self, 0)?.len() as i64),
            "strcmp" => compared(&text(self, 0)?, &text(self, 1)?),
            "strncmp" => {
                let (a, b, length) = (text(self, 0)?, text(self, 1)?, size(2)?);
                let cut = |it: &str| it.bytes().take(length).collect::<Vec<u8>>();
                Value::Whole(cut(&a).cmp(&cut(&b)) as i64)
            }
            "strchr" => {
                let (text, code) = (text(self, 0)?, u8::try_from(number(1)?).ok()?);
                if code == 0 {
                    return None;
                }
                match (text.bytes().position(|it| it == code), &given[0]) {
                    (None, _) => Value::Whole(0),
                    (Some(at), Value::Text(_)) => Value::Text(text[at..].into()),
                    (Some(at), array) => {
                        Value::binary("+", array, &Value::Whole(at as i64)).ok()?
                    }
                }
            }
            "strcpy" => {
                let from = text(self, 1)?;
                self.spell(name, &given[0], &ended(&from), place)?;
                given[0].clone()
            }
            "strncpy" => {
                let (from, length) = (text(self, 1)?, size(2)?);
                let zeros = std::iter::repeat_n(0, length.saturating_sub(from.len()).min(1 << 16));
                let bytes: Vec<u8> = from.bytes().chain(zeros).take(length).collect();
                self.spell(name, &given[0], &bytes, place)?;
                given[0].clone()
            }
            "strcat" | "strncat" => {
                let (before, more) = (text(self, 0)?, text(self, 1)?);
                let length = if name == "strcat" {
                    more.len()
                } else {
                    size(2)?
                };
                let bytes = before.bytes().chain(more.bytes().take(length));
                let bytes: Vec<u8> = bytes.chain([0]).collect();
                self.spell(name, &given[0], &bytes, place)?;
                given[0].clone()
            }
            "sprintf" => {
                let made = self.formatted(given.get(1..)?, place)?;
                self.spell(name, &given[0], &ended(&made), place)?;
                Value::Whole(made.len() as i64)
            }
            "snprintf" => {
                let (made, room) = (self.formatted(given.get(2..)?, place)?, size(1)?);
                let mut bytes = ended(&made);
                if room < bytes.len() {
                    bytes.truncate(room);
                    *bytes.last_mut()? = 0;
                }
                self.spell(name, &given[0], &bytes, place)?;
                Value::Whole(made.len() as i64)
            }
            "atoi" | "stoi" => {
                let text = text(self, 0)?;
                let text = text.trim_start();
                let digits = |it: char| it.is_ascii_digit();
                let end = { text.char_indices() }
                    .find(|(at, it)| !(digits(*it) || *at == 0 && matches!(it, '-' | '+')));
                let end = end.map_or(text.len(), |it| it.0);
                Value::Whole(text[..end].parse::<i32>().unwrap_or(0).into())
            }
            "atof" => Value::Real(text(self, 0)?.trim().parse().ok()?),
            "stof" => Value::Single(text(self, 0)?.trim().parse().ok()?),
            _ => return characters(name, number(0)?),
        })
    }
}

/// What a function makes of a character, or of the bits of a number.
fn characters(name: &str, number: i64) -> Option<Value> {
    let letter = u8::try_from(number).ok();
    let is = |holds: fn(&u8) -> bool| Some(Value::flag(letter.as_ref().is_some_and(holds)));
    let (low, bits) = (number as u32, number as u64);
    let counts = |it: u32, of: bool| of.then_some(Value::Whole(it.into()));
    match name {
        "tolower" => Some(Value::Whole(letter?.to_ascii_lowercase().into())),
        "toupper" => Some(Value::Whole(letter?.to_ascii_uppercase().into())),
        "isdigit" => is(u8::is_ascii_digit),
        "isalpha" => is(u8::is_ascii_alphabetic),
        "isspace" => is(u8::is_ascii_whitespace),
        "__builtin_popcount" => counts(low.count_ones(), true),
        "__builtin_popcountl" | "__builtin_popcountll" => counts(bits.count_ones(), true),
        // Of 0 they have no value.
        "__builtin_ctz" => counts(low.trailing_zeros(), low != 0),
        "__builtin_ctzll" => counts(bits.trailing_zeros(), bits != 0),
        "__builtin_clz" => counts(low.leading_zeros(), low != 0),
        "__builtin_clzll" => counts(bits.leading_zeros(), bits != 0),
        _ => None,
    }
}

fn compared(a: &str, b: &str) -> Value {
    Value::Whole(a.as_bytes().cmp(b.as_bytes()) as i64)
}

/// The text of one character; anything else as it is.
pub(super) fn character(value: &Value) -> Value {
    let code = value.whole().and_then(|it| u8::try_from(it).ok());
    match code.filter(u8::is_ascii) {
        Some(code) => Value::Text(char::from(code).to_string().into()),
        None => value.clone(),
    }
}

impl Machine<'_> {
    /// Texts of the language's library under an operator, with what they are joined to or compared
    /// with as texts: characters, and arrays of them. Behind a pointer, numbers lead further.
    pub(in crate::program::vendor) fn joined(
        &self,
        operator: &str,
        (a, left): (Value, &Expr),
        (b, right): (Value, &Expr),
    ) -> (Value, Value) {
        const COMPARES: [&str; 6] = ["==", "!=", "<", ">", "<=", ">="];
        let adds = |text: &Expr, code: &Expr| {
            let is_string = self.gives_string(text);
            operator == "+"
                && (is_string == Some(true)
                    || is_string.is_none() && self.kind_of(code) == Kind::CHARACTER)
        };
        match (&a, &b) {
            (Value::Text(_), Value::Whole(_)) if adds(left, right) => {
                let b = character(&b);
                (a, b)
            }
            (Value::Whole(_), Value::Text(_)) if adds(right, left) => (character(&a), b),
            (Value::Text(_), Value::Pointer(..)) | (Value::Pointer(..), Value::Text(_))
                if (operator == "+" || COMPARES.contains(&operator))
                    && [left, right]
                        .iter()
                        .any(|it| self.gives_string(it) != Some(false)) =>
            {
                (self.string_of(a), self.string_of(b))
            }
            _ => (a, b),
        }
    }

    /// `std::numeric_limits<type>::max()` and its kin.
    pub(in crate::program::vendor) fn limit(&self, name: &Expr, of: &Expr) -> Value {
        let kind = self.kind_of(of);
        let ExprNode::Text(name) = &name.node else {
            return Value::Whole(0);
        };
        let found = match (kind, &**name) {
            (Kind::Any | Kind::Analog | Kind::Digital | Kind::Parameter(_), _) => None,
            (_, "is_signed") => Some(Value::flag(!matches!(
                kind,
                Kind::Flag | Kind::Bits(_, false)
            ))),
            (_, "is_integer") => Some(Value::flag(!matches!(kind, Kind::Float | Kind::Real))),
            (Kind::Flag, "max") => Some(Value::Whole(1)),
            (Kind::Flag | Kind::Bits(_, false), "min" | "lowest") => Some(Value::Whole(0)),
            (Kind::Bits(64, true), "max") => Some(Value::Wide(i64::MAX, Width::Long)),
            (Kind::Bits(64, true), "min" | "lowest") => Some(Value::Wide(i64::MIN, Width::Long)),
            (Kind::Bits(bits, true), "max") => Some(Value::Whole((1 << (bits - 1)) - 1)),
            (Kind::Bits(bits, true), "min" | "lowest") => Some(Value::Whole(-(1 << (bits - 1)))),
            (Kind::Bits(_, false), "max") => Some(Value::size_t(-1)),
            (Kind::Bits(bits, signed), "digits") => {
                Some(Value::Whole(i64::from(bits) - i64::from(signed)))
            }
            (Kind::Float, "max") => Some(Value::Single(f32::MAX)),
            (Kind::Float, "min") => Some(Value::Single(f32::MIN_POSITIVE)),
            (Kind::Float, "lowest") => Some(Value::Single(f32::MIN)),
            (Kind::Float, "epsilon") => Some(Value::Single(f32::EPSILON)),
            (Kind::Float, "infinity") => Some(Value::Single(f32::INFINITY)),
            (Kind::Float, "quiet_NaN") => Some(Value::Single(f32::NAN)),
            (Kind::Real, "max") => Some(Value::Real(f64::MAX)),
            (Kind::Real, "min") => Some(Value::Real(f64::MIN_POSITIVE)),
            (Kind::Real, "lowest") => Some(Value::Real(f64::MIN)),
            (Kind::Real, "epsilon") => Some(Value::Real(f64::EPSILON)),
            (Kind::Real, "infinity") => Some(Value::Real(f64::INFINITY)),
            (Kind::Real, "quiet_NaN") => Some(Value::Real(f64::NAN)),
            _ => None,
        };
        match found {
            Some(value) if matches!(&**name, "is_signed" | "is_integer" | "digits") => value,
            Some(value) => value.converted(kind),
            None => Value::Unknown(format!("`numeric_limits` with `{name}`").into()),
        }
    }
}
