//! The scratch registers that a macro destroys.

use crate::{
    isa::{
        Callable, Device, PrimitiveKind,
        signature::Mode,
        text::{Argument, Expression, Term},
    },
    order::Order,
};

use super::{
    calls::{may_mean, statements},
    definition::Macro,
};

impl Macro {
    /// Names of the registers besides its parameters that its body writes.
    #[must_use]
    pub fn scratch(&self, device: &Device) -> Vec<String> {
        let mut names = Vec::new();
        self.collect_scratch(device, &mut names, &mut Vec::new());
        names.order_by(Ord::cmp);
        names.dedup();
        names
    }

    /// Collects them through all calls, each macro once however often it is called.
    fn collect_scratch<'d>(
        &'d self,
        device: &'d Device,
        names: &mut Vec<String>,
        seen: &mut Vec<&'d Self>,
    ) {
        if seen.iter().any(|known| std::ptr::eq(*known, self)) {
            return;
        }
        seen.push(self);
        let roles = device.registers().roles;
        let mut calls = Vec::new();
        statements(&self.body, &mut calls);
        let own = |name: &str| self.signature.parameters.iter().any(|p| p.name == name);
        for call in calls {
            for callable in device.callables(&call.name) {
                let signature = callable.signature();
                match callable {
                    Callable::Macro(next) if !may_mean(call, next) => continue,
                    Callable::Macro(next) => next.collect_scratch(device, names, seen),
                    Callable::Primitive(PrimitiveKind::Square, _) => {
                        names.push(device.analog_name(device.news()));
                    }
                    Callable::Primitive(PrimitiveKind::Prop, _) => {
                        names.push(device.digital_name(roles.propagated));
                    }
                    _ => {}
                }
                for (i, argument) in call.arguments.iter().enumerate() {
                    if signature.at(i).is_none_or(|p| p.mode == Mode::In) {
                        continue;
                    }
                    let Argument::One(Expression { term, .. }) = argument else {
                        continue;
                    };
                    match term {
                        Term::Name(name) if !own(name) => names.push(name.clone()),
                        Term::Of { base, .. } if base == "X" => {
                            names.push(device.analog_name(device.news()));
                        }
                        Term::Of { .. } => {
                            names.extend(roles.enable.map(|r| device.digital_name(r)));
                        }
                        _ => {}
                    }
                }
            }
        }
    }
}
