//! Overload resolution: which macro or primitive a statement calls.

use super::{Lowering, Scope};
use crate::config::{Fault, Place, suggestion};
use crate::isa::{
    Callable, Device, Operand, Value,
    signature::{Bound, Given, Mismatch, Signature},
    text::{Argument, Statement},
};
use crate::unit::counted;

impl<'d> Lowering<'d> {
    /// What statements there are, for who wrote one that there is not.
    fn statements(&self) -> String {
        const LIBRARY: &str = "scamp5_";
        let all = self.device.all_callables();
        let mut names: Vec<&str> = all.map(|it| it.signature().name.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        names.retain(|name| !name.starts_with(LIBRARY));
        format!(
            "docs/scamp5.md describes each statement; {} has {}, and those of {LIBRARY}…",
            self.device.name(),
            names.join(", ")
        )
    }

    /// What a statement means, and the values of its parameters.
    pub(super) fn call(
        &self,
        statement: &Statement,
        scope: Scope<'_>,
    ) -> Result<(Callable<'d>, Vec<Bound>), Fault> {
        let device: &'d Device = self.device;
        let callables = device.callables(&statement.name);
        if callables.is_empty() {
            if let Some(why) = device.why_no_statement(&statement.name, None) {
                return Err(self.not_here(statement.name_place, why, None));
            }
            let names = self
                .device
                .all_callables()
                .map(|c| c.signature().name.as_str());
            return Err(Fault::error(
                statement.name_place,
                format!("unknown statement `{}`", statement.name),
                "the chip has no such statement",
            )
            .help(suggestion(&statement.name, names).unwrap_or_else(|| self.statements())));
        }
        let given = self.given(&statement.arguments, scope)?;
        let mut furthest = None;
        for callable in &device.tried(&statement.name) {
            match callable.signature().bind(&given) {
                Ok(bound) => {
                    let bound = self.with_defaults(callable.signature(), bound);
                    // What a chip's file says has no place in the program.
                    let bound = bound.map_err(|fault| Fault {
                        place: statement.place,
                        ..fault
                    })?;
                    return Ok((*callable, bound));
                }
                Err(Mismatch::Shape) => {}
                Err(Mismatch::Argument { index, message }) => {
                    // Among forms that fail, the one that fits the most arguments is most likely
                    // the one that was meant.
                    if furthest.as_ref().is_none_or(|(far, _)| index > *far) {
                        furthest = Some((index, message));
                    }
                }
            }
        }
        // A number beyond a bound of this chip is told with the bound.
        let beyond = furthest.as_ref().filter(|(index, _)| {
            let number = given.get(*index).and_then(|it| it.values.first());
            let takes_numbers = |it: &Callable<'_>| {
                let operand = { it.signature().parameters.get(*index) }.map(|it| it.operand);
                matches!(operand, Some(Operand::Number(..) | Operand::Integer(..)))
            };
            number.is_some_and(|it| it.number().is_some()) && callables.iter().any(takes_numbers)
        });
        if let Some((index, message)) = beyond {
            return Err(self.wrong_argument(statement, &given, *index, message));
        }
        if let Some(why) = device.why_no_statement(&statement.name, Some(&given)) {
            return Err(self.not_here(statement.place, why, Some(&callables)));
        }
        match furthest {
            Some((index, message)) => Err(self.wrong_argument(statement, &given, index, &message)),
            None => Err(Self::wrong_shape(statement, &callables)),
        }
    }

    /// What the chip below has, and this one does not; `forms`: what this one has of the name.
    fn not_here(&self, place: Place, why: String, forms: Option<&[Callable<'_>]>) -> Fault {
        let chip = self.device.name();
        let instead = match forms {
            Some(forms) => format!("here it is written {}", written(forms)),
            None => format!("use the statements that {chip} has"),
        };
        let help = format!("{instead}; or run it on another chip (--chip)");
        Fault::error(place, why, format!("not on {chip}")).help(help)
    }

    fn wrong_argument(
        &self,
        statement: &Statement,
        given: &[Given],
        index: usize,
        message: &str,
    ) -> Fault {
        let argument = given.get(index);
        let place = argument.map_or(statement.place, |g| g.place);
        if let Some(Value::Word(name)) = argument.and_then(|g| g.values.first()) {
            let mut fault = self.unknown_name(name, place);
            fault.label = format!("argument {} of `{}`: {message}", index + 1, statement.name);
            return fault;
        }
        let forms = written(&self.device.callables(&statement.name));
        // `where(R5)` is `WHERE(R5)`.
        let other = self.device.all_callables().find(|c| {
            let name = &c.signature().name;
            *name != statement.name
                && name.eq_ignore_ascii_case(&statement.name)
                && c.signature().bind(given).is_ok()
        });
        Fault::error(
            place,
            format!("argument {} of `{}`: {message}", index + 1, statement.name),
            "this argument",
        )
        .help(match other {
            Some(other) => format!("did you mean `{}`?", other.signature().name),
            None => format!("it is written {forms}"),
        })
    }

    fn wrong_shape(statement: &Statement, callables: &[Callable<'_>]) -> Fault {
        let braces = statement
            .arguments
            .iter()
            .any(|a| matches!(a, Argument::Group { .. }));
        let count = statement.arguments.len();
        let message = if braces {
            format!(
                "`{}` does not take these arguments in braces",
                statement.name
            )
        } else {
            format!(
                "`{}` does not take {} like these",
                statement.name,
                counted(count, "argument")
            )
        };
        Fault::error(statement.place, message, "this statement")
            .help(format!("it is written {}", written(callables)))
    }

    pub(super) fn unknown_name(&self, name: &str, place: Place) -> Fault {
        if let Some(why) = self.device.why_no_name(name) {
            return self.not_here(place, why, None);
        }
        let constants = self.constants.keys().map(String::as_str);
        let near = suggestion(name, self.device.names().chain(constants));
        Fault::error(
            place,
            format!("unknown name `{name}`"),
            "not a register, direction or constant",
        )
        .help(
            near.or_else(|| self.on_another_chip(name))
                .unwrap_or_else(|| {
                    let registers = self.device.registers();
                    format!(
                        "registers are {} and {}; constants are declared as `const {name} = …;`",
                        registers.analog.join(" "),
                        registers.digital.join(" ")
                    )
                }),
        )
    }

    /// The shipped chip that knows a name which this one does not.
    fn on_another_chip(&self, name: &str) -> Option<String> {
        let chips = Device::shipped().filter(|chip| *chip != self.device.name());
        let mut having = chips
            .into_iter()
            .filter(|chip| Device::find(chip).is_ok_and(|device| device.value_of(name).is_some()));
        let chip = having.next()?;
        Some(format!("{chip} has it: `--chip {chip}`"))
    }

    fn with_defaults(
        &self,
        signature: &Signature,
        mut bound: Vec<Bound>,
    ) -> Result<Vec<Bound>, Fault> {
        for (values, parameter) in bound.iter_mut().zip(&signature.parameters) {
            if let (true, Some(default)) = (values.is_empty(), &parameter.default) {
                values.push(self.value(&self.device.filled_in(default), &[])?);
            }
        }
        Ok(bound)
    }
}

/// How a statement is written: each of its forms.
fn written(forms: &[Callable<'_>]) -> String {
    let forms: Vec<String> = forms.iter().map(|it| it.signature().to_string()).collect();
    forms.join(" or ")
}
