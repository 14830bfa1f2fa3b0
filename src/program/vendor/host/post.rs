//! What a host writes for people.

use sprintf::{ConversionSpecifier, ConversionType, NumericParam, Printf};

use crate::{
    config::Place,
    program::vendor::{
        interpreter::{machine::Machine, reason::Reason, value::Value},
        syntax::tree::{Kind, Width},
    },
};

/// Characters that one value is written with, at most: more than any line for people has.
const WIDEST: usize = 4096;

impl Machine<'_> {
    /// `printf(format, …)`, with what is known of its values.
    pub(in crate::program::vendor) fn post(&mut self, values: &[Value], place: Place) {
        if self.companion.is_none() {
            self.unshown.insert(place.start);
        }
        let values: Vec<Value> = values.iter().map(|it| self.as_text(it)).collect();
        let unknown: Option<Reason> = match values.first() {
            Some(Value::Unknown(why)) => Some(why.clone()),
            Some(Value::Pointer(_, _, name)) => Some(format!("the text in `{name}`").into()),
            _ => None,
        };
        if let (Some(why), Some(_)) = (unknown, &self.companion) {
            self.unread(place, "what is posted", &why);
        }
        let (Some(companion), Some((Value::Text(format), values))) =
            (self.companion.as_mut(), values.split_first())
        else {
            return;
        };
        match written(format, values) {
            Some(text) => companion.array.post(text),
            None => self.too_wide(place),
        }
    }

    /// Tells of a format that asks for more characters than are written.
    fn too_wide(&mut self, place: Place) {
        self.error(
            place,
            format!("a width or a precision of more than {WIDEST} characters"),
            "this format",
            "give it a smaller one",
        );
    }

    /// A format with its values, where all of them are known.
    pub(in crate::program::vendor) fn formatted(
        &mut self,
        values: &[Value],
        place: Place,
    ) -> Option<String> {
        let values: Vec<Value> = values.iter().map(|it| self.as_text(it)).collect();
        let (Value::Text(format), values) = values.split_first()? else {
            return None;
        };
        let known = |it: &Value| it.number().is_some() || matches!(it, Value::Text(_));
        if !values.iter().all(known) {
            return None;
        }
        let text = written(format, values);
        if text.is_none() {
            self.too_wide(place);
        }
        text
    }
}

/// A format with its values. One that does not fit them is shown as it stands; nothing where it asks
/// for too many characters.
fn written(format: &str, values: &[Value]) -> Option<String> {
    let (plain, values) = cut(format, values)?;
    let given: Vec<Printed> = values.into_iter().map(Printed).collect();
    let given: Vec<&dyn Printf> = given.iter().map(|it| it as &dyn Printf).collect();
    Some(sprintf::vsprintf(&plain, &given).unwrap_or_else(|_| format.to_owned()))
}

/// Whether a width or a precision asks for too many characters.
fn is_wide(size: &str) -> bool {
    let mut parts = size.split('.');
    parts.any(|it| {
        let digits = it.trim_start_matches(['-', '+', ' ', '#', '0']);
        digits.len() > 9 || digits.parse().is_ok_and(|it: usize| it > WIDEST)
    })
}

/// A format without `*` and lengths, and its values as their lengths have them: `%hhu` has 8 bits.
/// Nothing where it asks for too many characters.
fn cut(format: &str, values: &[Value]) -> Option<(String, Vec<Value>)> {
    let (mut plain, mut given) = (String::new(), Vec::new());
    let mut values = values.iter();
    let mut parts = format.split('%');
    plain.push_str(parts.next().unwrap_or_default());
    while let Some(part) = parts.next() {
        plain.push('%');
        if part.is_empty() {
            // `%%`
            plain.push('%');
            plain.push_str(parts.next().unwrap_or_default());
            continue;
        }
        let numeric = |it: char| it.is_ascii_digit() || "-+ #.*".contains(it);
        let (given_size, rest) = part.split_at(part.find(|it| !numeric(it)).unwrap_or(part.len()));
        let mut size = String::new();
        for it in given_size.chars() {
            match it {
                '*' => {
                    let number = values.next().and_then(Value::whole);
                    size.push_str(&number.map_or_else(String::new, |it| it.to_string()));
                }
                it => size.push(it),
            }
        }
        if is_wide(&size) {
            return None;
        }
        let name = |it: char| !"hlqLjzZt".contains(it);
        let (length, rest) = rest.split_at(rest.find(name).unwrap_or(rest.len()));
        let bits = match length {
            "hh" => 8,
            "h" => 16,
            "" => 32,
            _ => 64,
        };
        let kind = match rest.chars().next() {
            Some('d' | 'i') => Some(Kind::Bits(bits, true)),
            Some('u' | 'o' | 'x' | 'X') => Some(Kind::Bits(bits, false)),
            _ => None,
        };
        let value = values.next().map(|it| match (it, kind) {
            (Value::Whole(_) | Value::Wide(..), Some(kind)) => it.clone().converted(kind),
            _ => it.clone(),
        });
        if let Some((size, text)) = value.as_ref().and_then(|it| at_least(&size, rest, it)) {
            plain.push_str(&size);
            plain.push('s');
            plain.push_str(&rest[1..]);
            given.push(Value::Text(text.into()));
        } else {
            plain.push_str(&size);
            plain.push_str(rest);
            given.extend(value);
        }
    }
    given.extend(values.cloned());
    Some((plain, given))
}

/// A whole number with the digits that `%.3d` asks for at least, and the rest of its format as that
/// of a text; nothing where no precision stands there.
fn at_least(size: &str, rest: &str, value: &Value) -> Option<(String, String)> {
    let (flags, digits) = size.split_once('.')?;
    let least: usize = match digits {
        "" => 0,
        digits => digits.parse().ok()?,
    };
    let (Value::Whole(number) | Value::Wide(number, _)) = value else {
        return None;
    };
    let signed = rest.starts_with(['d', 'i']);
    let size = if signed {
        number.unsigned_abs()
    } else {
        *number as u64
    };
    let written = match rest.chars().next()? {
        'd' | 'i' | 'u' => size.to_string(),
        'o' => format!("{size:o}"),
        'x' => format!("{size:x}"),
        'X' => format!("{size:X}"),
        _ => return None,
    };
    let written = if size == 0 && least == 0 {
        String::new()
    } else {
        written
    };
    let written = format!("{written:0>least$}");
    let before = match rest.chars().next()? {
        'd' | 'i' if *number < 0 => "-",
        'd' | 'i' if flags.contains('+') => "+",
        'd' | 'i' if flags.contains(' ') => " ",
        'x' if flags.contains('#') && size != 0 => "0x",
        'X' if flags.contains('#') && size != 0 => "0X",
        'o' if flags.contains('#') && !written.starts_with('0') => "0",
        _ => "",
    };
    let width = flags.trim_start_matches(['-', '+', ' ', '#', '0']);
    let left = if flags.contains('-') { "-" } else { "" };
    Some((format!("{left}{width}"), format!("{before}{written}")))
}

/// A value as `printf` takes it, whatever its type is; `?` where it is not known.
struct Printed(Value);

impl Printf for Printed {
    fn format(&self, spec: &ConversionSpecifier) -> sprintf::Result<String> {
        Ok(self.printed(spec).unwrap_or_else(|_| "?".to_owned()))
    }

    fn as_int(&self) -> Option<i32> {
        self.0.whole().and_then(|it| it.try_into().ok())
    }
}

/// A real number as C writes it; nothing where the format is of another type.
fn real(number: f64, spec: &ConversionSpecifier) -> Option<String> {
    use ConversionType::{
        CompactFloatLower, CompactFloatUpper, DecFloatLower, DecFloatUpper, SciFloatLower,
        SciFloatUpper,
    };
    let NumericParam::Literal(digits) = spec.precision else {
        return None;
    };
    let (digits, size) = (usize::try_from(digits).unwrap_or(0), number.abs());
    let text = match spec.conversion_type {
        DecFloatLower | DecFloatUpper => format!("{size:.digits$}"),
        SciFloatLower | SciFloatUpper => scientific(size, digits),
        CompactFloatLower | CompactFloatUpper => compact(size, digits.max(1), spec.alt_form),
        _ => return None,
    };
    let text = match spec.conversion_type {
        DecFloatUpper | SciFloatUpper | CompactFloatUpper => text.to_uppercase(),
        _ => text.to_lowercase(),
    };
    let sign = match (number.is_sign_negative(), spec.force_sign, spec.space_sign) {
        (true, ..) if !number.is_nan() => "-",
        (_, true, _) => "+",
        (.., true) => " ",
        _ => "",
    };
    let width = match spec.width {
        NumericParam::Literal(width) => usize::try_from(width).unwrap_or(0),
        NumericParam::FromArgument => 0,
    };
    let rest = width.saturating_sub(sign.len());
    Some(if spec.left_adj {
        format!("{:<width$}", format!("{sign}{text}"))
    } else if spec.zero_pad && number.is_finite() {
        format!("{sign}{text:0>rest$}")
    } else {
        format!("{:>width$}", format!("{sign}{text}"))
    })
}

/// With an exponent of two digits and a sign.
fn scientific(size: f64, digits: usize) -> String {
    let text = format!("{size:.digits$e}");
    match text.split_once('e') {
        Some((value, power)) => {
            let power: i32 = power.parse().unwrap_or(0);
            format!("{value}e{power:+03}")
        }
        None => text,
    }
}

/// `%g`: so many digits that count, without zeros at the end.
fn compact(size: f64, digits: usize, whole: bool) -> String {
    let text = scientific(size, digits - 1);
    let Some((value, power)) = text.split_once('e') else {
        return text;
    };
    let trimmed = |it: &str| {
        if it.contains('.') && !whole {
            it.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            it.to_owned()
        }
    };
    let exponent: i32 = power.parse().unwrap_or(0);
    match usize::try_from(digits as i64 - 1 - i64::from(exponent)) {
        Ok(behind) if exponent >= -4 => trimmed(&format!("{size:.behind$}")),
        _ => format!("{}e{power}", trimmed(value)),
    }
}

impl Printed {
    /// Fails where the value is of another type than the format asks for.
    fn printed(&self, spec: &ConversionSpecifier) -> sprintf::Result<String> {
        match self.0 {
            Value::Whole(number) => {
                let narrow = number as i32;
                let character = || (narrow as u32).format(spec);
                let written = || real(number as f64, spec).ok_or(sprintf::PrintfError::WrongType);
                narrow
                    .format(spec)
                    .or_else(|_| character())
                    .or_else(|_| written())
            }
            Value::Wide(number, Width::Long) if number != i64::MIN => number.format(spec),
            Value::Wide(number, _) => (number as u64).format(spec),
            Value::Real(_) | Value::Single(_) => {
                let number = self.0.number().unwrap_or_default();
                real(number, spec).map_or_else(|| (number as i32).format(spec), Ok)
            }
            Value::Text(ref text) | Value::Symbol(ref text) => (&**text).format(spec),
            _ => Ok("?".to_owned()),
        }
    }
}
