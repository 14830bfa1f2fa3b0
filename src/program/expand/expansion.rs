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
    /// In how many places the host of vendor C++ writes texts for people, which only a run beside the
    /// array shows.
    pub posts: usize,
}

impl Expansion {
    /// Instruction words that it takes in the kernel store at most: a repetition is stored once, of
    /// kernels that give their room back the largest counts, and the host's own are not there.
    #[must_use]
    pub fn stored(&self, device: &Device) -> Words {
        Words(self.fills(device, u64::MAX).0)
    }

    /// Words that it takes in the kernel store, and the first statement with which they are more
    /// than so many.
    pub(in crate::program) fn fills(&self, device: &Device, room: u64) -> (u64, Option<Place>) {
        // What is kept, the launch that was worked on last, and the largest of all launches.
        let (mut kept, mut launch, mut largest) = (0, (0, 0), 0);
        let mut over = None;
        let mut add = |statement: &Expanded| {
            let words = cost::stored(&statement.steps, device).0;
            match statement.stored {
                Stored::Kept => kept += words,
                Stored::Launch(at) if at == launch.0 => launch.1 += words,
                Stored::Launch(at) => launch = (at, words),
                Stored::Elsewhere => return,
            }
            largest = largest.max(launch.1);
            if kept + largest > room {
                over.get_or_insert(statement.place);
            }
        };
        for_each(&self.init, &mut add);
        for_each(&self.frame, &mut add);
        (kept + largest, over)
    }
}

/// Where the words of a statement lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stored {
    /// In the kernel store, for good.
    Kept,
    /// In the kernel store during this launch of a kernel, by its number.
    Launch(usize),
    /// Not in the program's part of the store: the host runs them as kernels of its own, or they are
    /// words that are counted already.
    Elsewhere,
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
    /// Where it is written, `file:line:column`, if that is another file than the one of its place.
    pub origin: Option<String>,
    /// What it became.
    pub steps: Vec<Step>,
    /// What it reads and writes.
    pub effect: CellEffect,
    /// What it gives as a result; the rest of what it writes is destroyed.
    pub results: Vec<Cell>,
    /// Whether it needs FLAG to be 1 everywhere.
    pub whole_flag: bool,
    /// Where its words lie.
    pub stored: Stored,
}

/// `file:line` of a place in an included file, which has its column too.
pub(super) fn line_of(origin: &str) -> &str {
    origin.rsplit_once(':').map_or(origin, |it| it.0)
}

impl Expanded {
    /// Where it stands, in words: its line, with the file where that is another.
    #[must_use]
    pub fn stands(&self) -> String {
        match &self.origin {
            None => format!("line {}", self.line),
            Some(origin) => line_of(origin).to_owned(),
        }
    }

    /// A fault of it, that says where it is written.
    pub(in crate::program) fn told(&self, fault: Fault) -> Fault {
        fault.written(self.origin.as_deref())
    }
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
