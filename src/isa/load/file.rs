//! The files of a chip as they are written: values with their places.

use super::{
    super::{Clock, Evidence, HostKind, Interval, PrimitiveKind, Quantity},
    keys::{self, DEVICE, PRIMITIVES, QUANTITY},
};
use crate::{
    config::{Fault, Faults, Name, Node, Place, Read, Section},
    order::Order,
};

/// A value and its place in the file.
#[derive(Clone, Debug)]
pub(super) struct Placed<T> {
    pub value: T,
    pub place: Place,
}

#[derive(Debug)]
pub(super) struct DeviceFile {
    pub name: Placed<String>,
    pub title: String,
    pub extends: Option<Placed<String>>,
    pub registers: Option<RegistersFile>,
    /// Section, key, figure.
    pub figures: Vec<(String, Placed<String>, Placed<Quantity>)>,
    pub host: Vec<HostFile>,
}

#[derive(Debug)]
pub(super) struct RegistersFile {
    pub analogue: Option<Placed<Vec<Placed<String>>>>,
    pub news: Option<Placed<String>>,
    pub digital: Option<Placed<Vec<Placed<String>>>>,
    /// In alphabetical order.
    pub aliases: Vec<(Placed<String>, Placed<String>)>,
    pub roles: RolesFile,
}

/// In the order of [`ROLE_KEYS`].
pub(super) type RolesFile = [Option<Placed<String>>; 6];

/// The parts that the hardware itself gives one-bit registers.
pub(super) const ROLE_KEYS: [&str; 6] = ["mask", "propagated", "north", "east", "south", "west"];

#[derive(Debug)]
pub(super) struct HostFile {
    pub kind: Placed<HostKind>,
    pub forms: Vec<Placed<String>>,
    pub meaning: String,
    pub call: Placed<Quantity>,
    pub item: Option<Placed<Quantity>>,
}

#[derive(Debug)]
pub(super) struct RowFile {
    pub kind: Placed<PrimitiveKind>,
    pub forms: Vec<Placed<String>>,
    pub equation: String,
    pub words: u64,
    pub clock: Clock,
    pub source: String,
    pub evidence: Evidence,
}

/// The text of `device.toml`; `name` is for messages.
pub(super) fn device(name: &str, text: &str) -> Result<DeviceFile, Faults> {
    keys::DEVICE_FILE.read(name, text, |root| {
        let top = Section::new(root, &DEVICE);
        let mut figures = Vec::new();
        for (section, node) in top.entries("figure") {
            for (key, node) in node.as_table().unwrap_or_default() {
                let name = Placed {
                    value: key.text.to_owned(),
                    place: key.place,
                };
                let stated = quantity(&Section::new(node, &QUANTITY))?;
                figures.push((section.text.to_owned(), name, stated));
            }
        }
        Ok(DeviceFile {
            name: placed(top.need("name")?),
            title: top.text("title")?.to_owned(),
            extends: top.get("extends").map(placed),
            registers: top.table("registers").map(|it| registers(&it)),
            figures,
            host: top.tables("host").iter().map(host).collect::<Read<_>>()?,
        })
    })
}

/// The text of `primitives.toml`; `name` is for messages.
pub(super) fn primitives(name: &str, text: &str) -> Result<Vec<RowFile>, Faults> {
    keys::PRIMITIVES_FILE.read(name, text, |root| {
        let rows = Section::new(root, &PRIMITIVES).tables("primitive");
        rows.iter().map(row).collect()
    })
}

fn row(row: &Section<'_>) -> Read<RowFile> {
    Ok(RowFile {
        kind: Placed {
            value: row.needed_word("name", PrimitiveKind::ALL)?,
            place: row.need("name")?.place(),
        },
        forms: row.list("forms").into_iter().map(placed).collect(),
        equation: row.text("equation")?.to_owned(),
        words: row.whole("words")?,
        clock: row.needed_word("clock", Clock::ALL)?,
        source: row.text("source")?.to_owned(),
        evidence: row.needed_word("evidence", &Evidence::ALL)?,
    })
}

fn host(row: &Section<'_>) -> Read<HostFile> {
    Ok(HostFile {
        kind: Placed {
            value: row.needed_word("name", HostKind::ALL)?,
            place: row.need("name")?.place(),
        },
        forms: row.list("forms").into_iter().map(placed).collect(),
        meaning: row.text("meaning")?.to_owned(),
        call: quantity(&Section::new(row.need("call")?, &QUANTITY))?,
        item: row.table("item").map(|it| quantity(&it)).transpose()?,
    })
}

fn registers(part: &Section<'_>) -> RegistersFile {
    let names = |key: &str| {
        let list = part.get(key)?;
        Some(Placed {
            value: list.as_list()?.into_iter().map(placed).collect(),
            place: list.place(),
        })
    };
    let aliases = part.entries("aliases").into_iter();
    let alias = |name: Name<'_>| Placed {
        value: name.text.to_owned(),
        place: name.place,
    };
    let mut aliases: Vec<_> = aliases
        .map(|(name, of)| (alias(name), placed(of)))
        .collect();
    aliases.order_by(|a, b| a.0.value.cmp(&b.0.value));
    RegistersFile {
        analogue: names("analogue"),
        news: part.get("news").map(placed),
        digital: names("digital"),
        aliases,
        roles: ROLE_KEYS.map(|key| Some(placed(part.table("roles")?.get(key)?))),
    }
}

fn quantity(stated: &Section<'_>) -> Read<Placed<Quantity>> {
    let value = Quantity {
        value: stated.number("value")?,
        unit: stated.text("unit")?.to_owned(),
        source: stated.text("source")?.to_owned(),
        evidence: stated.needed_word("evidence", &Evidence::ALL)?,
        note: stated.maybe_text("note"),
        interval: interval(stated)?,
    };
    Ok(Placed {
        value,
        place: stated.place(),
    })
}

/// Between which values a quantity may lie: ends and reason, all three or none.
fn interval(stated: &Section<'_>) -> Read<Option<Interval>> {
    let ends = [stated.maybe_number("low"), stated.maybe_number("high")];
    let (why, bounds) = (
        stated.maybe_text("why"),
        stated.word("bounds", &Evidence::ALL)?,
    );
    match (ends, why) {
        ([Some(low), Some(high)], Some(why)) if !why.trim().is_empty() => Ok(Some(Interval {
            low,
            high,
            evidence: bounds.unwrap_or(Evidence::Guess),
            why,
        })),
        ([None, None], None) if bounds.is_none() => Ok(None),
        _ => {
            let what = "an interval is `low`, `high` and `why`, all three";
            let fault = Fault::error(stated.place(), what, "this figure")
                .help("write low = …, high = …, why = \"…\" beside the value, or none of them");
            Err(fault)
        }
    }
}

fn placed(node: Node<'_>) -> Placed<String> {
    Placed {
        value: node.as_text().unwrap_or_default().to_owned(),
        place: node.place(),
    }
}
