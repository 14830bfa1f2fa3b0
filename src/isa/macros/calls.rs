//! Which statements a macro consists of, and which macros they may call.

use crate::isa::{
    Device, Signature,
    signature::{Mode, Operand, Parameter},
    text::{Argument, Expression, Statement, Term},
};

use super::definition::{Item, Macro};

/// Whether a call can mean this macro, as far as number and literals of its arguments tell.
pub(super) fn may_mean(call: &Statement, it: &Macro) -> bool {
    let parameters = &it.signature.parameters;
    let least = parameters.iter().filter(|p| p.default.is_none()).count();
    it.signature.name == call.name
        && (least..=parameters.len()).contains(&call.arguments.len())
        && fits_literals(call, &it.signature)
}

/// Whether no number of a call is another than the form has in its place.
pub(super) fn fits_literals(call: &Statement, form: &Signature) -> bool {
    let other = |(argument, parameter): (&Argument, &Parameter)| {
        let Operand::Literal(want) = parameter.operand else {
            return false;
        };
        matches!(argument, Argument::One(Expression { term: Term::Number(n), .. }) if *n != want)
    };
    !call.arguments.iter().zip(&form.parameters).any(other)
}

/// Whether a call may change the parameter of this name: whether it stands where any form of the
/// statement writes.
pub(super) fn may_write(device: &Device, call: &Statement, name: &str) -> bool {
    let callables = device.callables(&call.name);
    let writes = |at: usize| {
        let mut parameters = callables.iter().filter_map(|it| it.signature().at(at));
        parameters.any(|it| it.mode != Mode::In)
    };
    let is_named = |it: &Expression| matches!(&it.term, Term::Name(own) if own == name);
    { call.arguments.iter().enumerate() }
        .any(|(at, argument)| argument.items().iter().any(is_named) && writes(at))
}

pub(super) fn statements<'a>(body: &'a [Item], found: &mut Vec<&'a Statement>) {
    for item in body {
        match item {
            Item::Statement(statement) => found.push(statement),
            Item::Repeat { body, .. } => statements(body, found),
        }
    }
}
