//! Assembling a chip from its layers of files.

use std::sync::Arc;

use crate::{
    config::{Fault, Faults},
    isa::{Device, LeftOut, Macro, macros},
    limit::FAULTS,
    order::Order,
};

use super::{
    error::LoadError,
    figures::figures,
    file::Placed,
    layers::Layer,
    registers::registers,
    rows::{all_macros, host_rows, primitive_rows},
};

/// All checks, one after the other; each can rely on those before it. What the layers below say is
/// right for the chip below, so that what is wrong here stands in the last.
pub(super) fn assemble(layers: &[Layer]) -> Result<Device, LoadError> {
    let (top, below) = (&layers[layers.len() - 1], &layers[..layers.len() - 1]);
    let base = if below.is_empty() {
        None
    } else {
        Some(Arc::new(assemble(below)?))
    };
    let figures = figures(layers)?;
    let (registers, left_out) = registers(layers)?;
    let primitives = primitive_rows(layers)?;
    let hosts = host_rows(layers)?;
    let (macros, mut owners) = all_macros(layers)?;
    let mut device = Device {
        name: top.device.name.value.clone(),
        title: top.device.title.clone(),
        registers,
        figures: figures.into(),
        primitives: primitives.into(),
        hosts: hosts.into(),
        macros: macros.into(),
        left_out: left_out.into(),
        base,
    };
    let last = layers.len() - 1;
    check_parameters(
        top,
        { device.macros.iter().zip(&owners) }.filter(|(_, o)| **o != last),
    )?;
    leave_out(&mut device, &mut owners, last);
    let mut faults = Vec::new();
    for (it, _) in { device.macros.iter().zip(&owners) }.filter(|(_, o)| **o == last) {
        faults.extend(macros::check(&device, it));
        if faults.len() > FAULTS {
            break;
        }
    }
    let calls = macros::check_calls(&device).into_iter();
    let circles = calls.filter(|(number, _)| owners[*number] == last);
    faults.extend(circles.map(|(_, fault)| fault));
    top.wrong("macros.scamp", faults)?;
    Ok(device)
}

/// Refuses a name of the last layer that a macro from below has for a parameter: it would hide the
/// register.
fn check_parameters<'a>(
    top: &Layer,
    below: impl Iterator<Item = (&'a Macro, &'a usize)>,
) -> Result<(), Faults> {
    let Some(registers) = &top.device.registers else {
        return Ok(());
    };
    let lists = [&registers.analogue, &registers.digital]
        .into_iter()
        .flatten();
    let aliases = registers.aliases.iter().map(|(alias, _)| alias);
    let names: Vec<&Placed<String>> = { lists.flat_map(|list| &list.value) }
        .chain(aliases)
        .collect();
    let mut faults = Vec::new();
    for (it, _) in below {
        for parameter in &it.signature.parameters {
            for name in names.iter().filter(|name| name.value == parameter.name) {
                let what = format!(
                    "no register can be called `{}`: it is a parameter of `{}`",
                    name.value, it.signature.name
                );
                faults.push(Fault::error(name.place, what, "this name").help(
                    "give it another name: in the text of that macro it would mean the register",
                ));
            }
        }
    }
    // One of its macros tells enough of a name.
    faults.order_by_key(|fault| fault.place.start);
    faults.dedup_by_key(|fault| fault.place.start);
    top.wrong("device.toml", faults)
}

/// The chip so many layers below; none for the chip itself.
fn below(device: &Device, layers: usize) -> Option<&Device> {
    let mut below = device.base();
    for _ in 1..layers {
        below = below?.base();
    }
    below.filter(|_| layers > 0)
}

/// Leaves out the macros from below the `top` layer that need what the chip does not have, and those
/// that call them. What a parameter is where nothing is given has to be given, if it is not there.
fn leave_out(device: &mut Device, owners: &mut Vec<usize>, top: usize) {
    let mut macros = Vec::clone(&device.macros);
    for (it, _) in { macros.iter_mut().zip(&*owners) }.filter(|(_, owner)| **owner != top) {
        macros::without_defaults(device, it);
    }
    device.macros = macros.into();
    loop {
        let lacks: Vec<Option<String>> = { device.macros.iter().zip(&*owners) }
            .map(|(it, owner)| {
                let home = below(device, top - *owner)?;
                macros::lacks(device, home, it)
            })
            .collect();
        if lacks.iter().all(Option::is_none) {
            return;
        }
        let all = Arc::unwrap_or_clone(std::mem::take(&mut device.macros));
        let before = std::mem::take(owners).into_iter();
        let (macros, left_out) = (
            Arc::make_mut(&mut device.macros),
            Arc::make_mut(&mut device.left_out),
        );
        for ((it, owner), lacks) in all.into_iter().zip(before).zip(lacks) {
            if let Some(lacks) = lacks {
                left_out.push(LeftOut {
                    name: it.signature.name.clone(),
                    lacks,
                    it: Some(it),
                });
            } else {
                macros.push(it);
                owners.push(owner);
            }
        }
    }
}
