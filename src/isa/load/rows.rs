//! The rows of primitives, of host operations, and the macros.

use std::{cmp::Reverse, collections::BTreeMap};

use crate::config::{Fault, Faults, Lines, Place};
use crate::limit::FORMS;
use crate::order::Order as _;

use super::{
    super::{
        Analog, Digital, FigureRange, HostKind, HostRow, Macro, Operand, PrimitiveKind,
        PrimitiveRow, Quantity, Signature, Value, macros, row, signature::Parameter,
    },
    figures::wrong,
    file::Placed,
    host_form,
    layers::Layer,
    primitive_form,
};

/// Parses the forms of a row.
pub(super) fn forms(
    list: &[Placed<String>],
    faults: &mut Vec<Fault>,
    fits: impl Fn(&Signature) -> bool,
) -> Vec<Signature> {
    let mut parsed = Vec::new();
    if let Some(form) = list.get(FORMS) {
        let what = format!("{} forms; a row has {FORMS} forms at most", list.len());
        faults.push(Fault::error(form.place, what, "this form").help("leave some out"));
        return parsed;
    }
    for form in list {
        match Signature::parse(&form.value) {
            Ok(signature) if fits(&signature) => parsed.push(signature),
            Ok(signature) => faults.push(
                Fault::error(
                    form.place,
                    format!("the instruction cannot be made from `{signature}`"),
                    "this form",
                )
                .help("keep the parameters of the shipped row"),
            ),
            Err(fault) => faults.push(Fault {
                place: form.place,
                ..fault
            }),
        }
    }
    parsed
}

/// What a host operation costs.
const HOST_COST: (&str, FigureRange) = ("us", FigureRange::NotNegative);

/// Rows of one name in one file: only one of them would count.
fn twice(rows: impl Iterator<Item = (&'static str, Place)>, faults: &mut Vec<Fault>) {
    let mut seen = Vec::new();
    for (name, place) in rows {
        if seen.contains(&name) {
            let what = format!("`{name}` has two rows");
            faults.push(Fault::error(place, what, "the second").help("leave one of them out"));
        }
        seen.push(name);
    }
}

pub(super) fn primitive_rows(layers: &[Layer]) -> Result<Vec<PrimitiveRow>, Faults> {
    let mut rows: BTreeMap<PrimitiveKind, PrimitiveRow> = BTreeMap::new();
    for layer in layers {
        let mut faults = Vec::new();
        let names = { layer.primitives.iter() }.map(|row| (row.kind.value.word(), row.kind.place));
        twice(names, &mut faults);
        for row in &layer.primitives {
            let kind = row.kind.value;
            let own = { row.forms.iter() }.filter_map(|it| {
                let form = Signature::parse(&it.value).ok()?;
                primitive_form::misfit(kind, &form, it.place)
            });
            faults.extend(own);
            let built = PrimitiveRow {
                kind,
                forms: forms(&row.forms, &mut faults, |form| can_be_built(kind, form)),
                equation: row.equation.clone(),
                cost: Quantity {
                    value: row.words as f64,
                    unit: "words".to_owned(),
                    source: row.source.clone(),
                    evidence: row.evidence,
                    note: None,
                    interval: None,
                },
                clock: row.clock,
            };
            rows.insert(kind, built);
        }
        layer.wrong("primitives.toml", faults)?;
    }
    let top = &layers[layers.len() - 1];
    let mut faults = Vec::new();
    for kind in PrimitiveKind::ALL {
        if !rows.contains_key(kind) {
            faults.push(
                Fault::error(
                    top.device.name.place,
                    format!("the primitive {kind:?} has no row"),
                    "this chip",
                )
                .help("write it into primitives.toml, or extend a chip that has it"),
            );
        }
    }
    top.wrong("device.toml", faults)?;
    Ok(rows.into_values().collect())
}

pub(super) fn host_rows(layers: &[Layer]) -> Result<Vec<HostRow>, Faults> {
    let mut rows: BTreeMap<HostKind, HostRow> = BTreeMap::new();
    let mut wide = None;
    for layer in layers {
        if let Some(now) = width(layer) {
            let row = rows.get_mut(&HostKind::ScanDigital);
            let item = row.and_then(|row| row.item.as_mut());
            if let (Some(before), Some(item)) = (wide, item) {
                widen(item, [before, now].map(bytes));
            }
            wide = Some(now);
        }
        let mut faults = Vec::new();
        let names = { layer.device.host.iter() }.map(|row| (row.kind.value.word(), row.kind.place));
        twice(names, &mut faults);
        for row in &layer.device.host {
            let name = row.kind.value.word();
            let costs = [("call", Some(&row.call)), ("item", row.item.as_ref())];
            for (key, cost) in costs {
                let name = format!("{name}.{key}");
                let cost = cost.and_then(|cost| wrong(&name, HOST_COST, cost));
                faults.extend(cost);
            }
            if row.item.is_none() && row.kind.value.is_of_items() {
                let what = format!("`{name}` has no `item`, the time of each slot, sample or row");
                let help = "write item = { value = …, unit = \"us\", source = …, evidence = … } beside `call`; 0 if it costs nothing";
                faults.push(Fault::error(row.kind.place, what, "this operation").help(help));
            }
            if layer.folder.path.is_some() {
                let own = row.forms.iter().filter_map(|it| {
                    let form = Signature::parse(&it.value).ok()?;
                    host_form::misfit(row.kind.value, &form, it.place)
                });
                faults.extend(own);
            }
            let built = HostRow {
                kind: row.kind.value,
                forms: forms(&row.forms, &mut faults, |_| true),
                meaning: row.meaning.clone(),
                call: row.call.value.clone(),
                item: row.item.as_ref().map(|i| i.value.clone()),
            };
            rows.insert(built.kind, built);
        }
        layer.wrong("device.toml", faults)?;
    }
    let top = &layers[layers.len() - 1];
    let mut faults = Vec::new();
    for kind in HostKind::ALL {
        if !rows.contains_key(kind) {
            faults.push(
                Fault::error(
                    top.device.name.place,
                    format!("the host operation {kind:?} has no row"),
                    "this chip",
                )
                .help("write it as [[host]], or extend a chip that has it"),
            );
        }
    }
    top.wrong("device.toml", faults)?;
    Ok(rows.into_values().collect())
}

/// The columns that a layer states.
fn width(layer: &Layer) -> Option<f64> {
    let mut figures = layer.device.figures.iter();
    let own = figures.find(|(section, key, _)| section == "array" && key.value == "width");
    own.map(|(.., stated)| stated.value.value)
}

/// The bytes of so many bits.
fn bytes(bits: f64) -> f64 {
    (bits / 8.0).ceil()
}

/// A row of bits of another array takes as much longer as it has more bytes.
fn widen(item: &mut Quantity, [before, now]: [f64; 2]) {
    if before == now {
        return;
    }
    let times = now / before;
    item.value *= times;
    if let Some(interval) = &mut item.interval {
        interval.low *= times;
        interval.high *= times;
    }
    let now = crate::unit::counted(now as u64, "byte");
    item.source = format!("{}; here {now} a row", item.source);
}

/// The macros of all layers, those of the last layer first, and the layer that each is from; one of
/// the same heading replaces the one before.
pub(super) fn all_macros(layers: &[Layer]) -> Result<(Vec<Macro>, Vec<usize>), Faults> {
    let (mut all, mut owners): (Vec<Macro>, Vec<usize>) = (Vec::new(), Vec::new());
    for (at, layer) in layers.iter().enumerate() {
        let Some(text) = &layer.folder.macros else {
            continue;
        };
        let list = match macros::parse(text) {
            Ok(list) => list,
            Err(faults) => {
                layer.wrong("macros.scamp", faults)?;
                continue;
            }
        };
        let mut faults = Vec::new();
        let lines = Lines::new(text);
        for mut it in list {
            let line = lines.line(it.signature.place.start);
            it.origin = format!("{}/macros.scamp:{line}", layer.folder.name);
            if let Some(old) = all.iter().position(|m| m.replaces(&it)) {
                if owners[old] == at {
                    let what = format!("two macros are `{}`", it.signature);
                    faults.push(
                        Fault::error(it.signature.place, what, "the second")
                            .help("leave one of them out, or let it take something else"),
                    );
                }
                all[old] = it;
                owners[old] = at;
            } else {
                all.push(it);
                owners.push(at);
            }
        }
        layer.wrong("macros.scamp", faults)?;
    }
    // A chip's own forms are tried before those from below.
    let mut both: Vec<(Macro, usize)> = all.into_iter().zip(owners).collect();
    both.order_by_key(|(_, owner)| Reverse(*owner));
    Ok(both.into_iter().unzip())
}

/// Tries a form once, with values that fit.
fn can_be_built(kind: PrimitiveKind, form: &Signature) -> bool {
    let example = |p: &Parameter| vec![example(p.operand); p.count.0.max(1)];
    let bound: Vec<Vec<Value>> = form.parameters.iter().map(example).collect();
    row::build(kind, &form.name, &bound).is_some()
}

pub(super) fn example(operand: Operand) -> Value {
    use super::super::{Bit, Direction, Source};
    match operand {
        Operand::Areg | Operand::Target | Operand::Source => {
            Value::Source(Source::Register(Analog(0)))
        }
        Operand::Dreg | Operand::Bit => Value::Bit(Bit::Register(Digital(0))),
        Operand::Direction | Operand::Directions => Value::Directions(vec![Direction::North]),
        Operand::Number(..) | Operand::Integer(..) | Operand::Literal(_) => Value::Number(0.0),
        Operand::Word => Value::Word(String::new()),
    }
}
