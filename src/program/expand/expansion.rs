//! The result of expansion, statement by statement.

use std::collections::BTreeMap;

use crate::{
    config::{Fault, Place},
    isa::{Cell, Device},
    unit::Words,
};

use super::super::{
    code::{Code, Step},
    cost,
    effect::CellEffect,
};

/// Constants that are set from outside, by name.
pub type Overrides = BTreeMap<String, f64>;

/// A program, expanded.
#[derive(Clone, Debug, Default)]
pub struct Expansion {
    /// What runs.
    pub code: Code,
    /// Whether the text is bare statements: a whole program, to be run once. Its code is
    /// `code.frame`.
    pub bare: bool,
    /// The statements of `init`, with what each became.
    pub init: Vec<Entry>,
    /// The statements of a frame, with what each became.
    pub frame: Vec<Entry>,
    /// The value of every constant that is a number.
    pub constants: BTreeMap<String, f64>,
    /// Warnings: what may not be meant.
    pub warnings: Vec<Fault>,
}

impl Expansion {
    /// Instruction words that it takes in the kernel store: a repetition is stored once, and the
    /// host's own kernels are not there.
    #[must_use]
    pub fn stored(&self, device: &Device) -> Words {
        let mut words = Words(0);
        let mut add = |statement: &Expanded| {
            if !statement.host {
                words += cost::stored(&statement.steps, device);
            }
        };
        for_each(&self.init, &mut add);
        for_each(&self.frame, &mut add);
        words
    }
}

/// A statement and what it became.
#[derive(Clone, Debug)]
pub enum Entry {
    /// One statement.
    Statement(Expanded),
    /// A block, several times.
    Repeat {
        /// How often.
        times: u32,
        /// What is done each time.
        body: Vec<Entry>,
        /// Line of its heading, from 1.
        line: u32,
    },
}

/// One statement, expanded.
#[derive(Clone, Debug)]
pub struct Expanded {
    /// As it is printed.
    pub text: String,
    /// Its name.
    pub name: String,
    /// Where it stands.
    pub place: Place,
    /// Line, from 1.
    pub line: u32,
    /// What it became.
    pub steps: Vec<Step>,
    /// What it reads and writes.
    pub effect: CellEffect,
    /// What it gives as a result; the rest of what it writes is destroyed.
    pub results: Vec<Cell>,
    /// Whether it needs FLAG to be 1 everywhere.
    pub whole_flag: bool,
    /// Whether the host runs it as kernels of its own, outside the program's store.
    pub host: bool,
}

impl Expanded {
    /// The cells that it writes and does not give as a result.
    pub fn destroys(&self) -> impl Iterator<Item = Cell> {
        let writes = self.effect.writes.iter().copied();
        writes.filter(|cell| !self.results.contains(cell))
    }
}

/// Every statement, a repeated one once.
pub fn for_each(entries: &[Entry], act: &mut impl FnMut(&Expanded)) {
    for entry in entries {
        match entry {
            Entry::Statement(statement) => act(statement),
            Entry::Repeat { body, .. } => for_each(body, act),
        }
    }
}
