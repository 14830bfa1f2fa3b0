//! A program on a generic pixel: one that has all its neighbours and any light.
//!
//! It lies in the middle of an array that is just large enough for the border not to reach
//! it. Its FLAG may be unknown, where it depends on what went in: then what a store would
//! change holds either the old or the new.

use std::collections::BTreeMap;

use super::{
    super::{Domain, Layout, Settings, State, Undecided, host, semantics::execute},
    form::Input,
};
use crate::{
    isa::{
        Analog, Device, Primitive,
        operands::{FlagEffect, Operands, Unit},
    },
    plane::{At, Size},
    program::{Action, Cost, Host, Step},
};

/// A domain that can leave open what a cell holds.
pub(super) trait Symbolic: Domain {
    /// What goes in.
    fn unknown(&self, input: Input, at: At) -> Self::Cell;
    /// The photodiode after an exposure.
    fn light(&self, settings: &Settings, at: At) -> Self::Cell;
    /// What a cell holds when the word `step` may have stored `new` in place of `old`.
    fn either(&self, old: &Self::Cell, new: &Self::Cell, step: u64) -> Self::Cell;
}

/// A program that a generic pixel cannot stand for.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
pub enum GenericError {
    /// An operation that treats pixels by their place, or by bits that are not known.
    #[error("line {line}: `{what}` does not do the same in every pixel")]
    #[diagnostic(help(
        "diffusion goes by bits; leave the instruction out, or run the program in a domain of numbers"
    ))]
    Place {
        /// Line of the program text, from 1.
        line: u32,
        /// The instruction.
        what: String,
    },
    /// It reaches too far.
    #[error("the program reaches {rows} rows and {columns} columns far; at most {FARTHEST} here")]
    #[diagnostic(help("take fewer transfers between neighbours at once"))]
    Reach {
        /// Transfers along columns.
        rows: usize,
        /// Transfers along rows.
        columns: usize,
    },
}

/// Transfers in one direction: beyond, the array around the pixel becomes unwieldy.
const FARTHEST: usize = 200;

/// One word that ran.
pub(super) struct Ran<'a> {
    pub(super) line: u32,
    pub(super) word: &'a Primitive,
}

/// The array around the generic pixel.
pub(super) struct GenericPixel<'a, D: Domain> {
    domain: &'a D,
    device: &'a Device,
    settings: Settings,
    pub(super) state: State<D::Cell>,
    /// Whether FLAG is unknown.
    unknown: bool,
    /// Of every word so far: its line and text.
    pub(super) words: Vec<(u32, String)>,
}

impl<'a, D: Symbolic> GenericPixel<'a, D> {
    /// Before the first word, around a pixel that has room for these steps.
    pub(super) fn new(
        domain: &'a D,
        device: &'a Device,
        settings: Settings,
        steps: &[Step],
    ) -> Result<Self, GenericError> {
        let (rows, columns) = reach(steps, device);
        if rows.max(columns) > FARTHEST {
            return Err(GenericError::Reach { rows, columns });
        }
        let size = Size::new(2 * rows + 1, 2 * columns + 1);
        let mut state = State::new(domain, Layout::new(device, size), settings.edge);
        let places = (0..size.height).flat_map(|y| (0..size.width).map(move |x| At { y, x }));
        for (i, at) in places.enumerate() {
            for (r, plane) in (0..).zip(&mut state.analog) {
                plane[i] = domain.unknown(Input::Register(Analog(r)), at);
            }
            state.pix[i] = domain.light(&settings, at);
        }
        Ok(Self {
            domain,
            device,
            settings,
            state,
            unknown: false,
            words: Vec::new(),
        })
    }

    /// Where it lies.
    pub(super) fn centre(&self) -> At {
        let (height, width) = self.state.layout.size.shape();
        At {
            y: height / 2,
            x: width / 2,
        }
    }

    /// What it holds.
    pub(super) fn cell(&self, register: Analog) -> &D::Cell {
        let At { y, x } = self.centre();
        &self.state.analog(register)[y * self.state.layout.size.width + x]
    }

    /// Runs the steps; `after` sees every word.
    pub(super) fn run(
        &mut self,
        steps: &[Step],
        after: &mut impl FnMut(&Self, Ran<'_>),
    ) -> Result<(), GenericError> {
        for step in steps {
            match &step.action {
                Action::Word(word) => {
                    self.word(word, step.line)?;
                    let line = step.line;
                    after(self, Ran { line, word });
                }
                Action::Host(operation) => self.host(operation, step.line),
                Action::Repeat { times, body } => {
                    for _ in 0..*times {
                        self.run(body, after)?;
                    }
                }
            }
        }
        Ok(())
    }

    fn word(&mut self, word: &Primitive, line: u32) -> Result<(), GenericError> {
        let number = self.words.len() as u64;
        let text = word.text(self.device);
        self.words.push((line, text.clone()));
        let operands = self.device.operands(word);
        match (operands.unit, operands.flag) {
            // Its gates are bits; only those that were never written are known.
            (Unit::Diffusion, _) => return Err(GenericError::Place { line, what: text }),
            // The bits may come from an unknown FLAG.
            (Unit::Logic, FlagEffect::May) => {
                self.unknown = true;
                return Ok(());
            }
            (_, FlagEffect::Sets) => self.unknown = false,
            (_, FlagEffect::May | FlagEffect::Keeps) => {}
        }
        let input = self.state.input.clone();
        let before = self.unknown.then(|| self.state.analog.clone());
        let result = execute(
            self.domain,
            &self.settings,
            &mut self.state,
            word,
            &input,
            number,
        );
        match (operands.flag, result) {
            (FlagEffect::May, result) => {
                // All or none: the border may differ, the generic pixel decides.
                let At { y, x } = self.centre();
                let on = self.state.flag.get(y, x);
                self.unknown = result.is_err() || !on;
                self.state.flag.fill(true);
            }
            (_, Err(Undecided { .. })) => return Err(GenericError::Place { line, what: text }),
            (_, Ok(())) => {}
        }
        if let Some(before) = before {
            for (plane, before) in self.state.analog.iter_mut().zip(&before) {
                for (cell, old) in plane.iter_mut().zip(before.iter()) {
                    if cell != old {
                        *cell = self.domain.either(old, cell, number);
                    }
                }
            }
        }
        Ok(())
    }

    fn host(&mut self, operation: &Host, line: u32) {
        match operation {
            Host::LoadIn { .. } | Host::LoadInRaw { .. } | Host::LoadDac { .. } => {
                host::execute(
                    self.domain,
                    &self.settings.converters,
                    &mut self.state,
                    operation,
                );
            }
            // They look, or they change bits, which matter by way of FLAG alone.
            Host::ScanEvents { .. }
            | Host::ReadAnalog { .. }
            | Host::ReadPixel { .. }
            | Host::ScanAnalog { .. }
            | Host::ScanBlocks { .. }
            | Host::ScanDigital { .. }
            | Host::ScanBoundingBox { .. }
            | Host::GlobalSum { .. }
            | Host::GlobalOr { .. }
            | Host::Load { .. }
            | Host::Select { .. }
            | Host::DrawBegin { .. }
            | Host::Draw { .. }
            | Host::DrawEnd => {}
            // Whether each bit is 1 is not known.
            Host::GlobalCount { temporary, .. } => {
                let number = self.words.len() as u64;
                self.words.push((line, operation.text(self.device)));
                let (low, high) = self.settings.range();
                let [set, clear] = [high, low].map(|lsb| self.domain.hold(lsb));
                let either = self.domain.either(&set, &clear, number);
                self.state.analog_mut(*temporary).fill(either);
            }
        }
    }
}

/// How much work it is to go through these steps on a generic pixel: instruction words that run,
/// times pixels around it. None where the program reaches too far.
#[must_use]
pub fn effort(steps: &[Step], device: &Device) -> Option<u64> {
    let (rows, columns) = reach(steps, device);
    if rows.max(columns) > FARTHEST {
        return None;
    }
    let words = Cost::of(steps, device).words.0;
    let cells = (2 * rows + 1) * (2 * columns + 1);
    Some(words.saturating_mul(cells as u64))
}

/// How far, in rows and columns, what goes in can lie from where it arrives, as far as
/// [`FARTHEST`] and one word beyond. Bits count only by way of FLAG, which is taken as unknown.
pub(in crate::array) fn reach(steps: &[Step], device: &Device) -> (usize, usize) {
    let mut far = Far {
        device,
        of: BTreeMap::new(),
        most: (0, 0),
        whole: true,
    };
    far.steps(steps);
    far.most
}

/// From how far what each register holds may come, word by word: what is written comes from as
/// far as what is read, and the way between the two.
struct Far<'a> {
    device: &'a Device,
    of: BTreeMap<Analog, (usize, usize)>,
    most: (usize, usize),
    /// Whether FLAG is 1 everywhere.
    whole: bool,
}

impl Far<'_> {
    fn steps(&mut self, steps: &[Step]) {
        for step in steps {
            if self.most.0.max(self.most.1) > FARTHEST {
                return;
            }
            match &step.action {
                Action::Word(word) => self.word(word),
                Action::Host(_) => {}
                Action::Repeat { times, body } => {
                    for _ in 0..*times {
                        let before = (self.of.clone(), self.whole);
                        self.steps(body);
                        let far = self.most.0.max(self.most.1) > FARTHEST;
                        if far || before == (self.of.clone(), self.whole) {
                            break;
                        }
                    }
                }
            }
        }
    }

    /// What decides over FLAG must lie around the generic pixel as well: off the array it is known.
    fn decides(&mut self, operands: &Operands) {
        for read in operands.reads() {
            let Some(register) = read.analog() else {
                continue;
            };
            let (rows, columns) = self.of.get(&register).copied().unwrap_or_default();
            let (down, right) = read.offset;
            self.most.0 = self.most.0.max(rows + down.unsigned_abs());
            self.most.1 = self.most.1.max(columns + right.unsigned_abs());
        }
    }

    fn word(&mut self, word: &Primitive) {
        let operands = self.device.operands(word);
        match operands.flag {
            FlagEffect::Keeps => {}
            FlagEffect::Sets => self.whole = true,
            FlagEffect::May => self.whole = false,
        }
        if operands.flag == FlagEffect::May {
            self.decides(&operands);
        }
        if !matches!(operands.unit, Unit::Bus | Unit::Squarer) {
            return;
        }
        let apart = |a: (isize, isize), b: (isize, isize)| {
            ((a.0 - b.0).unsigned_abs(), (a.1 - b.1).unsigned_abs())
        };
        // A word may write a register from several sides.
        let mut written = BTreeMap::new();
        for write in operands.writes() {
            let Some(register) = write.analog() else {
                continue;
            };
            let mut far = (0, 0);
            for read in operands.reads() {
                let of = read.analog().and_then(|r| self.of.get(&r));
                let (rows, columns) = of.copied().unwrap_or_default();
                let (down, right) = apart(write.offset, read.offset);
                far = (far.0.max(rows + down), far.1.max(columns + right));
            }
            let all: &mut (usize, usize) = written.entry(register).or_default();
            *all = (all.0.max(far.0), all.1.max(far.1));
        }
        let replaces = operands.replaces(self.whole);
        for (register, far) in written {
            let old = self.of.entry(register).or_default();
            *old = if replaces {
                far
            } else {
                (old.0.max(far.0), old.1.max(far.1))
            };
            self.most = (self.most.0.max(old.0), self.most.1.max(old.1));
        }
    }
}
