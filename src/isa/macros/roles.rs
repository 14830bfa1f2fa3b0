//! Registers that the hardware itself uses, as macros name them.

use crate::isa::{
    Device, Digital,
    text::{Argument, Expression, Statement, Term},
};

use super::{calls::statements, definition::Macro};

/// The roles of a one-bit register, as `[registers.roles]` names them.
fn roles(device: &Device, name: &str) -> Vec<&'static str> {
    let of = device.registers().roles;
    let [north, east, south, west] = of.enable;
    let all = [
        ("mask", of.mask),
        ("propagated", of.propagated),
        ("north", north),
        ("east", east),
        ("south", south),
        ("west", west),
    ];
    let own: Option<Digital> = device.value_of(name).and_then(|value| value.digital());
    let own = all
        .into_iter()
        .filter(|(_, register)| Some(*register) == own);
    own.map(|(role, _)| role).collect()
}

/// A register that a macro names for a role which it has on the chip of the macro's file, and not on
/// this one, as a message names it.
pub(super) fn lacks(device: &Device, home: &Device, it: &Macro) -> Option<String> {
    let mut calls: Vec<&Statement> = Vec::new();
    statements(&it.body, &mut calls);
    let arguments = calls.iter().flat_map(|call| &call.arguments);
    let items = arguments.flat_map(Argument::items);
    let names = items.filter_map(|Expression { term, .. }| match term {
        Term::Name(name) => Some(name),
        _ => None,
    });
    let given = it.gives.iter().chain(names);
    let mut lost = given.filter_map(|name| {
        let here = roles(device, name);
        let mut there = roles(home, name).into_iter();
        let role = there.find(|role| !here.contains(role))?;
        Some(format!("`{name}` as `{role}`"))
    });
    lost.next()
}
