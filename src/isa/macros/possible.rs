//! Whether a statement of a macro's body is possible, as far as the registers that it names tell.

use crate::{
    config::Fault,
    isa::{
        Analog, Callable, Cell, Device, Operand, PrimitiveKind, Source, Value,
        operands::Terminal,
        row,
        signature::{Parameter, Signature},
        text::{Argument, Expression, Statement, Term},
    },
};

use super::definition::Macro;

/// Numbers of registers that stand for parameters: no chip has so many.
const STANDS: u8 = 128;

/// What an argument is.
#[derive(Clone, Debug, PartialEq)]
enum Given<'a> {
    /// The same in every call.
    Fixed(Value),
    /// What the parameter of this name is.
    Parameter(&'a str),
    /// Something that depends on a parameter.
    Open,
}

/// The fault of a statement that no call of the macro can make possible; `forms`: those that take
/// so many arguments.
pub(super) fn impossible(
    device: &Device,
    it: &Macro,
    statement: &Statement,
    forms: &[Callable<'_>],
) -> Option<Fault> {
    let mut whys = Vec::new();
    for form in forms {
        whys.push((form, why_not(device, it, statement, form)?));
    }
    let (form, why) = whys.into_iter().next()?;
    let what = format!(
        "no call of `{}` is possible: {}",
        it.signature.name, why.told
    );
    let first = if why.are_same {
        "use another register for one of them, or copy it first; "
    } else {
        ""
    };
    let help = format!("{first}it is written {}", form.signature());
    Some(Fault::error(statement.place, what, "in the body of a macro").help(help))
}

/// Why a statement is not possible.
struct Why {
    told: String,
    /// Whether for two registers that are the same.
    are_same: bool,
}

/// Why a form cannot be meant by a statement, whatever the parameters are.
fn why_not(device: &Device, it: &Macro, statement: &Statement, form: &Callable<'_>) -> Option<Why> {
    let signature = form.signature();
    for (at, argument) in statement.arguments.iter().enumerate() {
        for item in argument.items() {
            let parameter = signature.at(at)?;
            if let Given::Fixed(value) = given(device, it, item)
                && let Err(why) = parameter.operand.accepts(&value)
            {
                let name = &statement.name;
                return Some(Why {
                    told: format!("argument {} of `{name}`: {why}", at + 1),
                    are_same: false,
                });
            }
        }
    }
    let told = match form {
        Callable::Macro(called) => alias(device, it, statement, called),
        Callable::Primitive(kind, form) => twice(device, it, statement, (*kind, form)),
        Callable::Host(..) => None,
    };
    told.map(|told| Why {
        told,
        are_same: true,
    })
}

fn given<'a>(device: &Device, it: &'a Macro, expression: &'a Expression) -> Given<'a> {
    match &expression.term {
        Term::Number(number) => Given::Fixed(Value::Number(*number)),
        Term::Name(name) if it.signature.parameters.iter().any(|p| p.name == *name) => {
            Given::Parameter(name)
        }
        Term::Name(name) => device.value_of(name).map_or(Given::Open, Given::Fixed),
        _ => Given::Open,
    }
}

/// Two parameters of a macro that have to differ, and that a statement gives the same.
fn alias(device: &Device, it: &Macro, statement: &Statement, called: &Macro) -> Option<String> {
    let of = |name: &str| {
        let parameters = &called.signature.parameters;
        let at = parameters.iter().position(|p| p.name == name)?;
        let expression = match statement.arguments.get(at) {
            Some(Argument::One(one)) => given(device, it, one),
            Some(Argument::Group { .. }) => return None,
            // A default is a text of the macro that is called.
            None => given(device, called, parameters[at].default.as_ref()?),
        };
        (expression != Given::Open).then_some(expression)
    };
    called.distinct.iter().find_map(|distinct| {
        let (first, second) = (of(&distinct.first)?, of(&distinct.second)?);
        if first != second {
            return None;
        }
        let register = match first {
            Given::Fixed(Value::Source(source)) => device.source_name(source),
            Given::Fixed(Value::Bit(bit)) => device.bit_name(bit),
            Given::Parameter(name) => name.to_owned(),
            _ => return None,
        };
        Some(format!(
            "`{}` cannot have {register} as both {} and {} ({})",
            statement.name, distinct.first, distinct.second, distinct.reason
        ))
    })
}

/// A register that a word has twice on its bus.
fn twice(
    device: &Device,
    it: &Macro,
    statement: &Statement,
    (kind, form): (PrimitiveKind, &Signature),
) -> Option<String> {
    let bound = bound(device, it, statement, form)?;
    let word = row::build(kind, &form.name, &bound)?;
    let twice = device.operands(&word).twice()?;
    let name = match twice.terminal {
        Terminal::Cell(Cell::Analog(Analog(number))) if number >= STANDS => {
            let own = usize::from(number - STANDS);
            it.signature.parameters.get(own)?.name.clone()
        }
        _ => twice.name(device),
    };
    Some(format!("{name} is twice on the bus of `{}`", form.name))
}

/// The values of an analogue word, with a register for each parameter that no chip has.
fn bound(
    device: &Device,
    it: &Macro,
    statement: &Statement,
    form: &Signature,
) -> Option<Vec<Vec<Value>>> {
    let analogue =
        |p: &Parameter| matches!(p.operand, Operand::Areg | Operand::Target | Operand::Source);
    if !form.parameters.iter().all(analogue) {
        return None;
    }
    let mut bound = vec![Vec::new(); form.parameters.len()];
    for (at, argument) in statement.arguments.iter().enumerate() {
        let slot = bound.len().checked_sub(1)?.min(at);
        for item in argument.items() {
            bound[slot].push(match given(device, it, item) {
                Given::Fixed(value) => value,
                Given::Parameter(name) => {
                    let own = it
                        .signature
                        .parameters
                        .iter()
                        .position(|p| p.name == *name)?;
                    let number = STANDS.checked_add(u8::try_from(own).ok()?)?;
                    Value::Source(Source::Register(Analog(number)))
                }
                Given::Open => return None,
            });
        }
    }
    Some(bound)
}
