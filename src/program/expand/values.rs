//! Evaluation of names and expressions.

use std::collections::BTreeMap;

use super::{
    super::syntax::{Node, Syntax},
    Lowering, Overrides, Scope,
};
use crate::config::{Fault, Place, enough, suggestion, thin};
use crate::isa::{
    Bit, Direction, Source, Value,
    signature::Given,
    text::{Argument, Expression, Term},
};

impl Lowering<'_> {
    /// Sets the constants: those of the settings, then the program's own, each replaced by its
    /// override, if it has one.
    pub(super) fn constants(
        &mut self,
        syntax: &Syntax,
        settings: &BTreeMap<String, f64>,
        overrides: &Overrides,
    ) {
        for (name, value) in settings {
            let value = overrides.get(name).unwrap_or(value);
            self.constants.insert(name.clone(), Value::Number(*value));
        }
        for item in &syntax.items {
            let Node::Const {
                name,
                name_place,
                value,
            } = &item.node
            else {
                continue;
            };
            thin(&mut self.faults);
            if enough(&self.faults) {
                break;
            }
            self.constant(name, *name_place, value, overrides.get(name));
        }
        for (name, value) in overrides {
            self.check_override(name, *value);
        }
    }

    /// Sets a constant that the program states.
    fn constant(&mut self, name: &str, place: Place, value: &Expression, set: Option<&f64>) {
        if self.device.value_of(name).is_some() {
            let message = format!("`{name}` is a name of the chip");
            self.faults
                .push(Fault::error(place, message, "here").help("give the constant another name"));
        }
        if self.constants.contains_key(name) {
            let message = format!("`{name}` is declared twice");
            self.faults
                .push(Fault::error(place, message, "again here").help("keep one of the two"));
            return;
        }
        let value = match set {
            Some(value) => Ok(Value::Number(*value)),
            None => self.known_value(value),
        };
        let value = value.unwrap_or_else(|fault| {
            self.faults.push(fault);
            // So that uses of the constant are no faults of their own.
            Value::Number(0.0)
        });
        self.constants.insert(name.to_owned(), value);
    }

    /// Reports an override that no constant has, or that is not finite.
    fn check_override(&mut self, name: &str, value: f64) {
        let (message, help) = if let (Some(_), false) = (
            self.device.value_of(name),
            self.constants.contains_key(name),
        ) {
            let message =
                format!("`{name}` is a name of the chip, not a constant to set to {value}");
            (message, self.in_place_of(name, value))
        } else if !self.constants.contains_key(name) {
            let known = || self.constants.keys().map(String::as_str);
            let help = suggestion(name, known()).unwrap_or_else(|| {
                let all: Vec<&str> = known().collect();
                if all.is_empty() {
                    "the program declares none; write `const name = value;`".to_owned()
                } else {
                    format!("it declares {}", all.join(", "))
                }
            });
            (format!("there is no constant `{name}` to set"), help)
        } else if !value.is_finite() {
            let message = format!("the constant `{name}` cannot be {value}");
            (message, "give a finite number".to_owned())
        } else {
            return;
        };
        let fault = Fault::error(Place::default(), message, "this program");
        self.faults.push(fault.help(help));
    }

    /// How a name of the chip comes to hold a number that no constant can give it.
    fn in_place_of(&self, name: &str, value: f64) -> String {
        let file = format!("a register takes a file: `exec --set {name}=FILE.npy`");
        match self.device.value_of(name) {
            Some(Value::Source(Source::Register(register))) => {
                let loads = self.takes("scamp5_in", &[name.into(), value.to_string()]);
                // What comes in passes through NEWS.
                match loads.filter(|_| register != self.device.news()) {
                    Some(statement) => format!("{file}; or write `{statement}` in the program"),
                    None => file,
                }
            }
            Some(Value::Bit(Bit::Register(register))) => {
                let roles = &self.device.registers().roles;
                let mask = self.device.digital_name(roles.mask);
                let only = if register == roles.propagated {
                    format!(", which writes it where {mask} is 1")
                } else {
                    String::new()
                };
                let word = match value {
                    0.0 => "CLR",
                    1.0 => "SET",
                    _ => return format!("{file}, of 0 and 1"),
                };
                format!("{file}; or write `{word}({name});` in the program{only}")
            }
            Some(Value::Bit(Bit::Flag)) => format!("{file}, of 0 and 1"),
            Some(Value::Source(Source::Pix)) => {
                "the photodiodes get light from `exec --image SCENE`".to_owned()
            }
            Some(Value::Source(Source::In)) => {
                match self.takes("scamp5_in", &[value.to_string()]) {
                    Some(statement) => format!("the host drives it: write `{statement}`"),
                    None => "the host drives it, with -128 to 127 LSB".to_owned(),
                }
            }
            _ => "it is not a number: name a constant of the program".to_owned(),
        }
    }

    /// The statement with these arguments, where the chip has one.
    fn takes(&self, name: &str, arguments: &[String]) -> Option<String> {
        let given: Vec<Given> = { arguments.iter() }
            .map(|argument| {
                let number = argument.parse().ok().map(Value::Number);
                Given {
                    values: number
                        .or_else(|| self.device.value_of(argument))
                        .into_iter()
                        .collect(),
                    group: false,
                    place: Place::default(),
                }
            })
            .collect();
        let all = self.device.callables(name);
        let takes = all.iter().any(|it| it.signature().bind(&given).is_ok());
        takes.then(|| format!("{name}({});", arguments.join(", ")))
    }

    /// The value of an expression in which every name must mean something.
    fn known_value(&self, expression: &Expression) -> Result<Value, Fault> {
        match self.value(expression, &[])? {
            Value::Word(name) => Err(self.unknown_name(&name, expression.place)),
            value => Ok(value),
        }
    }

    pub(super) fn times(&self, expression: &Expression) -> Result<u32, Fault> {
        let wrong = |found: String| {
            Fault::error(
                expression.place,
                format!("`repeat` takes a whole number of zero or more, not {found}"),
                "this number",
            )
            .help("write `repeat 10 { … }`, or a constant")
        };
        match self.known_value(expression)? {
            Value::Number(n) if n.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&n) => {
                Ok(n as u32)
            }
            Value::Number(n) => Err(wrong(n.to_string())),
            other => Err(wrong(other.describe().to_owned())),
        }
    }

    pub(super) fn given(
        &self,
        arguments: &[Argument],
        scope: Scope<'_>,
    ) -> Result<Vec<Given>, Fault> {
        let mut given = Vec::new();
        for argument in arguments {
            match argument {
                Argument::One(expression) => {
                    for value in self.values(expression, scope)? {
                        given.push(Given {
                            values: vec![value],
                            group: false,
                            place: expression.place,
                        });
                    }
                }
                Argument::Group { items, place } => {
                    let mut values = Vec::new();
                    for item in items {
                        values.extend(self.values(item, scope)?);
                    }
                    given.push(Given {
                        values,
                        group: true,
                        place: *place,
                    });
                }
            }
        }
        Ok(given)
    }

    /// The values of an expression: one, except for `R[dir]`.
    pub(super) fn values(
        &self,
        expression: &Expression,
        scope: Scope<'_>,
    ) -> Result<Vec<Value>, Fault> {
        let Term::Of {
            base,
            opposite,
            direction,
        } = &expression.term
        else {
            return Ok(vec![self.value(expression, scope)?]);
        };
        let directions = match self.name(direction, scope) {
            Value::Directions(directions) => directions,
            other => {
                return Err(Fault::error(
                    expression.place,
                    format!("`{direction}` is {}, not a direction", other.describe()),
                    "here",
                )
                .help("`X[dir]` and `R[dir]` take a direction"));
            }
        };
        let of = |direction: Direction| {
            if *opposite {
                direction.opposite()
            } else {
                direction
            }
        };
        let directions = directions.into_iter().map(of);
        match base.as_str() {
            "X" => Ok(directions
                .map(|d| Value::Source(Source::Neighbour(d)))
                .collect()),
            "R" => {
                let roles = self.device.registers().roles;
                let register = |d| Value::Bit(Bit::Register(roles.enables(d)));
                Ok(directions.map(register).collect())
            }
            _ => Err(Fault::error(
                expression.place,
                format!("`{base}[…]` is not defined"),
                "here",
            )
            .help("`X[dir]` is a neighbour's cell, `R[dir]` the register that enables it")),
        }
    }

    pub(super) fn name(&self, name: &str, scope: Scope<'_>) -> Value {
        if let Some((_, value)) = scope.iter().find(|(parameter, _)| *parameter == name) {
            return value.clone();
        }
        self.device
            .value_of(name)
            .or_else(|| self.constants.get(name).cloned())
            .unwrap_or_else(|| Value::Word(name.to_owned()))
    }

    pub(super) fn value(&self, expression: &Expression, scope: Scope<'_>) -> Result<Value, Fault> {
        let number = |inner: &Expression| -> Result<f64, Fault> {
            match self.value(inner, scope)? {
                Value::Number(value) => Ok(value),
                Value::Word(name) => Err(self.unknown_name(&name, inner.place)),
                other => Err(Fault::error(
                    inner.place,
                    format!("expected a number, found {}", other.describe()),
                    "arithmetic is for numbers",
                )
                .help("registers are added by `add(y, x0, x1);`")),
            }
        };
        let value = match &expression.term {
            Term::Number(value) => *value,
            Term::Name(name) => return Ok(self.name(name, scope)),
            Term::Negate(inner) => -number(inner)?,
            Term::Binary {
                operator,
                left,
                right,
            } => operator.apply(number(left)?, number(right)?),
            Term::Of { .. } => match self.values(expression, scope)?.as_slice() {
                [one] => return Ok(one.clone()),
                _ => {
                    return Err(Fault::error(
                        expression.place,
                        "several registers where one is expected",
                        "here",
                    )
                    .help("`R[dir]` of several directions is for SET and CLR"));
                }
            },
        };
        if !value.is_finite() {
            return Err(Fault::error(
                expression.place,
                format!("this is {value}, not a number"),
                "divided by zero, or too large",
            )
            .help("numbers are finite"));
        }
        // Minus zero is zero: it would be printed and read back as such.
        Ok(Value::Number(value + 0.0))
    }
}
