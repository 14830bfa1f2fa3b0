//! What a model leaves out because a user says so, by name.

use std::str::FromStr;

use super::{chips::Machine, choice::Choice, error_term::ErrorTerm};
use crate::{
    array::Arithmetic,
    config::suggestion_or,
    reference::{Description, Effect},
};

/// A name of nothing that can be left out.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("`{name}` is no {what}")]
#[diagnostic(help("{help}"))]
pub struct UnknownPart {
    /// What was given.
    pub name: String,
    /// What it should name.
    pub what: &'static str,
    /// The name that was meant, or all.
    pub help: String,
}

/// Something to leave out that is not there.
#[derive(Clone, Debug, PartialEq, thiserror::Error, miette::Diagnostic)]
pub enum Absent {
    /// A sensor does not have the effect.
    #[error("{sensor} has no {effect} to leave out")]
    #[diagnostic(help("{has}"))]
    Effect {
        /// The sensor.
        sensor: String,
        /// What it does not have.
        effect: Effect,
        /// What it has.
        has: String,
    },
    /// Cells of numbers have no errors.
    #[error("--without {terms} in the domain {arithmetic}, whose cells do not err")]
    #[diagnostic(help("leave `--without` out, or add --domain silicon"))]
    Terms {
        /// What they were to do without.
        terms: String,
        /// What the cells hold.
        arithmetic: Arithmetic,
    },
}

impl FromStr for Effect {
    type Err = UnknownPart;

    /// One of [`Effect::of_sensors`], by its key.
    fn from_str(name: &str) -> Result<Self, UnknownPart> {
        let what = "effect of a sensor";
        named(
            name,
            what,
            &Self::of_sensors().collect::<Vec<_>>(),
            Self::word,
        )
    }
}

impl FromStr for ErrorTerm {
    type Err = UnknownPart;

    /// One of [`ErrorTerm::ALL`], by its key.
    fn from_str(name: &str) -> Result<Self, UnknownPart> {
        named(name, "error of analogue cells", Self::ALL, Self::word)
    }
}

fn named<T: Copy>(
    name: &str,
    what: &'static str,
    all: &[T],
    key: fn(T) -> &'static str,
) -> Result<T, UnknownPart> {
    let found = all.iter().find(|one| key(**one) == name);
    found.copied().ok_or_else(|| {
        let known: Vec<_> = all.iter().map(|one| key(*one)).collect();
        let list = format!("give some of {}", known.join(", "));
        UnknownPart {
            name: name.to_owned(),
            what,
            help: suggestion_or(name, known, &list),
        }
    })
}

/// The sensor without these effects.
///
/// # Errors
/// When it does not have one of them.
pub fn sensor_without(
    sensor: &str,
    description: &Description,
    effects: &[Effect],
) -> Result<Description, Absent> {
    let has = |effect: &Effect| effect.is_in(description, false);
    if let Some(effect) = effects.iter().find(|effect| !has(effect)) {
        let there: Vec<_> = Effect::of_sensors().filter(has).map(Effect::word).collect();
        return Err(Absent::Effect {
            sensor: sensor.to_owned(),
            effect: *effect,
            has: if there.is_empty() {
                "leave `--without` out: it has none of these effects".to_owned()
            } else {
                format!("it has {}", there.join(", "))
            },
        });
    }
    let choice = effects.iter().copied();
    Ok(choice
        .fold(Choice::full(), Choice::and_without)
        .plainer(description))
}

/// The cells without these errors; none where nothing is left out.
///
/// # Errors
/// When cells are not analogue.
pub fn cells_without(
    arithmetic: Arithmetic,
    terms: &[ErrorTerm],
) -> Result<Option<Machine>, Absent> {
    match arithmetic {
        _ if terms.is_empty() => Ok(None),
        Arithmetic::Number(_) => {
            let terms: Vec<_> = terms.iter().map(|term| term.word()).collect();
            Err(Absent::Terms {
                terms: terms.join(", "),
                arithmetic,
            })
        }
        Arithmetic::Silicon { .. } => Ok(Some(Machine {
            format: None,
            without: terms.to_vec(),
        })),
    }
}
