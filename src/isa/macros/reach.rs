//! Whether a macro can be meant: no form that is tried before it takes all that it takes.

use crate::{
    config::Fault,
    isa::{Callable, Device},
};

use super::definition::Macro;

/// The fault of a macro that no statement can mean.
pub(super) fn unreachable(device: &Device, it: &Macro) -> Option<Fault> {
    let forms = device.tried(&it.signature.name);
    let earlier = forms
        .iter()
        .take_while(|form| !matches!(form, Callable::Macro(own) if std::ptr::eq(*own, it)));
    let mut covering = earlier.filter(|form| form.signature().covers(&it.signature));
    let before = covering.next()?;
    let form = before.signature();
    let (what, help) = match before {
        Callable::Primitive(..) => (
            format!("the instruction word `{form}`"),
            "give it another name, or write the word's row in primitives.toml without that form",
        ),
        Callable::Macro(_) => (
            format!("the macro `{form}`"),
            "write it before that one, give it another name, or leave it out",
        ),
        Callable::Host(..) => (
            format!("the host's `{form}`"),
            "give it another name, or leave it out",
        ),
    };
    let what = format!("`{}` is never meant: {what} takes the same", it.signature);
    Some(Fault::error(it.signature.place, what, "this macro").help(help))
}
