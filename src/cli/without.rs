//! `--without` of `run` and `exec`: what a model leaves out, by hand.

use miette::miette;

use crate::{
    array::Arithmetic,
    config::suggestion_or,
    reference::Description,
    study::pilot::{Choice, Effect, ErrorTerm, Machine},
};

/// `--without` of `amacrine run`.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct Effects {
    #[arg(long, value_name = "EFFECTS", value_delimiter = ',', value_parser = effect,
        help = format!("Leave effects of the sensor out: {}", keys(Effect::of_sensors().map(Effect::key))))]
    without: Vec<Effect>,
}

/// `--without` of `amacrine exec`.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct Terms {
    #[arg(long, value_name = "ERRORS", value_delimiter = ',', value_parser = term,
        help = format!("Leave errors of analogue cells out: {}", keys(ErrorTerm::ALL.into_iter().map(ErrorTerm::key))))]
    without: Vec<ErrorTerm>,
}

fn keys(keys: impl Iterator<Item = &'static str>) -> String {
    keys.collect::<Vec<_>>().join(", ")
}

fn named<T: Copy>(
    text: &str,
    what: &str,
    mut all: impl Iterator<Item = T> + Clone,
    key: fn(T) -> &'static str,
) -> Result<T, String> {
    let known = all.clone().map(key);
    all.find(|one| key(*one) == text).ok_or_else(|| {
        let list = format!("give some of {}", keys(known.clone()));
        let help = suggestion_or(text, known, &list);
        format!("`{text}` is no {what}: {help}")
    })
}

fn effect(text: &str) -> Result<Effect, String> {
    named(
        text,
        "effect of a sensor",
        Effect::of_sensors(),
        Effect::key,
    )
}

fn term(text: &str) -> Result<ErrorTerm, String> {
    named(
        text,
        "error of analogue cells",
        ErrorTerm::ALL.into_iter(),
        ErrorTerm::key,
    )
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
        let has = |effect: &Effect| effect.is_in(description, false);
        if let Some(absent) = self.without.iter().find(|effect| !has(effect)) {
            let there: Vec<_> = Effect::of_sensors().filter(has).map(Effect::key).collect();
            let help = if there.is_empty() {
                "leave --without out: it has none of these effects".to_owned()
            } else {
                format!("it has {}", there.join(", "))
            };
            return Err(miette!(
                help = help,
                "{sensor} has no {absent} to leave out"
            ));
        }
        let choice = self.without.iter().copied();
        Ok(choice
            .fold(Choice::full(), Choice::and_without)
            .plainer(description))
    }

    /// What is left out, after the number format: `, without jitter`.
    #[must_use]
    pub fn told(&self) -> String {
        told(self.without.iter().map(|effect| effect.name()))
    }
}

impl Terms {
    /// The arithmetic without them; none where nothing is left out.
    ///
    /// # Errors
    /// When cells are not analogue.
    pub fn machine(&self, arithmetic: Arithmetic) -> miette::Result<Option<Machine>> {
        match arithmetic {
            _ if self.without.is_empty() => Ok(None),
            Arithmetic::Number(_) => Err(miette!(
                help = "leave --without out, or add --domain silicon",
                "--without {} in the domain {arithmetic}, whose cells do not err",
                keys(self.without.iter().map(|term| term.key()))
            )),
            Arithmetic::Silicon { .. } => Ok(Some(Machine {
                format: None,
                without: self.without.clone(),
            })),
        }
    }

    /// What is left out, after the domain: `, without mismatch`.
    #[must_use]
    pub fn told(&self) -> String {
        told(self.without.iter().map(|term| term.name()))
    }
}

fn told(names: impl Iterator<Item = &'static str>) -> String {
    let names: Vec<_> = names.collect();
    if names.is_empty() {
        String::new()
    } else {
        format!(", without {}", names.join(", "))
    }
}
