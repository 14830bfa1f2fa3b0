//! A program as it is written.

use std::sync::Arc;

use crate::{
    config::{Fault, Faults, Severity},
    isa::Device,
};

use super::{
    expand::{self, Expansion, Overrides},
    parse,
    settings::{Expectation, Settings},
    syntax::Syntax,
};

/// A program: its text, taken apart.
#[derive(Clone, Debug)]
pub struct Program {
    /// Name of its file, for messages.
    pub file: String,
    /// Its text.
    pub text: Arc<str>,
    /// The text as a tree.
    pub syntax: Syntax,
    /// What it says about itself.
    pub settings: Settings,
    /// What it is expected to give.
    pub expectation: Expectation,
    /// Faults of the text itself.
    faults: Vec<Fault>,
}

impl Program {
    /// Reads a text; `file` is named in messages.
    ///
    /// # Errors
    /// All that is wrong with the text.
    pub fn parse(file: &str, text: &str) -> Result<Self, Faults> {
        let program = Self::read(file, text);
        Faults::check(file, text, program.faults.clone())?;
        Ok(program)
    }

    /// Reads as much of a text as can be read. What is wrong with it is said by
    /// [`Program::expand`], together with all that is wrong with its statements.
    #[must_use]
    pub fn read(file: &str, text: &str) -> Self {
        let parse::Parsed {
            syntax,
            header_at,
            footer_at,
            mut faults,
        } = parse::parse(text);
        let settings = Settings::read(&syntax.header, &header_at, &mut faults);
        let expectation = Expectation::read(&syntax.footer, &footer_at, &mut faults);
        Self {
            file: file.to_owned(),
            text: text.into(),
            syntax,
            settings,
            expectation,
            faults,
        }
    }

    /// Looks up every name on a chip, expands every macro, and checks the result.
    ///
    /// # Errors
    /// All that is wrong with the program on this chip, warnings included.
    pub fn expand(&self, device: &Device, overrides: &Overrides) -> Result<Expansion, Faults> {
        let settings = &self.settings.constants;
        let (expansion, mut faults) =
            expand::expand(&self.syntax, &self.text, settings, device, overrides);
        faults.extend(self.faults.iter().cloned());
        Faults::check(&self.file, &self.text, faults)?;
        Ok(expansion)
    }

    /// The warnings of an expansion, ready to be shown; `None` when there are none.
    #[must_use]
    pub fn warnings(&self, expansion: &Expansion) -> Option<Faults> {
        debug_assert!(
            expansion
                .warnings
                .iter()
                .all(|w| w.severity == Severity::Warning)
        );
        if expansion.warnings.is_empty() {
            return None;
        }
        Some(Faults::new(
            &self.file,
            &self.text,
            expansion.warnings.clone(),
        ))
    }

    /// The text with another expectation below it, nothing else changed: how a golden test
    /// blesses.
    ///
    /// # Errors
    /// Only when a number cannot be written as TOML.
    pub fn blessed(&self, expectation: &Expectation) -> Result<String, toml::ser::Error> {
        let body: Vec<&str> = self
            .text
            .lines()
            .filter(|line| !line.trim_start().starts_with("//="))
            .collect();
        let mut text = body.join("\n").trim_end().to_owned();
        text.push_str("\n\n");
        for line in expectation.lines()? {
            text.push_str("//=");
            text.push_str(&line);
            text.push('\n');
        }
        Ok(text)
    }
}
