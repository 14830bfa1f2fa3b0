//! How far the inputs of a pixel lie: the light and the registers before a body that what it
//! leaves there, or what the host reads there, can depend on.

use std::collections::{BTreeMap, BTreeSet};

use super::reach;
use crate::{
    isa::{Device, Primitive},
    program::{Action, Cell, Host, Step, reads, writes},
};

/// A body of a frame, taken apart, and how far it reaches.
#[derive(Clone, Debug)]
pub(super) struct Cone {
    /// In rows and columns, where FLAG is 1 in all pixels beforehand.
    pub(super) whole: [usize; 2],
    /// The same, where it is not.
    pub(super) partial: [usize; 2],
    /// Cells that the body reads or writes, or the host looks at.
    pub(super) used: BTreeSet<Cell>,
    /// Cells that the body writes.
    pub(super) written: BTreeSet<Cell>,
}

/// As many words are followed at most.
const WORDS: usize = 1 << 16;

impl Cone {
    /// `None` where a pixel cannot be looked at with its surroundings alone: the host changes
    /// the array, a bit propagates, or it would take too long to find out.
    pub(super) fn of(body: &[Step], device: &Device) -> Option<Self> {
        let (mut used, mut written) = (BTreeSet::new(), BTreeSet::new());
        let mut along = |whole| {
            let mut walk = Walk {
                device,
                far: BTreeMap::new(),
                whole,
                seen: [0; 2],
                words: 0,
                used: BTreeSet::new(),
                written: BTreeSet::new(),
            };
            walk.steps(body)?;
            used.append(&mut walk.used);
            written.append(&mut walk.written);
            Some(walk.far.into_values().fold(walk.seen, farther))
        };
        let (whole, partial) = (along(true)?, along(false)?);
        Some(Self {
            whole,
            partial,
            used,
            written,
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
    /// Of what the host has read.
    seen: [usize; 2],
    words: usize,
    used: BTreeSet<Cell>,
    written: BTreeSet<Cell>,
}

impl Walk<'_> {
    fn steps(&mut self, steps: &[Step]) -> Option<()> {
        for step in steps {
            match &step.action {
                Action::Word(word) => self.word(word)?,
                Action::Host(host) => {
                    if let Some(cell) = looked_at(host) {
                        self.seen = farther(self.seen, self.of(cell));
                        self.used.insert(cell);
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

    fn word(&mut self, word: &Primitive) -> Option<()> {
        self.words += 1;
        if self.words > WORDS || matches!(word, Primitive::Prop { .. }) {
            return None;
        }
        let roles = self.device.registers().roles;
        let mut read = reads(word, self.device);
        if matches!(word, Primitive::Blur { .. }) {
            read.extend(roles.enable.map(Cell::Digital));
        }
        self.used.extend(&read);
        let from = read.into_iter().map(|cell| self.of(cell));
        let from = from.fold([0; 2], farther);
        let reach = reach::reaches(word);
        let new = [from[0] + reach[0], from[1] + reach[1]];
        for cell in writes(word, self.device) {
            let replaced = match cell {
                Cell::Analog(_) => self.whole,
                Cell::Digital(register) => register != roles.propagated,
                Cell::Flag => true,
            };
            let old = if replaced { [0; 2] } else { self.of(cell) };
            self.far.insert(cell, farther(old, new));
            self.used.insert(cell);
            self.written.insert(cell);
            if cell == Cell::Flag {
                self.whole = matches!(word, Primitive::All);
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
