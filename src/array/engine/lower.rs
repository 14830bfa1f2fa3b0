//! A body lowered, once, when a chip is made: basic blocks, and what the host does between them.

use std::sync::Arc;

use super::{
    super::{Layout, Ledger},
    block::Block,
    pass::Lowering,
};
use crate::{
    isa::{Cell, Device, Digital},
    program::{Action, CellEffect, Host, Step},
};

/// Words and inputs of a block, at most: loops are unrolled so far.
const FULL: usize = 1024;

/// A body, lowered.
#[derive(Clone, Debug, Default)]
pub(in crate::array) struct Lowered {
    pub(in crate::array) stages: Vec<Stage>,
    pub(in crate::array) blocks: Vec<Counted>,
    /// One-bit registers that it writes.
    pub(in crate::array) refreshed: Vec<Digital>,
}

/// A block, and what its words cost.
#[derive(Clone, Debug, Default)]
pub(in crate::array) struct Counted {
    pub(in crate::array) block: Block,
    pub(in crate::array) cost: Ledger,
}

/// One thing after the other.
#[derive(Clone, Debug)]
pub(in crate::array) enum Stage {
    /// Which block.
    Block(usize),
    /// A wave of bits over the whole array.
    Propagate {
        boundary: bool,
        cost: Ledger,
    },
    Host {
        operation: Host,
        line: u32,
        origin: Option<Arc<str>>,
    },
    Repeat {
        times: u32,
        body: Vec<Self>,
    },
}

impl Lowered {
    /// Of a body on this chip.
    pub(in crate::array) fn new(
        body: &[Step],
        device: &Device,
        layout: &Layout,
        lowering: Lowering,
    ) -> Self {
        let mut lowerer = Lowerer {
            device,
            layout,
            lowering,
            open: Counted::default(),
            blocks: Vec::new(),
        };
        let mut stages = Vec::new();
        lowerer.body(body, &mut stages);
        lowerer.close(&mut stages);
        let writes = CellEffect::of(body, device).writes.into_iter();
        Self {
            stages,
            blocks: lowerer.blocks,
            refreshed: writes.filter_map(digital).collect(),
        }
    }
}

fn digital(cell: Cell) -> Option<Digital> {
    match cell {
        Cell::Digital(register) => Some(register),
        Cell::Analog(_) | Cell::Flag => None,
    }
}

/// Gathers words until something else comes.
struct Lowerer<'a> {
    device: &'a Device,
    layout: &'a Layout,
    lowering: Lowering,
    open: Counted,
    blocks: Vec<Counted>,
}

impl Lowerer<'_> {
    /// The last block stays open: words may follow.
    fn body(&mut self, body: &[Step], stages: &mut Vec<Stage>) {
        let mut launched = false;
        for step in body {
            let launches = matches!(step.action, Action::Word(_)) && !launched;
            launched = matches!(step.action, Action::Word(_));
            match &step.action {
                Action::Word(word) => {
                    if let Some(boundary) = word.propagates_from() {
                        self.close(stages);
                        let mut cost = Ledger::default();
                        cost.word(word, self.device);
                        cost.launches += u64::from(launches);
                        stages.push(Stage::Propagate { boundary, cost });
                    } else {
                        self.open.cost.word(word, self.device);
                        self.open.cost.launches += u64::from(launches);
                        self.open.block.push(word, step.line);
                        self.close_if_full(stages);
                    }
                }
                Action::Host(operation) if operation.is_input() => {
                    self.open.block.inputs.push(operation.clone());
                    self.close_if_full(stages);
                }
                Action::Host(operation) => {
                    self.close(stages);
                    stages.push(Stage::Host {
                        operation: operation.clone(),
                        line: step.line,
                        origin: step.origin.clone(),
                    });
                }
                Action::Repeat { times, body } => self.repeat(*times, body, stages),
            }
        }
    }

    /// A loop: what lies in one block is unrolled, as far as a block holds it.
    fn repeat(&mut self, times: u32, body: &[Step], stages: &mut Vec<Stage>) {
        let Some(len) = straight(body).filter(|len| *len <= FULL) else {
            return self.rolled(times, 1, body, stages);
        };
        if len == 0 {
            return;
        }
        if len.saturating_mul(times as usize) <= FULL.saturating_sub(self.open.block.len()) {
            self.unrolled(times, body, stages);
            return;
        }
        let unrolled = (FULL / len) as u32;
        self.rolled(times / unrolled, unrolled, body, stages);
        self.unrolled(times % unrolled, body, stages);
    }

    /// `unrolled` bodies, `times` over, in blocks of their own.
    fn rolled(&mut self, times: u32, unrolled: u32, body: &[Step], stages: &mut Vec<Stage>) {
        self.close(stages);
        if times == 0 {
            return;
        }
        let mut inner = Vec::new();
        self.unrolled(unrolled, body, &mut inner);
        self.close(&mut inner);
        stages.push(Stage::Repeat { times, body: inner });
    }

    fn unrolled(&mut self, times: u32, body: &[Step], stages: &mut Vec<Stage>) {
        for _ in 0..times {
            self.body(body, stages);
        }
    }

    fn close_if_full(&mut self, stages: &mut Vec<Stage>) {
        if self.open.block.len() >= FULL {
            self.close(stages);
        }
    }

    fn close(&mut self, stages: &mut Vec<Stage>) {
        if self.open.block.len() == 0 {
            return;
        }
        let mut counted = std::mem::take(&mut self.open);
        counted.block.lower(self.layout, self.lowering);
        stages.push(Stage::Block(self.blocks.len()));
        self.blocks.push(counted);
    }
}

/// Words and inputs of a body that goes into one block; `None` where it does not.
fn straight(body: &[Step]) -> Option<usize> {
    body.iter().try_fold(0, |len: usize, step| {
        let more = match &step.action {
            Action::Word(word) => word.propagates_from().is_none().then_some(1),
            Action::Host(operation) => operation.is_input().then_some(1),
            Action::Repeat { times, body } => {
                straight(body).map(|len| len.saturating_mul(*times as usize))
            }
        };
        Some(len.saturating_add(more?))
    })
}
