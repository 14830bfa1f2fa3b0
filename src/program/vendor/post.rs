//! What a host writes for people.

use sprintf::{ConversionSpecifier, ConversionType, NumericParam, Printf};

use super::{machine::Machine, tree::Width, value::Value};

impl Machine<'_> {
    /// `printf(format, …)`, with what is known of its values.
    pub(super) fn post(&mut self, values: &[Value]) {
        let (Some(companion), Some((Value::Text(format), values))) =
            (self.companion.as_mut(), values.split_first())
        else {
            return;
        };
        let given: Vec<Printed<'_>> = values.iter().map(Printed).collect();
        let given: Vec<&dyn Printf> = given.iter().map(|it| it as &dyn Printf).collect();
        // A format that does not fit its values is shown as it stands.
        let text = sprintf::vsprintf(format, &given).unwrap_or_else(|_| format.to_string());
        companion.array.post(text);
    }
}

/// A value as `printf` takes it, whatever its type is; `?` where it is not known.
struct Printed<'a>(&'a Value);

impl Printf for Printed<'_> {
    fn format(&self, spec: &ConversionSpecifier) -> sprintf::Result<String> {
        Ok(self.printed(spec).unwrap_or_else(|_| "?".to_owned()))
    }

    fn as_int(&self) -> Option<i32> {
        self.0.whole().and_then(|it| it.try_into().ok())
    }
}

/// What `%f` shows of a number, halves to even as C rounds them: `sprintf` rounds them away from 0.
fn rounded(number: f64, spec: &ConversionSpecifier) -> f64 {
    let fixed = matches!(
        spec.conversion_type,
        ConversionType::DecFloatLower | ConversionType::DecFloatUpper
    );
    match spec.precision {
        NumericParam::Literal(digits @ 0..=300) if fixed => {
            let text = format!("{number:.*}", digits as usize);
            text.parse().unwrap_or(number)
        }
        _ => number,
    }
}

impl Printed<'_> {
    /// Fails where the value is of another type than the format asks for.
    fn printed(&self, spec: &ConversionSpecifier) -> sprintf::Result<String> {
        match *self.0 {
            Value::Whole(number) => {
                let narrow = number as i32;
                let character = || (narrow as u32).format(spec);
                let real = || (number as f64).format(spec);
                narrow
                    .format(spec)
                    .or_else(|_| character())
                    .or_else(|_| real())
            }
            Value::Wide(number, Width::Long) if number != i64::MIN => number.format(spec),
            Value::Wide(number, _) => (number as u64).format(spec),
            Value::Real(_) | Value::Single(_) => {
                let number = self.0.number().unwrap_or_default();
                let whole = || (number as i32).format(spec);
                let text = rounded(number, spec).format(spec).or_else(|_| whole())?;
                // `%g` has no point without a digit behind it.
                Ok(text.replace(".e", "e"))
            }
            Value::Text(ref text) | Value::Symbol(ref text) => (&**text).format(spec),
            _ => Ok("?".to_owned()),
        }
    }
}
