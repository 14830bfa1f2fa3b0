//! A call of each statement with operands that differ: what pages and pictures of a chip show.

use super::{CellEffect, Expansion, Overrides, Program};
use crate::isa::{Callable, Cell, Device, Operand, Signature, signature::Parameter};

/// A call of a statement.
#[derive(Clone, Debug)]
pub struct Sample<'a> {
    /// The form that is called.
    pub form: &'a Signature,
    /// The form's name, with a number behind it where an earlier one has the same letters: a file's
    /// name of its own, also where `MOV` and `mov` are one file.
    pub name: String,
    /// The call, as it is written.
    pub call: String,
    /// What the call becomes.
    pub expansion: Expansion,
}

/// A call of every form of a chip's words and macros that writes a register; numbers are what
/// comes nearest to 1.
#[must_use]
pub fn samples(device: &Device) -> Vec<Sample<'_>> {
    let mut all: Vec<Sample<'_>> = Vec::new();
    for callable in device.all_callables() {
        if matches!(callable, Callable::Host(..)) {
            continue;
        }
        let form = callable.signature();
        let Some((_, call, expansion)) = sample(form, device, &nearest_to_one(form)) else {
            continue;
        };
        if CellEffect::of(&expansion.code.frame, device)
            .writes
            .is_empty()
        {
            continue;
        }
        let alike = |it: &&Sample<'_>| it.form.name.eq_ignore_ascii_case(&form.name);
        let earlier = all.iter().filter(alike).count();
        let name = match earlier {
            0 => form.name.clone(),
            n => format!("{}-{}", form.name, n + 1),
        };
        all.push(Sample {
            form,
            name,
            call,
            expansion,
        });
    }
    all
}

/// For each whole number of a form, 1 or what comes nearest to it.
pub(super) fn nearest_to_one(form: &Signature) -> Vec<f64> {
    let parameters = form.parameters.iter();
    parameters
        .filter_map(|p| match p.operand {
            Operand::Integer(low, high) => Some(1.0f64.clamp(low, high)),
            _ => None,
        })
        .collect()
}

/// A call of a form with operands that differ and these numbers: its arguments, its text, and
/// what it becomes.
pub(super) fn sample(
    form: &Signature,
    device: &Device,
    numbers: &[f64],
) -> Option<(Vec<String>, String, Expansion)> {
    let registers = device.registers();
    let news = device.analog_name(registers.news);
    let mut analog = registers.analog.iter().filter(|name| **name != news);
    let roles = registers.roles;
    let used = [roles.mask, roles.propagated]
        .into_iter()
        .chain(roles.enable);
    let used: Vec<String> = used.map(|d| device.digital_name(d)).collect();
    let mut digital = registers.digital.iter().filter(|name| !used.contains(name));
    let mut numbers = numbers.iter();
    let mut arguments = Vec::new();
    let mut shown = Vec::new();
    for parameter in &form.parameters {
        let mut one = || {
            Some(match parameter.operand {
                Operand::Areg | Operand::Source | Operand::Target => analog.next()?.clone(),
                Operand::Dreg | Operand::Bit => digital.next()?.clone(),
                Operand::Direction | Operand::Directions => "east".to_owned(),
                Operand::Integer(..) => numbers.next()?.to_string(),
                Operand::Number(low, _) => 0.0f64.max(low).to_string(),
                Operand::Literal(value) => value.to_string(),
                Operand::Word => "buffer".to_owned(),
            })
        };
        let given: Option<Vec<String>> = (0..parameter.count.0.max(1)).map(|_| one()).collect();
        let given = given?;
        shown.push(written(parameter, &given));
        arguments.extend(given);
    }
    let call = format!("{}({})", form.name, shown.join(", "));
    let program = Program::read("reference", &format!("{call};"));
    let expansion = program.expand(device, &Overrides::new()).ok()?;
    Some((arguments, call, expansion))
}

/// The values of a parameter as they stand in a call.
fn written(parameter: &Parameter, values: &[String]) -> String {
    let values = values.join(", ");
    if parameter.group {
        format!("{{{values}}}")
    } else {
        values
    }
}

/// The names of the registers that a form writes besides its results; parameters by their names.
pub(super) fn destroyed(form: &Signature, device: &Device) -> Vec<String> {
    let Some((arguments, _, expansion)) = sample(form, device, &nearest_to_one(form)) else {
        return Vec::new();
    };
    let mut names = Vec::new();
    super::for_each(&expansion.frame, &mut |statement| {
        for cell in statement.destroys() {
            let register = Cell::name(cell, device);
            let at = arguments.iter().position(|argument| *argument == register);
            let parameter = at.and_then(|at| form.parameters.get(at));
            names.push(parameter.map_or(register, |p| p.name.clone()));
        }
    });
    names
}
