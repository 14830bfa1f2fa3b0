//! How far the inputs of a pixel lie: the light and the registers before a body that what it
//! leaves there, or what the host reads there, can depend on.

use std::collections::{BTreeMap, BTreeSet};

use crate::{
    isa::{
        Cell, Device, Primitive,
        operands::{FlagEffect, Unit},
    },
    program::{Action, Host, Step},
};

/// A body of a frame, taken apart, and how far it reaches.
#[derive(Clone, Debug)]
pub(super) struct Cone {
    /// Where FLAG is 1 in all pixels beforehand.
    pub(super) whole: Inputs,
    /// Where it is not.
    pub(super) partial: Inputs,
    /// Cells that the body reads or writes, or the host looks at.
    pub(super) used: BTreeSet<Cell>,
    /// Cells that the body writes.
    pub(super) written: BTreeSet<Cell>,
    /// Of each look of the host: whether the body writes the cell afterwards.
    pub(super) passing: Vec<bool>,
    /// Words, and those among them for which FLAG may not be 1 in all pixels.
    pub(super) words: [usize; 2],
}

/// What a body depends on, besides the light, FLAG and the global input.
#[derive(Clone, Debug, Default)]
pub(super) struct Inputs {
    /// How far away, in rows and columns.
    pub(super) reach: [usize; 2],
    /// Cells that are not overwritten, in all pixels, before they are read or the body ends.
    pub(super) cells: BTreeSet<Cell>,
}

/// As many words are followed at most.
const WORDS: usize = 1 << 16;

impl Cone {
    /// `None` where a pixel cannot be looked at with its surroundings alone: the host changes
    /// the array, a bit propagates, or it would take too long to find out.
    pub(super) fn of(body: &[Step], device: &Device) -> Option<Self> {
        let along = |whole| {
            let mut walk = Walk {
                device,
                far: BTreeMap::new(),
                whole,
                inputs: Inputs::default(),
                words: [0; 2],
                used: BTreeSet::new(),
                written: BTreeSet::new(),
                passing: Vec::new(),
                looks: BTreeMap::new(),
            };
            walk.steps(body)?;
            let reach = &mut walk.inputs.reach;
            *reach = walk.far.values().copied().fold(*reach, farther);
            Some(walk)
        };
        let (whole, partial) = (along(true)?, along(false)?);
        Some(Self {
            passing: whole.passing,
            whole: whole.inputs,
            partial: partial.inputs,
            used: whole.used,
            written: whole.written,
            words: whole.words,
        })
    }
}

fn farther(one: [usize; 2], other: [usize; 2]) -> [usize; 2] {
    [one[0].max(other[0]), one[1].max(other[1])]
}

struct Walk<'a> {
    device: &'a Device,
    /// Of what each cell holds.
    far: BTreeMap<Cell, [usize; 2]>,
    /// Whether FLAG is 1 in all pixels.
    whole: bool,
    inputs: Inputs,
    words: [usize; 2],
    used: BTreeSet<Cell>,
    written: BTreeSet<Cell>,
    passing: Vec<bool>,
    /// Looks of the host at what each cell still holds.
    looks: BTreeMap<Cell, Vec<usize>>,
}

impl Walk<'_> {
    fn steps(&mut self, steps: &[Step]) -> Option<()> {
        for step in steps {
            match &step.action {
                Action::Word(word) => self.word(word)?,
                Action::Host(host) => {
                    if let Some(cell) = looked_at(host) {
                        self.count()?;
                        self.inputs.reach = farther(self.inputs.reach, self.of(cell));
                        self.read(cell);
                        self.looks.entry(cell).or_default().push(self.passing.len());
                        self.passing.push(false);
                    } else if !is_input(host) {
                        return None;
                    }
                }
                Action::Repeat { times, body } => {
                    for _ in 0..*times {
                        self.steps(body)?;
                    }
                }
            }
        }
        Some(())
    }

    fn of(&self, cell: Cell) -> [usize; 2] {
        self.far.get(&cell).copied().unwrap_or([0; 2])
    }

    /// One more word or look.
    fn count(&mut self) -> Option<()> {
        self.words[0] += 1;
        self.words[1] += usize::from(!self.whole);
        (self.words[0] <= WORDS).then_some(())
    }

    /// A cell is read.
    fn read(&mut self, cell: Cell) {
        self.used.insert(cell);
        if !self.far.contains_key(&cell) {
            self.inputs.cells.insert(cell);
        }
    }

    fn word(&mut self, word: &Primitive) -> Option<()> {
        self.count()?;
        let operands = self.device.operands(word);
        if operands.unit == Unit::Propagation {
            return None;
        }
        for cell in operands.cells_read() {
            self.read(cell);
        }
        let from = operands.cells_read().map(|cell| self.of(cell));
        let from = from.fold([0; 2], farther);
        let halo = operands.halo();
        let new = [from[0] + halo[0], from[1] + halo[1]];
        for cell in operands.cells_written() {
            let old = if operands.replaces(self.whole) {
                [0; 2]
            } else {
                // What it held stays in some pixels.
                self.read(cell);
                self.of(cell)
            };
            for look in self.looks.remove(&cell).into_iter().flatten() {
                self.passing[look] = true;
            }
            self.far.insert(cell, farther(old, new));
            self.used.insert(cell);
            self.written.insert(cell);
            if cell == Cell::Flag {
                self.whole = operands.flag == FlagEffect::Sets;
            }
        }
        Some(())
    }
}

/// Whether the host only sets the global input.
pub(super) const fn is_input(host: &Host) -> bool {
    matches!(
        host,
        Host::LoadIn { .. } | Host::LoadInRaw { .. } | Host::LoadDac { .. }
    )
}

/// The register that the host reads and leaves as it is.
pub(super) const fn looked_at(host: &Host) -> Option<Cell> {
    match host {
        Host::ScanEvents { source, .. }
        | Host::ScanEventsFrom { source, .. }
        | Host::ScanDigital { source, .. }
        | Host::ScanBoundingBox { source }
        | Host::GlobalOr { source, .. } => Some(Cell::Digital(*source)),
        Host::ReadAnalog { source }
        | Host::ReadPixel { source, .. }
        | Host::ScanAnalog { source, .. }
        | Host::ScanBlocks { source, .. }
        | Host::GlobalSum { source, .. } => Some(Cell::Analog(*source)),
        Host::LoadIn { .. }
        | Host::LoadInRaw { .. }
        | Host::LoadDac { .. }
        | Host::GlobalCount { .. }
        | Host::Load { .. }
        | Host::Select { .. }
        | Host::DrawBegin { .. }
        | Host::Draw { .. }
        | Host::DrawEnd => None,
    }
}
