//! What a what-if chip changes for a program.

use serde_json::json;

use crate::{
    isa::{Device, Figure},
    program::{Cost, Expansion, Overrides, Program},
};

/// What a chip that extends another changes for a program.
pub struct Changes {
    /// The chip that is extended.
    base: String,
    /// What is different about the chip.
    chip: Vec<String>,
    /// What the program costs there: words, time, words kept in the store; or why it does not
    /// run there.
    program: Result<(u64, f64, u64), String>,
    /// What it costs here.
    own: (u64, f64, u64),
}

impl Changes {
    pub fn new(
        program: &Program,
        expansion: &Expansion,
        device: &Device,
        overrides: &Overrides,
    ) -> Option<Self> {
        let base = device.base()?;
        let of = |expansion: &Expansion, device: &Device| {
            let cost = Cost::of(&expansion.code.frame, device);
            (cost.words.0, cost.micros(), expansion.stored(device).0)
        };
        Some(Self {
            base: base.name().to_owned(),
            chip: differences(base, device),
            program: match program.expand(base, overrides) {
                Ok(there) => Ok(of(&there, base)),
                Err(faults) => Err(faults
                    .faults
                    .first()
                    .map_or_else(|| faults.to_string(), ToString::to_string)),
            },
            own: of(expansion, device),
        })
    }

    pub fn lines(&self) -> Vec<String> {
        let mut lines = vec![String::new(), format!("against {}", self.base)];
        lines.extend(self.chip.iter().map(|what| format!("  {what}")));
        lines.push(match &self.program {
            Err(why) => format!("  the program does not run there: {why}"),
            Ok(there) if *there == self.own => {
                "  the program costs the same".to_owned()
            }
            Ok((words, micros, kept)) => format!(
                "  the program's frame: {} instead of {words}, {:.1} us instead of {micros:.1}, {} stored instead of {kept}",
                crate::unit::counted(self.own.0, "word"),
                self.own.1,
                crate::unit::counted(self.own.2, "word")
            ),
        });
        lines
    }

    pub fn json(&self) -> serde_json::Value {
        let cost = |(words, micros, kept): &(u64, f64, u64)| json!({"words": words, "us": micros, "stored_words": kept});
        json!({
            "base": self.base,
            "chip": self.chip,
            "base_cost": self.program.as_ref().ok().map(cost),
            "base_error": self.program.as_ref().err(),
            "cost": cost(&self.own),
        })
    }
}

/// In words, one a line.
fn differences(base: &Device, device: &Device) -> Vec<String> {
    let mut lines = Vec::new();
    let registers = |device: &Device| {
        let registers = device.registers();
        [registers.analog.clone(), registers.digital.clone()]
    };
    for (before, after) in registers(base).iter().zip(&registers(device)) {
        let only = |a: &[String], b: &[String]| {
            let names: Vec<&str> = a
                .iter()
                .filter(|n| !b.contains(n))
                .map(String::as_str)
                .collect();
            names.join(" ")
        };
        let (more, less) = (only(after, before), only(before, after));
        if !more.is_empty() {
            lines.push(format!("more registers: {more}"));
        }
        if !less.is_empty() {
            lines.push(format!("without the registers: {less}"));
        }
    }
    let roles = |device: &Device| {
        let roles = device.registers().roles;
        let bits = [roles.mask, roles.propagated]
            .into_iter()
            .chain(roles.enable);
        let named = ["mask", "propagated", "north", "east", "south", "west"]
            .into_iter()
            .zip(bits);
        let bits = named.map(|(role, bit)| (role, device.digital_name(bit)));
        let news = ("news", device.analog_name(device.news()));
        std::iter::once(news).chain(bits).collect::<Vec<_>>()
    };
    for ((role, before), (_, after)) in roles(base).into_iter().zip(roles(device)) {
        if before != after {
            lines.push(format!("{role}: {after} instead of {before}"));
        }
    }
    for figure in Figure::ALL {
        let (before, after) = (base.value(*figure), device.value(*figure));
        if before != after {
            let (section, key) = figure.key();
            let after = figure.shown(after);
            lines.push(format!("{section}.{key}: {after} instead of {before}"));
        }
    }
    for row in device.primitives() {
        let before = base.row(row.kind);
        if before.words() != row.words() {
            let name = row.forms.first().map_or("", |form| form.name.as_str());
            lines.push(format!(
                "{name}: {} instead of {}",
                crate::unit::counted(row.words(), "word"),
                before.words()
            ));
        }
        if row.forms.is_empty() && !before.forms.is_empty() {
            let name = before.forms.first().map_or("", |form| form.name.as_str());
            lines.push(format!("{name}: is not there"));
        } else if before.forms != row.forms {
            lines.push(format!("{:?}: written in other ways", row.kind));
        }
    }
    for row in device.hosts() {
        let before = base.host(row.kind);
        if before.call != row.call || before.item != row.item {
            let name = row.forms.first().map_or("", |form| form.name.as_str());
            lines.push(format!("{name}: takes another time"));
        }
    }
    for it in device.macros() {
        match base.macros().iter().find(|m| m.replaces(it)) {
            None => lines.push(format!("new macro: {}", it.signature)),
            Some(before) if before.body != it.body => {
                lines.push(format!("another body: {}", it.signature));
            }
            Some(_) => {}
        }
    }
    if lines.is_empty() {
        lines.push("nothing about the chip is different".to_owned());
    }
    lines
}
