//! A program as it is written.

use std::{collections::BTreeMap, sync::Arc};

use crate::{
    config::{Fault, Faults},
    isa::{Cell, Device},
};

use super::{
    check,
    code::Code,
    expand::{self, Expansion, Overrides},
    parse,
    settings::{Expectation, Settings},
    syntax::Syntax,
    vendor::{self, Beside, Includes},
};

/// Names for other kinds of cells than a program reads out.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error(
    "{file}: `names` has {}, but the program reads out events of {}",
    crate::unit::counted(*names, "name"),
    crate::unit::counted(*kinds, "kind")
)]
#[diagnostic(help("give a name for each kind, in their order, or leave `names` out"))]
pub struct NamesError {
    /// The program.
    pub file: String,
    /// Names in its settings.
    pub names: usize,
    /// Kinds whose events it reads out.
    pub kinds: u8,
}

/// A program as it can be run.
#[derive(Clone, Debug)]
pub struct Runnable {
    /// What is the same in every frame; nothing where the host decides which words run.
    pub expansion: Option<Expansion>,
    /// Whether it is vendor C++ whose host decides in the run what the array does, by what it reads
    /// or by how many frames have passed. Where that is only whether something is read out, the
    /// expansion goes without it, with a warning.
    pub decides: bool,
}

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
    /// Titles of what vendor C++ shows on displays, by the place of the call: `line 7`, or `part.hpp:3`
    /// in an included file.
    pub titles: BTreeMap<String, String>,
    /// Faults of the text itself.
    faults: Vec<Fault>,
    /// What vendor C++ asks for by `#include`; `None` for a program in the frame language.
    includes: Option<Includes>,
}

impl Program {
    /// Reads a text; `file` is named in messages.
    ///
    /// # Errors
    /// All that is wrong with the text.
    pub fn parse(file: &str, text: &str) -> Result<Self, Faults> {
        let program = Self::read(file, text);
        let mut faults = program.faults.clone();
        if let Some(includes) = &program.includes {
            let all = &program.settings.constants;
            let read = vendor::read((file, text), includes, all, &Device::scamp5());
            faults.extend(read.faults);
            faults.extend(read.undecided);
        }
        Faults::check(file, text, faults)?;
        Ok(program)
    }

    /// Reads as much of a text as can be read. What is wrong with it is said by
    /// [`Program::expand`], together with all that is wrong with its statements.
    #[must_use]
    pub fn read(file: &str, text: &str) -> Self {
        Self::read_with(file, text, &Includes::new())
    }

    /// As [`Program::read`], with the files that vendor C++ asks for by `#include "…"`.
    #[must_use]
    pub fn read_with(file: &str, text: &str, includes: &Includes) -> Self {
        if vendor::is_cpp(file) {
            return Self::vendor(file, text, includes);
        }
        let own = Self::own(file, text);
        // A head or a foot is nothing that a simulator's text has.
        let marks = ["//!", "//="];
        let has_mark = |line: &str| marks.iter().any(|mark| line.starts_with(mark));
        let frame_language = vendor::ending(file) == "scamp" || text.lines().any(has_mark);
        if !frame_language && vendor::has_its_words(&own.syntax.items) && vendor::parses(text) {
            return Self::vendor(file, text, includes);
        }
        if own.faults.is_empty() {
            return own;
        }
        let ends = |it: &Fault| it.message.starts_with("expected `;`");
        // A word without parentheses, before the next line.
        let alone = |it: &Fault| {
            let before = text.get(..it.place.start).unwrap_or_default();
            let line = before.rsplit('\n').next().unwrap_or_default();
            it.message.starts_with("expected `(`") && line.trim().is_empty()
        };
        let by_lines = !frame_language
            && own.faults.iter().any(ends)
            && own.faults.iter().all(|it| ends(it) || alone(it));
        if vendor::looks_like_cpp(text) || (by_lines && vendor::parses(text)) {
            return Self::vendor(file, text, includes);
        }
        own
    }

    /// Reads vendor C++, or text whose statements end with their lines.
    fn vendor(file: &str, text: &str, includes: &Includes) -> Self {
        let (mut header, mut header_at, mut footer, mut footer_at) = Default::default();
        let mut start = 0;
        for line in text.split_inclusive('\n') {
            for (mark, lines, at) in [
                ("//!", &mut header, &mut header_at),
                ("//=", &mut footer, &mut footer_at),
            ] {
                let (lines, at): (&mut Vec<String>, &mut Vec<usize>) = (lines, at);
                if let Some(rest) = line.strip_prefix(mark) {
                    lines.push(rest.trim_end().to_owned());
                    at.push(start + mark.len());
                }
            }
            start += line.len();
        }
        let mut faults = Vec::new();
        let settings = Settings::read(&header, &header_at, &mut faults);
        let expectation = Expectation::read(&footer, &footer_at, &mut faults);
        let read = vendor::read((file, text), includes, &Overrides::new(), &Device::scamp5());
        // What is wrong is found again when it is expanded, with the constants that are set.
        let titles = read.titles.into_iter().filter_map(|(line, titles)| {
            let mut titles = titles.into_iter();
            Some((line, titles.next().filter(|_| titles.next().is_none())?))
        });
        Self {
            file: file.to_owned(),
            text: text.into(),
            syntax: Syntax {
                header,
                items: read.items,
                footer,
            },
            settings,
            expectation,
            titles: titles.collect(),
            faults,
            includes: Some(includes.clone()),
        }
    }

    /// Reads a program in the frame language.
    fn own(file: &str, text: &str) -> Self {
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
            titles: BTreeMap::new(),
            faults,
            includes: None,
        }
    }

    /// Whether it is vendor C++, or text whose statements end with their lines.
    #[must_use]
    pub const fn is_vendor(&self) -> bool {
        self.includes.is_some()
    }

    /// Looks up every name on a chip, expands every macro, and checks the result.
    ///
    /// # Errors
    /// All that is wrong with the program on this chip, warnings included.
    pub fn expand(&self, device: &Device, overrides: &Overrides) -> Result<Expansion, Faults> {
        let (expansion, faults, undecided) = self.laid_out(device, overrides);
        Faults::check(&self.file, &self.text, [faults, undecided].concat())?;
        Ok(expansion)
    }

    /// The first statement of a program in words and macros that a chip does not take, and why; none
    /// where it takes each.
    #[must_use]
    pub fn refused(&self, device: &Device) -> Option<Fault> {
        expand::refused(&self.syntax, &self.text, &self.settings.constants, device)
    }

    /// As [`expand`](Self::expand), for whoever can run it by [`run_beside`](Self::run_beside) too.
    ///
    /// # Errors
    /// All that is wrong with the program on this chip, whichever way it is run.
    pub fn layout(&self, device: &Device, overrides: &Overrides) -> Result<Runnable, Faults> {
        let (expansion, faults, undecided) = self.laid_out(device, overrides);
        if !faults.iter().any(Fault::is_error) {
            let steady = !undecided.iter().any(Fault::is_error);
            return Ok(Runnable {
                expansion: steady.then_some(expansion),
                decides: !undecided.is_empty(),
            });
        }
        // What a run decides is no fault of a program that is run.
        Err(Faults::new(&self.file, &self.text, faults))
    }

    /// What it becomes; its faults, and those that it has only because a program is the same in
    /// every frame.
    fn laid_out(
        &self,
        device: &Device,
        overrides: &Overrides,
    ) -> (Expansion, Vec<Fault>, Vec<Fault>) {
        let Some(includes) = &self.includes else {
            let constants = &self.settings.constants;
            let (mut expansion, mut faults) =
                expand::expand(&self.syntax, &self.text, constants, device, overrides);
            faults.extend(self.faults.iter().cloned());
            if !expansion.bare {
                // An analogue register may be set from outside.
                let bits = |cell: &Cell| matches!(cell, Cell::Digital(_));
                let unwritten = check::unwritten(&expansion, device, bits);
                expansion.warnings.extend(unwritten.clone());
                faults.extend(unwritten);
            }
            return (expansion, faults, Vec::new());
        };
        let mut read = vendor::read(
            (&self.file, &self.text),
            includes,
            &self.all_set(overrides),
            device,
        );
        let syntax = Syntax {
            items: read.items,
            ..Syntax::default()
        };
        let (mut expansion, faults) =
            expand::expand(&syntax, &self.text, &read.constants, device, overrides);
        let mut faults: Vec<Fault> = faults.into_iter().map(vendor::in_cpp).collect();
        let told = read.faults.iter().chain(&read.undecided);
        expansion
            .warnings
            .extend(told.filter(|it| !it.is_error()).cloned());
        expansion.posts = read.posts;
        faults.append(&mut read.faults);
        faults.extend(self.faults.iter().cloned());
        // Bare statements of the frame language may find their registers set; a whole program does
        // not. A line that was refused may have written what others read.
        let refused = faults.iter().any(Fault::is_error);
        let whole = !expansion.bare || read.loops && read.undecided.is_empty();
        if whole && !refused {
            let unwritten = check::unwritten(&expansion, device, |_| true);
            expansion.warnings.extend(unwritten);
        }
        (expansion, faults, read.undecided)
    }

    /// The settings of its head are constants of the text like those set from outside.
    fn all_set(&self, overrides: &Overrides) -> Overrides {
        let mut all = self.settings.constants.clone();
        all.extend(overrides.clone());
        all
    }

    /// Runs vendor C++ with its host beside the array, until the array or the program ends; its
    /// warnings.
    ///
    /// # Errors
    /// All that is wrong with the text, as far as it was run.
    pub fn run_beside(
        &self,
        device: &Device,
        overrides: &Overrides,
        array: &mut dyn Beside,
    ) -> Result<Option<Faults>, Faults> {
        let none = Includes::new();
        let includes = self.includes.as_ref().unwrap_or(&none);
        let faults = vendor::run(
            (&self.file, &self.text),
            includes,
            &self.all_set(overrides),
            device,
            array,
        );
        Faults::check(&self.file, &self.text, faults.clone())?;
        Ok((!faults.is_empty()).then(|| Faults::new(&self.file, &self.text, faults)))
    }

    /// The program in canonical form: vendor C++ as the statements that it becomes with these
    /// constants.
    ///
    /// # Errors
    /// All that is wrong with the text; with vendor C++, all that is wrong with the program.
    pub fn canonical(&self, device: &Device, overrides: &Overrides) -> Result<Syntax, Faults> {
        let Some(includes) = &self.includes else {
            return Self::parse(&self.file, &self.text).map(|it| it.syntax);
        };
        self.expand(device, overrides)?;
        let all = self.all_set(overrides);
        Ok(Syntax {
            items: vendor::read((&self.file, &self.text), includes, &all, device).items,
            ..self.syntax.clone()
        })
    }

    /// What the kinds are called whose events its code reads out; empty where it says no names, or
    /// reads no events.
    ///
    /// # Errors
    /// When it has names for other kinds than these.
    pub fn names(&self, code: &Code) -> Result<Vec<String>, NamesError> {
        self.names_of(code.kinds())
    }

    /// What this many kinds are called; empty where it says no names.
    ///
    /// # Errors
    /// When it has names for other kinds than these.
    pub fn names_of(&self, kinds: u8) -> Result<Vec<String>, NamesError> {
        let names = &self.settings.names;
        if kinds == 0 || names.is_empty() {
            return Ok(Vec::new());
        }
        if names.len() == usize::from(kinds) {
            return Ok(names.clone());
        }
        Err(NamesError {
            file: self.file.clone(),
            names: names.len(),
            kinds,
        })
    }

    /// The warnings of an expansion, ready to be shown; `None` when there are none.
    #[must_use]
    pub fn warnings(&self, expansion: &Expansion) -> Option<Faults> {
        debug_assert!(expansion.warnings.iter().all(|w| !w.is_error()));
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
