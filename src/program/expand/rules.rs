//! Rules of the chip: operands that it does not allow, and warnings about values that are lost.

use super::{Lowering, Sink, cell, named};
use crate::config::Fault;
use crate::isa::{
    Callable, Cell, Digital, Macro, Operand, Primitive,
    operands::{Access, Unit},
    signature::{Bound, Mode},
    text::Statement,
};

impl<'d> Lowering<'d> {
    pub(super) fn reject_aliases(
        &self,
        (statement, it): (&Statement, &Macro),
        bound: &[Bound],
        sink: &Sink,
        outer: Option<&Macro>,
    ) -> Result<(), Fault> {
        let value = |name: &str| {
            let at = it
                .signature
                .parameters
                .iter()
                .position(|p| p.name == name)?;
            bound.get(at)?.first()
        };
        for distinct in &it.distinct {
            let (first, second) = (value(&distinct.first), value(&distinct.second));
            let (Some(first), Some(second)) = (first, second) else {
                continue;
            };
            if first == second {
                let name = cell(first).map_or_else(
                    || "the same source".to_owned(),
                    |cell| cell.name(self.device),
                );
                let what = format!(
                    "`{}` cannot have {name} as both {} and {}",
                    it.signature.name, distinct.first, distinct.second
                );
                let (what, help) = match outer {
                    None => (
                        what,
                        format!(
                            "use another register for one of them, or copy it first; it is written {}",
                            it.signature
                        ),
                    ),
                    Some(outer) => (
                        format!("{} says `{statement}`: {what}", named(outer)),
                        format!(
                            "give `{}` other registers; it is written {}",
                            outer.signature.name, outer.signature
                        ),
                    ),
                };
                let fault = Fault::error(sink.place, what, distinct.reason.clone());
                return Err(fault.help(help));
            }
        }
        Ok(())
    }

    /// A register that is selected twice on a bus is one connection.
    pub(super) fn reject_twice(
        &self,
        word: &Primitive,
        statement: &Statement,
        sink: &Sink,
        outer: Option<&Macro>,
    ) -> Result<(), Fault> {
        let operands = self.device.operands(word);
        let Some(access) = operands.twice() else {
            return Ok(());
        };
        let register = access.name(self.device);
        let word = word.text(self.device);
        let (message, help) = match outer {
            None => (
                format!("{register} is twice on one bus"),
                format!(
                    "`{}` needs registers that differ; copy one first: `mov(y, {register});`",
                    statement.name
                ),
            ),
            Some(outer) => (
                format!(
                    "{register} is twice on one bus: {} makes this `{word}`",
                    named(outer)
                ),
                format!("use another register; `{register}` may be scratch of the macro itself"),
            ),
        };
        Err(Fault::error(
            sink.place,
            message,
            "a register twice on a bus is one connection",
        )
        .help(help))
    }

    /// Warns of a word that reads and writes the same one-bit register.
    pub(super) fn warn_in_place(&mut self, word: &Primitive, sink: &Sink) {
        let operands = self.device.operands(word);
        // The networks over neighbours copy the register themselves.
        if operands.unit != Unit::Logic {
            return;
        }
        // The two words of the macros that write in place, as `disasm` shows them.
        if self.idle {
            return;
        }
        let mut written = operands.writes().filter_map(Access::digital);
        let read = |target: &Digital| {
            let mut read = operands.reads().filter_map(Access::digital);
            read.any(|register| register == *target)
        };
        let Some(target) = written.find(read) else {
            return;
        };
        let name = self.device.digital_name(target);
        self.faults.push(
            Fault::warning(
                sink.place,
                format!("{name} is read and written in one word"),
                "the chip takes two words for this",
            )
            .help(format!("write it in place: `OR({name}, x);`, `NOR({name}, x);`, `NOT({name});`, `REFRESH({name});`")),
        );
    }

    /// Warns of an operand that the macro also uses as scratch.
    pub(super) fn warn_of_scratch(
        &mut self,
        statement: &Statement,
        callable: Callable<'d>,
        bound: &[Bound],
    ) {
        let Callable::Macro(it) = callable else {
            return;
        };
        // Looked up once for each macro: its heading stands in one place of one file.
        let (device, signature) = (self.device, &it.signature);
        let key = (it.origin.as_str(), signature.place.start);
        let scratch = self.scratch.entry(key).or_insert_with(|| {
            let names = it.scratch(device).into_iter();
            names
                .filter(|name| !it.gives.contains(name))
                .filter_map(|name| cell(&device.value_of(&name)?))
                .collect()
        });
        let roles = device.registers().roles;
        let [spread, mask] = [roles.propagated, roles.mask].map(Cell::Digital);
        let mut warnings = Vec::new();
        for (parameter, values) in it.signature.parameters.iter().zip(bound) {
            let by_default = parameter.mode == Mode::Trash && parameter.default.is_some();
            if by_default
                || !matches!(
                    parameter.operand,
                    Operand::Areg | Operand::Source | Operand::Dreg | Operand::Bit
                )
            {
                continue;
            }
            let mut warn = |name: &str, what: String| {
                let message = format!("`{}` uses {what}", statement.name);
                let label = format!("{name} is its {} here", parameter.name);
                warnings.push(Fault::warning(statement.place, message, label).help(
                    "use another register: the chip would give the result of the sequence of words",
                ));
            };
            for used in values.iter().filter_map(cell) {
                let name = used.name(device);
                // What propagation spreads is written only where its mask is 1.
                if used == spread && parameter.mode != Mode::In && scratch.contains(&mask) {
                    let mask = mask.name(device);
                    let what =
                        format!("{mask} as scratch, and {name} is written only where {mask} is 1");
                    warn(&name, what);
                }
                if scratch.contains(&used) {
                    warn(&name, format!("{name} as scratch itself"));
                }
            }
        }
        self.faults.extend(warnings);
    }
}
