//! Which statements a macro consists of, and which macros they may call.

use crate::isa::{
    signature::Operand,
    text::{Argument, Expression, Statement, Term},
};

use super::definition::{Item, Macro};

/// Whether a call can mean this macro, as far as number and literals of its arguments tell.
pub(super) fn may_mean(call: &Statement, it: &Macro) -> bool {
    let parameters = &it.signature.parameters;
    let least = parameters.iter().filter(|p| p.default.is_none()).count();
    let other = |(argument, parameter): (&Argument, &crate::isa::signature::Parameter)| {
        let Operand::Literal(want) = parameter.operand else {
            return false;
        };
        matches!(argument, Argument::One(Expression { term: Term::Number(n), .. }) if *n != want)
    };
    it.signature.name == call.name
        && (least..=parameters.len()).contains(&call.arguments.len())
        && !call.arguments.iter().zip(parameters).any(other)
}

pub(super) fn statements<'a>(body: &'a [Item], found: &mut Vec<&'a Statement>) {
    for item in body {
        match item {
            Item::Statement(statement) => found.push(statement),
            Item::Repeat { body, .. } => statements(body, found),
        }
    }
}
