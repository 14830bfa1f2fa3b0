//! `--without` of `run` and `exec`: what a model leaves out, by hand.

use std::str::FromStr;

use super::heading;
use crate::{
    array::Arithmetic,
    reference::{Description, Effect},
    study::pilot::{ErrorTerm, Machine, UnknownPart, left_out},
};

/// `--without` of `amacrine run`.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct Effects {
    #[arg(long, value_name = "EFFECTS", value_delimiter = ',', value_parser = named::<Effect>,
        help = format!("Effects of the sensor to leave out: {}", keys(Effect::of_sensors().map(Effect::word))),
        help_heading = heading::SENSOR)]
    without: Vec<Effect>,
}

/// `--without` of `amacrine exec`.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct Terms {
    #[arg(long, value_name = "ERRORS", value_delimiter = ',', value_parser = named::<ErrorTerm>,
        help = format!("Errors of analogue cells to leave out: {}", keys(ErrorTerm::ALL.iter().copied().map(ErrorTerm::word))),
        help_heading = heading::CHIP)]
    without: Vec<ErrorTerm>,
}

fn keys(keys: impl Iterator<Item = &'static str>) -> String {
    keys.collect::<Vec<_>>().join(", ")
}

/// What clap shows is one line.
fn named<T: FromStr<Err = UnknownPart>>(text: &str) -> Result<T, String> {
    text.parse()
        .map_err(|unknown: UnknownPart| format!("{unknown}: {}", unknown.help))
}

impl Effects {
    /// The sensor without them.
    ///
    /// # Errors
    /// When the sensor does not have one of them.
    pub fn leave_out(
        &self,
        sensor: &str,
        description: &Description,
    ) -> miette::Result<Description> {
        Ok(left_out::sensor_without(
            sensor,
            description,
            &self.without,
        )?)
    }

    /// What is left out, after the number format: `, without jitter`.
    #[must_use]
    pub fn told(&self) -> String {
        told(self.without.iter().map(|effect| effect.name()))
    }
}

impl Terms {
    /// The cells without them; none where nothing is left out.
    ///
    /// # Errors
    /// When cells are not analogue.
    pub fn machine(&self, arithmetic: Arithmetic) -> miette::Result<Option<Machine>> {
        Ok(left_out::cells_without(arithmetic, &self.without)?)
    }

    /// What is left out, after the domain: `, without mismatch`.
    #[must_use]
    pub fn told(&self) -> String {
        told(self.without.iter().map(|term| term.name()))
    }
}

fn told(all: impl Iterator<Item = &'static str>) -> String {
    let mut names = Vec::new();
    for name in all {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    if names.is_empty() {
        String::new()
    } else {
        format!(", without {}", names.join(", "))
    }
}
