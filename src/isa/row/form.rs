//! Conversion between a primitive and its text: by a form of its row.

use crate::isa::{
    connection::{Analog, Bit, Digital, Source, Target},
    device::Device,
    direction::Direction,
    primitive::Primitive,
    signature::Bound,
    value::Value,
};

use super::table::PrimitiveKind;

impl Primitive {
    /// As the vendor writes it, with the device's names.
    #[must_use]
    pub fn text(&self, device: &Device) -> String {
        let analog = |r: &Analog| device.analog_name(*r);
        let digital = |r: &Digital| device.digital_name(*r);
        let bit = |b: &Bit| device.bit_name(*b);
        let source = |s: &Source| device.source_name(*s);
        let target = |t: &Target| device.target_name(*t);
        let call = |name: &str, arguments: Vec<String>| format!("{name}({})", arguments.join(", "));
        match self {
            Self::Nop => call("nop", vec![]),
            Self::ResetPix => call("rpix", vec![]),
            Self::Bus { targets, sources } => {
                let name = match (targets.len(), sources.len()) {
                    (1, 0..=4) => "bus",
                    (2, 0..=2) => "bus2",
                    (3, 1) => "bus3",
                    _ => {
                        let targets: Vec<_> = targets.iter().map(target).collect();
                        let sources: Vec<_> = sources.iter().map(source).collect();
                        return format!(
                            "bus({{{}}}, {{{}}})",
                            targets.join(", "),
                            sources.join(", ")
                        );
                    }
                };
                let targets = targets.iter().map(target);
                call(name, targets.chain(sources.iter().map(source)).collect())
            }
            Self::Square { sources } => call("sq", sources.iter().map(source).collect()),
            Self::Where { sources } => call("where", sources.iter().map(source).collect()),
            Self::All => call("all", vec![]),
            Self::BlurSet => call("blurset", vec![]),
            Self::Blur {
                target,
                source,
                horizontal,
                vertical,
            } => {
                let name = match (horizontal, vertical) {
                    (true, false) => "blurh",
                    (false, true) => "blurv",
                    _ => "blur",
                };
                call(name, vec![analog(target), analog(source)])
            }
            Self::Set { targets } => call("SET", targets.iter().map(digital).collect()),
            Self::Clear { targets } => call("CLR", targets.iter().map(digital).collect()),
            Self::Or { target, sources } => {
                let name = if sources.len() == 1 { "MOV" } else { "OR" };
                let sources = sources.iter().map(bit);
                call(
                    name,
                    std::iter::once(digital(target)).chain(sources).collect(),
                )
            }
            Self::Nor { target, sources } => {
                let name = if sources.len() == 1 { "NOT" } else { "NOR" };
                let sources = sources.iter().map(bit);
                call(
                    name,
                    std::iter::once(digital(target)).chain(sources).collect(),
                )
            }
            Self::WhereBit { sources } => call("WHERE", sources.iter().map(bit).collect()),
            Self::Dnews {
                target,
                source,
                boundary,
            } => {
                let name = if *boundary { "DNEWS1" } else { "DNEWS0" };
                call(name, vec![digital(target), bit(source)])
            }
            Self::PropRead => call("PROP_R", vec![]),
            Self::Prop { boundary } => {
                let name = if *boundary { "PROP_1" } else { "PROP_0" };
                call(name, vec![])
            }
        }
    }
}

/// The primitive that a form stands for, with these values.
///
/// `None` when the row's form does not have the parameters that the primitive needs: loading
/// a device tries every form once, so that this is found there.
#[must_use]
pub fn build(kind: PrimitiveKind, mnemonic: &str, bound: &[Bound]) -> Option<Primitive> {
    let first = bound.first();
    let all = || bound.iter().flatten();
    let sources = |values: &mut dyn Iterator<Item = &Value>| -> Option<Vec<Source>> {
        values
            .map(|v| match v {
                Value::Source(source) => Some(*source),
                _ => None,
            })
            .collect()
    };
    let bits = |values: &mut dyn Iterator<Item = &Value>| -> Option<Vec<Bit>> {
        values
            .map(|v| match v {
                Value::Bit(bit) => Some(*bit),
                _ => None,
            })
            .collect()
    };
    let registers = || all().map(Value::digital).collect::<Option<Vec<_>>>();
    let one = |part: usize| bound.get(part).and_then(|b| b.first());
    Some(match kind {
        PrimitiveKind::Nop => Primitive::Nop,
        PrimitiveKind::ResetPix => Primitive::ResetPix,
        PrimitiveKind::Bus => {
            let targets = match mnemonic {
                "bus2" => 2,
                "bus3" => 3,
                _ => 1,
            };
            let (targets, sourced) = bound.split_at_checked(targets)?;
            Primitive::Bus {
                targets: targets
                    .iter()
                    .flatten()
                    .map(|v| match v {
                        Value::Source(Source::Register(r)) => Some(Target::Register(*r)),
                        Value::Source(Source::Neighbour(d)) => Some(Target::Neighbour(*d)),
                        _ => None,
                    })
                    .collect::<Option<_>>()?,
                sources: sources(&mut sourced.iter().flatten())?,
            }
        }
        PrimitiveKind::Square => Primitive::Square {
            sources: sources(&mut all())?,
        },
        PrimitiveKind::Where => Primitive::Where {
            sources: sources(&mut all())?,
        },
        PrimitiveKind::All => Primitive::All,
        PrimitiveKind::BlurSet => Primitive::BlurSet,
        PrimitiveKind::Blur => Primitive::Blur {
            target: one(0)?.analog()?,
            source: one(1)?.analog()?,
            horizontal: mnemonic != "blurv",
            vertical: mnemonic != "blurh",
        },
        PrimitiveKind::Set => Primitive::Set {
            targets: registers()?,
        },
        PrimitiveKind::Clear => Primitive::Clear {
            targets: registers()?,
        },
        PrimitiveKind::Or => Primitive::Or {
            target: first?.first()?.digital()?,
            sources: bits(&mut all().skip(1))?,
        },
        PrimitiveKind::Nor => Primitive::Nor {
            target: first?.first()?.digital()?,
            sources: bits(&mut all().skip(1))?,
        },
        PrimitiveKind::WhereBit => Primitive::WhereBit {
            sources: bits(&mut all())?,
        },
        PrimitiveKind::Dnews => Primitive::Dnews {
            target: one(0)?.digital()?,
            source: *bits(&mut one(1).into_iter())?.first()?,
            boundary: mnemonic == "DNEWS1",
        },
        PrimitiveKind::PropRead => Primitive::PropRead,
        PrimitiveKind::Prop => Primitive::Prop {
            boundary: mnemonic == "PROP_1",
        },
    })
}

/// The name of a neighbour's cell.
#[must_use]
pub const fn neighbour_name(direction: Direction) -> &'static str {
    match direction {
        Direction::North => "XN",
        Direction::East => "XE",
        Direction::South => "XS",
        Direction::West => "XW",
    }
}
