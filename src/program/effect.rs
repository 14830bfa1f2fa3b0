//! What a word reads and writes: the ground of every check.

use std::collections::BTreeSet;

use super::{Action, Host, Step};
use crate::isa::{Analog, Bit, Device, Digital, Primitive, Source, Target};

/// A cell of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Cell {
    /// An analogue register.
    Analog(Analog),
    /// A one-bit register.
    Digital(Digital),
    /// The activity flag.
    Flag,
}

impl Cell {
    /// Its name on a chip.
    #[must_use]
    pub fn name(self, device: &Device) -> String {
        match self {
            Self::Analog(register) => device.analog_name(register),
            Self::Digital(register) => device.digital_name(register),
            Self::Flag => "FLAG".to_owned(),
        }
    }
}

/// What some steps do to a pixel's cells.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Effect {
    /// Read before the steps themselves have written them.
    pub reads: BTreeSet<Cell>,
    /// Written.
    pub writes: BTreeSet<Cell>,
    /// What the last of them that touches FLAG leaves in it.
    pub flag: Option<FlagState>,
}

/// What is known about FLAG.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlagState {
    /// 1 everywhere.
    Whole,
    /// Perhaps 0 somewhere.
    Partial,
}

impl Effect {
    /// Of some steps, one after the other.
    #[must_use]
    pub fn of(steps: &[Step], device: &Device) -> Self {
        let mut effect = Self::default();
        effect.add(steps, device);
        effect
    }

    fn add(&mut self, steps: &[Step], device: &Device) {
        for step in steps {
            let (reads, writes) = match &step.action {
                Action::Word(word) => {
                    match word {
                        Primitive::All => self.flag = Some(FlagState::Whole),
                        Primitive::Where { .. } | Primitive::WhereBit { .. } => {
                            self.flag = Some(FlagState::Partial);
                        }
                        Primitive::Nop
                        | Primitive::ResetPix
                        | Primitive::Bus { .. }
                        | Primitive::Square { .. }
                        | Primitive::BlurSet
                        | Primitive::Blur { .. }
                        | Primitive::Set { .. }
                        | Primitive::Clear { .. }
                        | Primitive::Or { .. }
                        | Primitive::Nor { .. }
                        | Primitive::Dnews { .. }
                        | Primitive::PropRead
                        | Primitive::Prop { .. } => {}
                    }
                    (reads(word, device), writes(word, device))
                }
                Action::Host(host) => of_host(host),
                Action::Repeat { times: 0, .. } => continue,
                Action::Repeat { body, .. } => {
                    self.add(body, device);
                    continue;
                }
            };
            for cell in reads {
                if !self.writes.contains(&cell) {
                    self.reads.insert(cell);
                }
            }
            self.writes.extend(writes);
        }
    }
}

fn source(source: Source, device: &Device) -> Option<Cell> {
    match source {
        Source::Register(register) => Some(Cell::Analog(register)),
        Source::Neighbour(_) => Some(Cell::Analog(device.news())),
        Source::Pix | Source::In => None,
    }
}

fn bit(bit: Bit) -> Option<Cell> {
    match bit {
        Bit::Register(register) => Some(Cell::Digital(register)),
        Bit::Flag => Some(Cell::Flag),
        Bit::Select | Bit::Rect => None,
    }
}

/// The cells that a word reads, FLAG and masks included.
#[must_use]
pub fn reads(word: &Primitive, device: &Device) -> Vec<Cell> {
    let roles = device.registers().roles;
    let enables = || roles.enable.into_iter().map(Cell::Digital);
    let sources =
        |list: &[Source]| -> Vec<Cell> { list.iter().filter_map(|s| source(*s, device)).collect() };
    let bits = |list: &[Bit]| -> Vec<Cell> { list.iter().filter_map(|b| bit(*b)).collect() };
    let masked =
        |target: &Digital| (*target == roles.propagated).then_some(Cell::Digital(roles.mask));
    match word {
        Primitive::Nop | Primitive::ResetPix | Primitive::All => Vec::new(),
        Primitive::Bus { sources: list, .. } | Primitive::Square { sources: list } => {
            let mut cells = sources(list);
            cells.push(Cell::Flag);
            cells
        }
        Primitive::Where { sources: list } => sources(list),
        Primitive::BlurSet => vec![
            Cell::Digital(roles.enables(crate::isa::Direction::South)),
            Cell::Digital(roles.enables(crate::isa::Direction::West)),
        ],
        Primitive::Blur { source, .. } => vec![Cell::Analog(*source), Cell::Flag],
        Primitive::Set { targets } | Primitive::Clear { targets } => {
            targets.iter().filter_map(masked).collect()
        }
        Primitive::Or { target, sources } | Primitive::Nor { target, sources } => {
            let mut cells = bits(sources);
            cells.extend(masked(target));
            cells
        }
        Primitive::WhereBit { sources } => bits(sources),
        Primitive::Dnews { target, source, .. } => bits(std::slice::from_ref(source))
            .into_iter()
            .chain(enables())
            .chain(masked(target))
            .collect(),
        Primitive::PropRead => vec![Cell::Digital(roles.propagated)],
        Primitive::Prop { .. } => enables()
            .chain([Cell::Digital(roles.propagated), Cell::Digital(roles.mask)])
            .collect(),
    }
}

/// The cells that a word writes.
#[must_use]
pub fn writes(word: &Primitive, device: &Device) -> Vec<Cell> {
    let roles = device.registers().roles;
    match word {
        Primitive::Nop | Primitive::ResetPix | Primitive::BlurSet | Primitive::PropRead => {
            Vec::new()
        }
        Primitive::Bus { targets, .. } => targets
            .iter()
            .map(|target| match target {
                Target::Register(register) => Cell::Analog(*register),
                Target::Neighbour(_) => Cell::Analog(device.news()),
            })
            .collect(),
        Primitive::Square { .. } => vec![Cell::Analog(device.news())],
        Primitive::Where { .. } | Primitive::WhereBit { .. } | Primitive::All => vec![Cell::Flag],
        Primitive::Blur { target, .. } => vec![Cell::Analog(*target)],
        Primitive::Set { targets } | Primitive::Clear { targets } => {
            targets.iter().copied().map(Cell::Digital).collect()
        }
        Primitive::Or { target, .. }
        | Primitive::Nor { target, .. }
        | Primitive::Dnews { target, .. } => vec![Cell::Digital(*target)],
        Primitive::Prop { .. } => vec![Cell::Digital(roles.propagated)],
    }
}

/// The cells that a host operation reads and writes.
fn of_host(host: &Host) -> (Vec<Cell>, Vec<Cell>) {
    match host {
        Host::LoadIn { .. }
        | Host::LoadInRaw { .. }
        | Host::LoadDac { .. }
        | Host::Select { .. }
        | Host::DrawBegin { .. }
        | Host::DrawEnd => (vec![], vec![]),
        Host::ScanEvents { source, .. }
        | Host::ScanEventsFrom { source, .. }
        | Host::ScanDigital { source, .. }
        | Host::ScanBoundingBox { source }
        | Host::GlobalOr { source, .. } => (vec![Cell::Digital(*source)], vec![]),
        Host::ReadAnalog { source }
        | Host::ReadPixel { source, .. }
        | Host::ScanAnalog { source, .. }
        | Host::ScanBlocks { source, .. }
        | Host::GlobalSum { source, .. } => (vec![Cell::Analog(*source)], vec![]),
        Host::GlobalCount {
            source, temporary, ..
        } => (vec![Cell::Digital(*source)], vec![Cell::Analog(*temporary)]),
        Host::Load { target, .. } => (vec![], vec![Cell::Digital(*target)]),
        Host::Draw { target, .. } => (vec![Cell::Digital(*target)], vec![Cell::Digital(*target)]),
    }
}
