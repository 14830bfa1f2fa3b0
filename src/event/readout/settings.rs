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

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::{Arbiter, Frame, Ideal, Readout, Requests, RowOrder, Scan, WhenFull, scan::Order};
use crate::limit::QUEUE;
use crate::unit::{Evidence, Micros, Picos};

/// What a queue can be.
const FIFO: &str = "a whole number, at most 4294967296, or `unlimited`";

/// The readouts that come with the program, by name.
const SHIPPED: [(&str, &str); 4] = [
    ("ideal", include_str!("../../../readouts/ideal.toml")),
    ("scan", include_str!("../../../readouts/scan.toml")),
    ("arbiter", include_str!("../../../readouts/arbiter.toml")),
    ("frame", include_str!("../../../readouts/frame.toml")),
];

/// Names and settings of a readout, before they are believed.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Description {
    /// Which readout: `ideal`, `scan`, `arbiter`, `frame`.
    readout: String,
    /// Its settings.
    #[serde(default)]
    settings: BTreeMap<String, Setting>,
}

/// One setting, as a readout's file has it.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Setting {
    /// Its value, with the unit where it has one.
    pub value: String,
    /// Who says so.
    pub source: String,
    /// How well it is known; `None` for what was set by hand.
    #[serde(default)]
    pub evidence: Option<Evidence>,
}

/// A readout cannot be made of its settings.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum ReadoutError {
    /// The text is no TOML, or not of a readout.
    #[error("{name}:{line}:{column}: {why}")]
    #[diagnostic(help(
        "write `readout = \"arbiter\"`, then below `[settings]` each setting as `row = {{ value = \"36ns\", source = \"…\", evidence = \"guess\" }}`; readouts/ has examples"
    ))]
    Text {
        /// The file.
        name: String,
        /// From 1.
        line: usize,
        /// From 1, in characters.
        column: usize,
        /// What is wrong.
        why: String,
    },
    /// No such readout.
    #[error("there is no readout `{name}`")]
    #[diagnostic(help("known are {}; or give the path of a .toml file", shipped().join(", ")))]
    Unknown {
        /// What was asked for.
        name: String,
    },
    /// A setting is missing.
    #[error("{readout}: `{key}` is not set")]
    #[diagnostic(help("the settings of `{readout}` are {}", keys(readout).join(", ")))]
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
        key: &'static str,
        /// What was given.
        value: String,
        /// What it may be.
        want: &'static str,
    },
}

/// Names of the shipped readouts.
#[must_use]
pub fn shipped() -> Vec<&'static str> {
    SHIPPED.map(|(name, _)| name).to_vec()
}

/// The settings that a readout has.
fn keys(readout: &str) -> &'static [&'static str] {
    match readout {
        "scan" => &["slots", "slot", "period", "columns", "rows"],
        "arbiter" => &[
            "row",
            "event",
            "burst",
            "order",
            "requests",
            "link",
            "fifo",
            "when-full",
        ],
        "frame" => &["period", "bit"],
        _ => &[],
    }
}

/// For advice.
fn has(readout: &str) -> String {
    match keys(readout) {
        [] => format!("`{readout}` has no settings"),
        keys => format!("the settings of `{readout}` are {}", keys.join(", ")),
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

    /// The readout of a file's text; `name` is for messages.
    ///
    /// # Errors
    /// When the text is not TOML, or not of a known readout.
    pub fn parse(name: &str, text: &str) -> Result<Self, ReadoutError> {
        let description: Self = toml::from_str(text).map_err(|e| {
            let before = text
                .get(..e.span().map_or(0, |s| s.start))
                .unwrap_or_default();
            let line = before.rsplit('\n').next().unwrap_or_default();
            ReadoutError::Text {
                name: name.to_owned(),
                line: before.matches('\n').count() + 1,
                column: line.chars().count() + 1,
                why: e.message().to_owned(),
            }
        })?;
        if !shipped().contains(&description.readout.as_str()) {
            return Err(ReadoutError::Unknown {
                name: description.readout,
            });
        }
        Ok(description)
    }

    /// Sets one setting by hand.
    ///
    /// # Errors
    /// When this readout has no such setting.
    pub fn set(&mut self, key: &str, value: &str) -> Result<(), ReadoutError> {
        if !keys(&self.readout).contains(&key) {
            return Err(ReadoutError::Key {
                readout: self.readout.clone(),
                key: key.to_owned(),
            });
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
        keys(&self.readout)
            .iter()
            .filter_map(|key| Some((*key, self.settings.get(*key)?)))
    }

    /// Which readout it is.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.readout
    }

    /// The readout itself.
    ///
    /// # Errors
    /// When a setting is missing, unknown, or has a value that it cannot have.
    pub fn readout(&self) -> Result<Readout, ReadoutError> {
        let known = keys(&self.readout);
        if let Some(key) = self.settings.keys().find(|k| !known.contains(&k.as_str())) {
            return Err(ReadoutError::Key {
                readout: self.readout.clone(),
                key: key.clone(),
            });
        }
        match self.readout.as_str() {
            "ideal" => Ok(Readout::Ideal(Ideal)),
            "scan" => Ok(Readout::Scan(Scan {
                slots: self.read("slots", "a whole number from 1 to 4000", |v| {
                    v.parse().ok().filter(|slots| (1..=4000).contains(slots))
                })?,
                slot: self.time("slot")?,
                period: self.period()?,
                order: Order {
                    from_left: self.one_of(
                        "columns",
                        "`from-right` or `from-left`",
                        &[("from-right", false), ("from-left", true)],
                    )?,
                    from_bottom: self.one_of(
                        "rows",
                        "`from-top` or `from-bottom`",
                        &[("from-top", false), ("from-bottom", true)],
                    )?,
                },
            })),
            "arbiter" => Ok(Readout::Arbiter(Arbiter {
                row: self.time("row")?,
                event: self.time("event")?,
                link: self.time("link")?,
                burst: self.one_of("burst", "`yes` or `no`", &[("yes", true), ("no", false)])?,
                order: self.one_of(
                    "order",
                    "`oldest` or `round`",
                    &[("oldest", RowOrder::Oldest), ("round", RowOrder::Round)],
                )?,
                requests: self.one_of(
                    "requests",
                    "`one` or `all`",
                    &[("one", Requests::One), ("all", Requests::All)],
                )?,
                fifo: self.read("fifo", FIFO, |v| match v {
                    "unlimited" => Some(None),
                    number => number.parse().ok().filter(|n| *n <= QUEUE).map(Some),
                })?,
                when_full: self.one_of(
                    "when-full",
                    "`stall`, `drop-newest` or `drop-oldest`",
                    &[
                        ("stall", WhenFull::Stall),
                        ("drop-newest", WhenFull::DropNewest),
                        ("drop-oldest", WhenFull::DropOldest),
                    ],
                )?,
            })),
            "frame" => Ok(Readout::Frame(Frame {
                period: self.period()?,
                bit: self.time("bit")?,
            })),
            other => Err(ReadoutError::Unknown {
                name: other.to_owned(),
            }),
        }
    }

    fn read<T>(
        &self,
        key: &'static str,
        want: &'static str,
        parse: impl Fn(&str) -> Option<T>,
    ) -> Result<T, ReadoutError> {
        let readout = self.readout.clone();
        let Some(setting) = self.settings.get(key) else {
            return Err(ReadoutError::Missing { readout, key });
        };
        parse(setting.value.trim()).ok_or_else(|| ReadoutError::Value {
            readout,
            key,
            value: setting.value.clone(),
            want,
        })
    }

    fn one_of<T: Copy>(
        &self,
        key: &'static str,
        want: &'static str,
        values: &[(&str, T)],
    ) -> Result<T, ReadoutError> {
        let find = |v: &str| values.iter().find(|(name, _)| *name == v).map(|(_, t)| *t);
        self.read(key, want, find)
    }

    /// At most a second, so that no sum of times can overflow.
    fn time(&self, key: &'static str) -> Result<Picos, ReadoutError> {
        let want = "a time in whole picoseconds, at most 1 s, such as 36ns or 0.91us";
        let most = Picos(1_000_000_000_000);
        self.read(key, want, |v| v.parse().ok().filter(|t| *t <= most))
    }

    fn period(&self) -> Result<Micros, ReadoutError> {
        let want = "a time in whole microseconds, such as 1ms; 0us makes each time stamp a frame";
        self.read("period", want, |v| v.parse().ok())
    }
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
        assert_eq!(said("readout = 'x'"), "there is no readout `x`");
        assert_eq!(said("readout = 'frame'"), "frame: `period` is not set");
        let frame = |period: &str, bit: &str| {
            let (period, bit) = (setting(period), setting(bit));
            format!("readout = 'frame'\n[settings]\nperiod = {period}\nbit = {bit}")
        };
        assert_eq!(
            said(&frame("0.5us", "1ns")),
            "frame: `period` cannot be `0.5us`"
        );
        assert_eq!(said(&frame("1us", "2s")), "frame: `bit` cannot be `2s`");
        let extra = frame("1us", "0ns") + "\nrow = " + &setting("1ns");
        assert_eq!(said(&extra), "frame has no setting `row`");
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
        assert!(arbiter.set("fifo", "-1").is_ok() && arbiter.readout().is_err());
    }
}
