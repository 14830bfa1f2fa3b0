//! What a chip is, in one text: all that a result can depend on.

use std::fmt::{self, Write as _};

use super::{Device, Figure, Interval, Quantity, Signature, macros::Item, signature::Parameter};

impl Device {
    /// All on which a result can depend, as text. What the chip is called, where its files are, and
    /// what is said beside its numbers and its macros are no part of it.
    #[must_use]
    pub fn substance(&self) -> String {
        let mut text = String::new();
        line(&mut text, format_args!("{:?}", self.registers));
        for figure in Figure::ALL {
            let number = quantity(self.figure(*figure));
            line(&mut text, format_args!("{figure:?} {number}"));
        }
        for row in self.primitives() {
            let (cost, clock) = (quantity(&row.cost), row.clock);
            line(&mut text, format_args!("{:?} {cost} {clock:?}", row.kind));
            signatures(&mut text, &row.forms);
        }
        for row in self.hosts() {
            let (call, item) = (quantity(&row.call), row.item.as_ref().map(quantity));
            line(&mut text, format_args!("{:?} {call} {item:?}", row.kind));
            signatures(&mut text, &row.forms);
        }
        for it in self.macros() {
            signatures(&mut text, std::slice::from_ref(&it.signature));
            let (host, gives, flag) = (it.host, &it.gives, it.whole_flag);
            line(&mut text, format_args!("{host} {gives:?} {flag}"));
            for two in &it.distinct {
                line(&mut text, format_args!("{} {}", two.first, two.second));
            }
            items(&mut text, &it.body);
        }
        text
    }
}

fn line(text: &mut String, it: fmt::Arguments<'_>) {
    let _ = writeln!(text, "{it}");
}

fn quantity(it: &Quantity) -> String {
    let Quantity {
        value,
        unit,
        evidence,
        interval,
        ..
    } = it;
    let of = |it: &Interval| format!(" {} {} {:?}", it.low, it.high, it.evidence);
    let interval = interval.as_ref().map_or_else(String::new, of);
    format!("{value} {unit} {evidence:?}{interval}")
}

fn signatures(text: &mut String, forms: &[Signature]) {
    for form in forms {
        line(text, format_args!("{}", form.name));
        for parameter in &form.parameters {
            let Parameter {
                name,
                mode,
                operand,
                count,
                group,
                default,
            } = parameter;
            let default = default.as_ref().map(ToString::to_string);
            line(
                text,
                format_args!("{name} {mode:?} {operand:?} {count:?} {group} {default:?}"),
            );
        }
    }
}

fn items(text: &mut String, body: &[Item]) {
    for item in body {
        match item {
            Item::Statement(statement) => line(text, format_args!("{statement}")),
            Item::Repeat { times, body } => {
                line(text, format_args!("repeat {times} {{"));
                items(text, body);
                line(text, format_args!("}}"));
            }
        }
    }
}
