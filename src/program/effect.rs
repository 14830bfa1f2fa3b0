//! Effects of steps: the cells that they read and write, folded over the operands of their words.

use std::collections::BTreeSet;

use super::{Action, Host, Step};
use crate::isa::{Cell, Device, operands::FlagEffect};

/// The effect of some steps on a pixel's cells.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CellEffect {
    /// Cells that are read before the steps write them.
    pub reads: BTreeSet<Cell>,
    /// Cells that are written.
    pub writes: BTreeSet<Cell>,
    /// FLAG after the last step that touches it; `None` if none does.
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

impl CellEffect {
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
                    let operands = device.operands(word);
                    match operands.flag {
                        FlagEffect::Keeps => {}
                        FlagEffect::Sets => self.flag = Some(FlagState::Whole),
                        FlagEffect::May => self.flag = Some(FlagState::Partial),
                    }
                    let reads = operands.cells_read().collect();
                    (reads, operands.cells_written().collect())
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
