//! Readouts as data: files in `readouts/`, each number with its source and its evidence.
//!
//! ```toml
//! readout = "arbiter"
//! [settings]
//! row  = { value = "36ns", source = "one cycle of the link", evidence = "guess" }
//! link = { value = "200ns", source = "Berner et al. 2007: 5 Mev/s sustained", evidence = "quoted" }
//! ```
//!
//! | readout | settings |
//! |---|---|
//! | `ideal` | none |
//! | `scan` | `slots` (1 to 4000), `slot` (time), `period` (time; `0us`: each time stamp is a frame), `columns` (`from-right`, `from-left`), `rows` (`from-top`, `from-bottom`) |
//! | `arbiter` | `row`, `event`, `link` (times), `burst` (`yes`, `no`), `order` (`oldest`, `round`), `requests` (`one`, `all`), `fifo` (a number, or `unlimited`), `when-full` (`stall`, `drop-newest`, `drop-oldest`) |
//! | `frame` | `period` (time; `0us`: each time stamp is a frame), `bit` (time) |
//!
//! All settings of a readout are given, none is assumed. Times within a readout are exact to
//! the picosecond, periods to the microsecond.

use std::{collections::BTreeMap, str::FromStr};

use serde::Serialize;

use super::{
    Arbiter, Frame, Ideal, Readout, Requests, RowOrder, Scan, WhenFull,
    scan::{self, Order},
};
use crate::{
    config::{Faults, File, Key, Kind, Node, Read, Section, Spelling, Table, asked},
    limit::QUEUE,
    unit::{Evidence, Micros, Picos},
};

/// The readouts that come with the program, by name.
const SHIPPED: [(&str, &str); 4] = [
    ("ideal", include_str!("../../../readouts/ideal.toml")),
    ("scan", include_str!("../../../readouts/scan.toml")),
    ("arbiter", include_str!("../../../readouts/arbiter.toml")),
    ("frame", include_str!("../../../readouts/frame.toml")),
];

/// A readout's file.
pub const FILE: File = File {
    title: "a readout of amacrine",
    kind: Kind::Cases {
        tag: "readout",
        cases: &[
            ("ideal", &Table::new(&[READOUT, settings(SETTINGS[0].1)])),
            ("scan", &Table::new(&[READOUT, settings(SETTINGS[1].1)])),
            ("arbiter", &Table::new(&[READOUT, settings(SETTINGS[2].1)])),
            ("frame", &Table::new(&[READOUT, settings(SETTINGS[3].1)])),
        ],
    },
    see: "write `readout = \"arbiter\"`, then below `[settings]` each setting as `row = { value = \"36ns\", source = \"…\", evidence = \"guess\" }`; readouts/ has examples",
};

const READOUT: Key = Key::required("readout", Kind::Text, "which readout");

const fn settings(table: &'static Table) -> Key {
    Key::optional("settings", Kind::Table(table), "its settings, all of them")
}

/// A setting with its source. It is needed, but may come from the command line.
const fn setting(name: &'static str, stated: &'static Table, what: &'static str) -> Key {
    Key::optional(name, Kind::Table(stated), what)
}

/// What the table of a setting holds.
const fn stated(value: Kind) -> [Key; 3] {
    [
        Key::required("value", value, "its value, with the unit where it has one"),
        Key::required("source", Kind::Text, "who says so"),
        Key::optional(
            "evidence",
            Kind::Choice(&Evidence::WORDS),
            "how well it is known",
        ),
    ]
}

const TIME: &Table = &Table::new(&stated(Kind::Spelled(&Spelling {
    what: "a time in whole picoseconds, at most 1 s, such as 36ns or 0.91us",
    pattern: r"^\s*[0-9]+\.?[0-9]*\s*(ps|ns|us|µs|ms|s)\s*$",
    // No sum of such times overflows.
    holds: |text| {
        text.parse()
            .is_ok_and(|time: Picos| time.0 <= 1_000_000_000_000)
    },
})));

const PERIOD: &Table = &Table::new(&stated(Kind::Spelled(&Spelling {
    what: "a time in whole microseconds, such as 1ms; 0us makes each time stamp a frame",
    pattern: r"^\s*[0-9]+\.?[0-9]*\s*(us|µs|ms|s)\s*$",
    holds: |text| text.trim().parse::<Micros>().is_ok(),
})));

const SLOTS: &Table = &Table::new(&stated(Kind::Either {
    ways: &[
        Kind::Spelled(&Spelling {
            what: "a whole number from 1 to 4000",
            pattern: r"^\s*\+?[0-9]+\s*$",
            holds: |text| {
                text.trim()
                    .parse()
                    .is_ok_and(|slots: u64| (1..=scan::SLOTS.into()).contains(&slots))
            },
        }),
        Kind::Whole {
            least: 1,
            most: scan::SLOTS as u64,
        },
    ],
    expected: "a whole number from 1 to 4000",
}));

const FIFO: &Table = &Table::new(&stated(Kind::Either {
    ways: &[
        Kind::Spelled(&Spelling {
            what: "a whole number, at most 4294967296, or `unlimited`",
            pattern: r"^\s*(\+?[0-9]+|unlimited)\s*$",
            holds: |text| {
                let text = text.trim();
                text == "unlimited" || text.parse().is_ok_and(|n: u64| n <= QUEUE)
            },
        }),
        Kind::Whole {
            least: 0,
            most: QUEUE,
        },
    ],
    expected: "a whole number, at most 4294967296, or `unlimited`",
}));

const COLUMNS: &Table = &Table::new(&stated(Kind::Choice(&["from-right", "from-left"])));
const ROWS: &Table = &Table::new(&stated(Kind::Choice(&["from-top", "from-bottom"])));
const BURST: &Table = &Table::new(&stated(Kind::Choice(&["yes", "no"])));
const ORDER: &Table = &Table::new(&stated(Kind::Choice(&["oldest", "round"])));
const REQUESTS: &Table = &Table::new(&stated(Kind::Choice(&["one", "all"])));
const WHEN_FULL: &Table = &Table::new(&stated(Kind::Choice(&[
    "stall",
    "drop-newest",
    "drop-oldest",
])));

/// The settings of each readout, in the order in which they are shown.
const SETTINGS: [(&str, &Table); 4] = [
    ("ideal", &Table::new(&[])),
    (
        "scan",
        &Table::new(&[
            setting("slots", SLOTS, "events of a list"),
            setting("slot", TIME, "time of one slot of the list"),
            setting("period", PERIOD, "time from one frame to the next"),
            setting("columns", COLUMNS, "from where columns are scanned"),
            setting("rows", ROWS, "from where rows are scanned"),
        ]),
    ),
    (
        "arbiter",
        &Table::new(&[
            setting("row", TIME, "time to choose a row"),
            setting("event", TIME, "time to read one event of it"),
            setting("burst", BURST, "whether a row is read whole"),
            setting("order", ORDER, "which row comes next"),
            setting("requests", REQUESTS, "how many events of a cell wait"),
            setting("link", TIME, "time that the link takes for one event"),
            setting("fifo", FIFO, "events that the queue before the link holds"),
            setting(
                "when-full",
                WHEN_FULL,
                "what happens when the queue is full",
            ),
        ]),
    ),
    (
        "frame",
        &Table::new(&[
            setting("period", PERIOD, "time from one frame to the next"),
            setting("bit", TIME, "time of one bit"),
        ]),
    ),
];

/// A readout's file: which readout, and its settings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Description {
    /// Which readout: `ideal`, `scan`, `arbiter`, `frame`.
    readout: String,
    /// Its settings.
    settings: BTreeMap<String, Setting>,
}

/// A setting of a readout's file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Setting {
    /// Its value, with the unit where it has one.
    pub value: String,
    /// The publication or reasoning that it comes from.
    pub source: String,
    /// How well it is known; `None` for what was set by hand.
    pub evidence: Option<Evidence>,
}

/// A readout cannot be made of its settings.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum ReadoutError {
    /// The text is no TOML, or not of a readout.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Text(#[from] Faults),
    /// No such readout.
    #[error("there is no readout `{name}`")]
    #[diagnostic(help(
        "{}known are {}; or give the path of a .toml file",
        asked(name, shipped()),
        shipped().join(", ")
    ))]
    Unknown {
        /// What was asked for.
        name: String,
    },
    /// A setting is missing.
    #[error("{readout}: `{key}` is not set")]
    #[diagnostic(help(
        "state it in the file, below [settings], or set it by hand (--with {key}=VALUE); the settings of `{readout}` are {}",
        keys(readout).join(", ")
    ))]
    Missing {
        /// Which readout.
        readout: String,
        /// Which setting.
        key: &'static str,
    },
    /// A setting that this readout has not.
    #[error("{readout} has no setting `{key}`")]
    #[diagnostic(help("{}", has(readout)))]
    Key {
        /// Which readout.
        readout: String,
        /// What was set.
        key: String,
    },
    /// A setting with a value that it cannot have.
    #[error("{readout}: `{key}` cannot be `{value}`")]
    #[diagnostic(help("it is {want}"))]
    Value {
        /// Which readout.
        readout: String,
        /// Which setting.
        key: String,
        /// What was given.
        value: String,
        /// What it may be.
        want: String,
    },
}

/// Names of the shipped readouts.
#[must_use]
pub fn shipped() -> Vec<&'static str> {
    SHIPPED.map(|(name, _)| name).to_vec()
}

/// The settings that a readout has.
fn table(readout: &str) -> &'static Table {
    let found = SETTINGS.iter().find(|(name, _)| *name == readout);
    found.map_or(&SETTINGS[0], |it| it).1
}

fn keys(readout: &str) -> Vec<&'static str> {
    table(readout).names().collect()
}

/// For advice.
fn has(readout: &str) -> String {
    match keys(readout).join(", ") {
        none if none.is_empty() => format!("`{readout}` has no settings"),
        keys => format!("the settings of `{readout}` are {keys}"),
    }
}

impl Description {
    /// A shipped readout.
    ///
    /// # Errors
    /// When there is none of that name.
    pub fn shipped(name: &str) -> Result<Self, ReadoutError> {
        let found = SHIPPED.iter().find(|(shipped, _)| *shipped == name);
        let (name, text) = found.ok_or_else(|| ReadoutError::Unknown {
            name: name.to_owned(),
        })?;
        Self::parse(&format!("readouts/{name}.toml"), text)
    }

    /// The scan that a compiled program asks for: as many slots as one readout delivers.
    ///
    /// # Errors
    /// None: the shipped scan has that setting.
    pub fn of_compiled() -> Result<Self, ReadoutError> {
        let mut scan = Self::shipped("scan")?;
        scan.set("slots", &scan::SLOTS.to_string())?;
        Ok(scan)
    }

    /// The readout of a file's text; `name` is for messages.
    ///
    /// # Errors
    /// When the text is not TOML, or not of a known readout, or a setting has a value that it
    /// cannot have. A setting may be missing: [`Description::set`] can give it.
    pub fn parse(name: &str, text: &str) -> Result<Self, ReadoutError> {
        Ok(FILE.read(name, text, described)?)
    }

    /// Sets one setting by hand.
    ///
    /// # Errors
    /// When this readout has no such setting, or it cannot have this value.
    pub fn set(&mut self, key: &str, value: &str) -> Result<(), ReadoutError> {
        let Some(kind) = kind_of(&self.readout, key) else {
            return Err(ReadoutError::Key {
                readout: self.readout.clone(),
                key: key.to_owned(),
            });
        };
        if !kind.holds_text(value) {
            return Err(self.wrong(key, value));
        }
        let setting = Setting {
            value: value.to_owned(),
            source: "set by hand".to_owned(),
            evidence: None,
        };
        self.settings.insert(key.to_owned(), setting);
        Ok(())
    }

    /// Its settings, in the order of the table above.
    pub fn settings(&self) -> impl Iterator<Item = (&'static str, &Setting)> {
        let keys = table(&self.readout).names();
        keys.filter_map(|key| Some((key, self.settings.get(key)?)))
    }

    /// Which readout it is.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.readout
    }

    /// The readout itself.
    ///
    /// # Errors
    /// When a setting is missing.
    pub fn readout(&self) -> Result<Readout, ReadoutError> {
        match self.readout.as_str() {
            "scan" => Ok(Readout::Scan(Scan {
                slots: self.parsed("slots")?,
                slot: self.parsed("slot")?,
                period: self.parsed("period")?,
                order: Order {
                    from_left: self.is("columns", "from-left")?,
                    from_bottom: self.is("rows", "from-bottom")?,
                },
            })),
            "arbiter" => Ok(Readout::Arbiter(Arbiter {
                row: self.parsed("row")?,
                event: self.parsed("event")?,
                link: self.parsed("link")?,
                burst: self.is("burst", "yes")?,
                order: if self.is("order", "round")? {
                    RowOrder::Round
                } else {
                    RowOrder::Oldest
                },
                requests: if self.is("requests", "all")? {
                    Requests::All
                } else {
                    Requests::One
                },
                fifo: if self.is("fifo", "unlimited")? {
                    None
                } else {
                    Some(self.parsed("fifo")?)
                },
                when_full: match self.value("when-full")? {
                    "drop-newest" => WhenFull::DropNewest,
                    "drop-oldest" => WhenFull::DropOldest,
                    _ => WhenFull::Stall,
                },
            })),
            "frame" => Ok(Readout::Frame(Frame {
                period: self.parsed("period")?,
                bit: self.parsed("bit")?,
            })),
            _ => Ok(Readout::Ideal(Ideal)),
        }
    }

    fn value(&self, key: &'static str) -> Result<&str, ReadoutError> {
        let setting = self.settings.get(key);
        setting
            .map(|setting| setting.value.trim())
            .ok_or_else(|| ReadoutError::Missing {
                readout: self.readout.clone(),
                key,
            })
    }

    fn is(&self, key: &'static str, word: &str) -> Result<bool, ReadoutError> {
        Ok(self.value(key)? == word)
    }

    fn parsed<T: FromStr>(&self, key: &'static str) -> Result<T, ReadoutError> {
        let value = self.value(key)?;
        value.parse().map_err(|_| self.wrong(key, value))
    }

    fn wrong(&self, key: &str, value: &str) -> ReadoutError {
        ReadoutError::Value {
            readout: self.readout.clone(),
            key: key.to_owned(),
            value: value.to_owned(),
            want: kind_of(&self.readout, key).map_or_else(String::new, Kind::words),
        }
    }
}

/// What the value of a setting can be.
fn kind_of(readout: &str, key: &str) -> Option<&'static Kind> {
    match &table(readout).key(key)?.kind {
        Kind::Table(stated) => Some(&stated.key("value")?.kind),
        _ => None,
    }
}

fn described(root: Node<'_>) -> Read<Description> {
    let readout = root.get("readout").and_then(Node::as_text);
    let readout = readout.unwrap_or_default().to_owned();
    let given = root.get("settings").and_then(Node::as_table);
    let mut settings = BTreeMap::new();
    for (name, node) in given.unwrap_or_default() {
        let Some(Kind::Table(stated)) = table(&readout).key(name.text).map(|key| key.kind) else {
            continue;
        };
        let stated = Section::new(node, stated);
        let setting = Setting {
            value: match stated.get("value").and_then(Node::as_number) {
                Some(count) => count.to_string(),
                None => stated.text("value")?.to_owned(),
            },
            source: stated.text("source")?.to_owned(),
            evidence: stated.word("evidence", &Evidence::ALL)?,
        };
        settings.insert(name.text.to_owned(), setting);
    }
    Ok(Description { readout, settings })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shipped_readouts_are_what_they_are_called() {
        for name in shipped() {
            let description = Description::shipped(name).unwrap();
            assert_eq!(description.name(), name);
            description.readout().unwrap();
            for (key, setting) in description.settings() {
                assert!(setting.evidence.is_some(), "{name}: {key}");
                assert!(!setting.source.is_empty(), "{name}: {key}");
            }
        }
    }

    #[test]
    fn mistakes_are_named() {
        let said = |text: &str| {
            let made = Description::parse("my.toml", text).and_then(|d| d.readout());
            made.unwrap_err().to_string()
        };
        let setting =
            |v: &str| format!("{{ value = \"{v}\", source = \"s\", evidence = \"guess\" }}");
        assert!(said("readout = 'frame'\n[settings]\nbit = 7").starts_with("my.toml:3:7: "));
        let unknown =
            "my.toml:1:11: unknown value `x`, expected one of `ideal`, `scan`, `arbiter`, `frame`";
        assert_eq!(said("readout = 'x'"), unknown);
        assert_eq!(said("readout = 'frame'"), "frame: `period` is not set");
        let frame = |period: &str, bit: &str| {
            let (period, bit) = (setting(period), setting(bit));
            format!("readout = 'frame'\n[settings]\nperiod = {period}\nbit = {bit}")
        };
        assert_eq!(
            said(&frame("0.5us", "1ns")),
            "my.toml:3:20: `settings.period.value` cannot be \"0.5us\""
        );
        assert_eq!(
            said(&frame("1us", "2s")),
            "my.toml:4:17: `settings.bit.value` cannot be \"2s\""
        );
        let extra = frame("1us", "0ns") + "\nrow = " + &setting("1ns");
        assert_eq!(
            said(&extra),
            "my.toml:5:1: unknown key `row`, expected `period` or `bit`"
        );
        assert!(said("readout = 'ideal'\n[x").starts_with("my.toml:2:"));
    }

    #[test]
    fn a_setting_is_changed_by_hand() {
        let mut arbiter = Description::shipped("arbiter").unwrap();
        arbiter.set("fifo", "0").unwrap();
        arbiter.set("when-full", "drop-oldest").unwrap();
        let Readout::Arbiter(made) = arbiter.readout().unwrap() else {
            panic!("not an arbiter");
        };
        assert_eq!((made.fifo, made.when_full), (Some(0), WhenFull::DropOldest));
        assert_eq!(
            arbiter.set("depth", "3").unwrap_err().to_string(),
            "arbiter has no setting `depth`"
        );
        assert!(arbiter.set("fifo", "-1").is_err() && arbiter.readout().is_ok());
    }
}
