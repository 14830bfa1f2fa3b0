//! Assembling a chip from its layers of files.

use std::sync::Arc;

use crate::{
    isa::{Device, macros},
    limit::FAULTS,
};

use super::{
    error::LoadError,
    figures::{figures, registers},
    layers::Layer,
    rows::{all_macros, host_rows, primitive_rows},
};

/// All checks, one after the other; each can rely on those before it.
pub(super) fn assemble(layers: &[Layer]) -> Result<Device, LoadError> {
    let figures = figures(layers)?;
    let registers = registers(layers)?;
    let primitives = primitive_rows(layers)?;
    let hosts = host_rows(layers)?;
    let (macros, mut owners) = all_macros(layers)?;
    let (top, below) = (&layers[layers.len() - 1], &layers[..layers.len() - 1]);
    let base = if below.is_empty() {
        None
    } else {
        Some(Arc::new(assemble(below)?))
    };
    let mut device = Device {
        name: top.device.name.value.clone(),
        title: top.device.title.clone(),
        registers,
        figures,
        primitives,
        hosts,
        macros,
        base,
    };
    leave_out(&mut device, &mut owners, layers.len() - 1);
    let calls = macros::check_calls(&device);
    for (at, layer) in layers.iter().enumerate() {
        let own = device.macros.iter().zip(&owners).filter(|(_, o)| **o == at);
        let mut faults = Vec::new();
        for (it, _) in own {
            faults.extend(macros::check(&device, it));
            if faults.len() > FAULTS {
                break;
            }
        }
        let circles = calls.iter().filter(|(number, _)| owners[*number] == at);
        faults.extend(circles.map(|(_, fault)| fault.clone()));
        layer.wrong("macros.scamp", faults)?;
    }
    Ok(device)
}

/// Leaves out the macros from below the `top` layer that need a register which the chip does not
/// have, and those that call them.
fn leave_out(device: &mut Device, owners: &mut Vec<usize>, top: usize) {
    let own = &device.registers.analog;
    let lacks = |base: &Device| !base.registers.analog.iter().all(|name| own.contains(name));
    if !device.base.as_deref().is_some_and(lacks) {
        return;
    }
    loop {
        let is_whole: Vec<bool> = { device.macros.iter().zip(&*owners) }
            .map(|(it, owner)| *owner == top || macros::check(device, it).is_empty())
            .collect();
        if is_whole.iter().all(|it| *it) {
            return;
        }
        let (mut macros, mut of) = (is_whole.iter(), is_whole.iter());
        device.macros.retain(|_| macros.next() == Some(&true));
        owners.retain(|_| of.next() == Some(&true));
    }
}
