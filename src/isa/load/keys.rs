//! The keys of a chip's files.

use serde_json::{Map, Value as Json, json};

use super::super::{Clock, Evidence, Figure, HostKind, PrimitiveKind};
use crate::config::{File, Key, Kind, Range, Spelling, Table, schema};
use crate::isa::names::is_writable;

const SEE: &str = "see isa/README.md or the shipped files for what can stand here";

/// `device.toml`.
pub const DEVICE_FILE: File = File {
    title: "a chip of amacrine: device.toml",
    kind: Kind::Table(&DEVICE),
    see: SEE,
};

/// `primitives.toml`.
pub const PRIMITIVES_FILE: File = File {
    title: "a chip of amacrine: primitives.toml",
    kind: Kind::Table(&PRIMITIVES),
    see: SEE,
};

pub(super) const DEVICE: Table = Table::new(&[
    Key::required("name", CHIP, "name of the chip, as that of its folder"),
    Key::required("title", Kind::Text, "the chip in a few words"),
    Key::optional(
        "extends",
        Kind::Text,
        "the chip that holds what is not stated here",
    ),
    Key::optional(
        "registers",
        Kind::Table(&REGISTERS),
        "the registers of a pixel",
    ),
    Key::optional(
        "figure",
        Kind::Map(&Kind::Map(&Kind::Table(&QUANTITY))),
        "numbers about the silicon, by section and key",
    ),
    Key::optional(
        "host",
        Kind::list(&Kind::Table(&HOST)),
        "operations of the host",
    ),
]);

const CHIP: Kind = Kind::Spelled(&Spelling {
    what: "a name that is not blank",
    pattern: r"\S",
    holds: |text| !text.trim().is_empty(),
});

const TEXTS: Kind = Kind::list(&Kind::Text);

/// What a register can be called.
pub(super) const NAME: &str = "a name that programs can write: letters, digits and _, no digit first, no word of the language";

const NAMES: Kind = Kind::list(&Kind::Spelled(&Spelling {
    what: NAME,
    pattern: "^[A-Za-z_][A-Za-z0-9_]*$",
    holds: is_writable,
}));

const REGISTERS: Table = Table::new(&[
    Key::optional("analogue", NAMES, "names of the analogue ones"),
    Key::optional(
        "news",
        Kind::Text,
        "the analogue one that neighbours can reach",
    ),
    Key::optional("digital", NAMES, "names of the one-bit ones"),
    Key::optional(
        "aliases",
        Kind::Map(&Kind::Text),
        "other names of one-bit ones",
    ),
    Key::optional(
        "roles",
        Kind::Table(&ROLES),
        "one-bit ones that the hardware itself reads or writes",
    ),
]);

const ROLES: Table = Table::new(&[
    Key::optional(
        "mask",
        Kind::Text,
        "propagation passes only where this is 1",
    ),
    Key::optional("propagated", Kind::Text, "the one that propagation spreads"),
    Key::optional(
        "north",
        Kind::Text,
        "where this is 1, the northern neighbour is read",
    ),
    Key::optional(
        "east",
        Kind::Text,
        "where this is 1, the eastern neighbour is read",
    ),
    Key::optional(
        "south",
        Kind::Text,
        "where this is 1, the southern neighbour is read",
    ),
    Key::optional(
        "west",
        Kind::Text,
        "where this is 1, the western neighbour is read",
    ),
]);

const SOURCE: Key = Key::required("source", Kind::Text, "who says so");

const EVIDENCE: Key = Key::required(
    "evidence",
    Kind::Choice(&Evidence::WORDS),
    "how well it is known",
);

pub(super) const QUANTITY: Table = Table::new(&[
    // What values make sense depends on the figure.
    Key::required("value", Kind::Number(Range::FREE), "the number"),
    Key::required("unit", Kind::Text, "its unit"),
    SOURCE,
    EVIDENCE,
    Key::optional("note", Kind::Text, "what else is to be said about it"),
    Key::optional(
        "low",
        Kind::Number(Range::FREE),
        "the least that it may be; with `high` and `why`",
    ),
    Key::optional(
        "high",
        Kind::Number(Range::FREE),
        "the most that it may be; with `low` and `why`",
    ),
    Key::optional(
        "why",
        Kind::Text,
        "why it is not less than `low` and not more than `high`",
    ),
    Key::optional(
        "bounds",
        Kind::Choice(&Evidence::WORDS),
        "how well `low` and `high` are known; a guess where nothing is said",
    ),
]);

const FORMS: Key = Key::required("forms", TEXTS, "how it can be written");

const HOST: Table = Table::new(&[
    Key::required("name", Kind::Choice(HostKind::WORDS), "which operation"),
    FORMS,
    Key::required("meaning", Kind::Text, "what it does"),
    Key::required("call", Kind::Table(&QUANTITY), "time of one call"),
    Key::optional(
        "item",
        Kind::Table(&QUANTITY),
        "time of each slot, sample or row besides; operations that read several need it",
    ),
]);

pub(super) const PRIMITIVES: Table = Table::new(&[Key::required(
    "primitive",
    Kind::list(&Kind::Table(&PRIMITIVE)),
    "the instructions, one [[primitive]] each",
)]);

const PRIMITIVE: Table = Table::new(&[
    Key::required(
        "name",
        Kind::Choice(PrimitiveKind::WORDS),
        "which primitive",
    ),
    FORMS,
    Key::required("equation", Kind::Text, "what it does"),
    Key::required(
        "words",
        Kind::Whole { least: 1, most: 64 },
        "instruction words",
    ),
    Key::required(
        "clock",
        Kind::Choice(Clock::WORDS),
        "the clock that it runs under",
    ),
    SOURCE,
    EVIDENCE,
]);

/// JSON Schema of `device.toml`, each figure with its unit and its range; that of
/// `primitives.toml` is `$defs/primitives` in it.
#[must_use]
pub fn json_schema() -> Json {
    let mut sections: Map<String, Json> = Map::new();
    for figure in Figure::ALL {
        let (section, key) = figure.key();
        let (range, whole) = figure.range().numbers();
        let mut value = schema::kind(&Kind::Number(range));
        if whole {
            schema::add(&mut value, "type", "integer");
        }
        let mut stated = schema::table(&QUANTITY);
        for end in ["low", "high"] {
            let about = stated["properties"][end]["description"].take();
            stated["properties"][end] = value.clone();
            schema::add(&mut stated["properties"][end], "description", about);
        }
        let together = json!({"low": ["high", "why"], "high": ["low", "why"], "why": ["low", "high"], "bounds": ["low"]});
        schema::add(&mut stated, "dependentRequired", together);
        stated["properties"]["value"] = value;
        stated["properties"]["unit"] = json!({"const": figure.unit()});
        schema::add(&mut stated, "description", figure.what().trim());
        let own = sections.entry(section).or_insert_with(
            || json!({"type": "object", "additionalProperties": false, "properties": {}}),
        );
        own["properties"][key] = stated;
    }
    let mut device = schema::file(&DEVICE_FILE);
    device["properties"]["figure"] =
        json!({"type": "object", "additionalProperties": false, "properties": sections});
    schema::add(
        &mut device,
        "$defs",
        json!({"primitives": schema::file(&PRIMITIVES_FILE)}),
    );
    device
}
