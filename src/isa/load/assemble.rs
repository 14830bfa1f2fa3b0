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
    let (macros, owners) = all_macros(layers)?;
    let (top, below) = (&layers[layers.len() - 1], &layers[..layers.len() - 1]);
    let base = if below.is_empty() {
        None
    } else {
        Some(Arc::new(assemble(below)?))
    };
    let device = Device {
        name: top.device.name.value.clone(),
        title: top.device.title.clone(),
        registers,
        figures,
        primitives,
        hosts,
        macros,
        base,
    };
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
