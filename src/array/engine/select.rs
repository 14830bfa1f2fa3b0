//! Instruction selection: words become operations on rows.
//!
//! Which words have a row form, and which, is said beside their meaning: see
//! [`row_form`](super::super::semantics::row_form).

use std::ops::Range;

use super::{
    super::{Layout, Share, semantics::RowForm},
    instruction::Word,
    liveness::{Known, Live},
    operation::{
        Border, BusInput, Diffusion, FusedStore, Logic, MaskedLogic, Neighbours, Operation, Store,
    },
    planes,
};
use crate::isa::{Bit, Source, Target};

/// Operations, in order.
#[derive(Clone, Debug, Default)]
pub(super) struct Operations {
    pub(super) operations: Vec<Operation>,
    pub(super) bus_inputs: Vec<BusInput>,
}

impl Operations {
    /// One more word, in its row form; `copied`: it reads the copy of a register.
    pub(super) fn word(
        &mut self,
        word: &Word,
        form: RowForm<'_>,
        copied: bool,
        layout: &Layout,
        known: Known,
    ) {
        let step = word.step;
        match form {
            RowForm::Nothing => {}
            RowForm::Reset => self.operations.push(Operation::Reset),
            RowForm::Bus { targets, sources } => {
                let bus_inputs = self.bus_inputs(sources, word, copied, layout);
                self.bus(targets, &bus_inputs, step, layout, known);
            }
            RowForm::Square { sources } => {
                let bus_inputs = self.bus_inputs(sources, word, copied, layout);
                self.operations.push(Operation::Square { bus_inputs, step });
            }
            RowForm::Sign { sources } => {
                let bus_inputs = self.bus_inputs(sources, word, copied, layout);
                let border = Border::new(&self.bus_inputs[bus_inputs.clone()], (0, 0));
                self.operations.push(Operation::Sign { bus_inputs, border });
            }
            RowForm::Diffusion {
                target,
                source,
                horizontal,
                vertical,
            } => self.operations.push(Operation::Diffusion(Diffusion {
                target,
                source,
                horizontal,
                vertical,
                step,
            })),
            RowForm::Constant { targets, value } => {
                // R12 first: it goes by R0 as it was before this word.
                let propagated = layout.roles.propagated;
                let masked = targets.iter().filter(|target| **target == propagated);
                let others = targets.iter().filter(|target| **target != propagated);
                for target in masked.chain(others) {
                    self.logic(Bit::Register(*target), &[], value, layout);
                }
            }
            RowForm::Logic {
                target,
                sources,
                not,
            } => self.logic(target, sources, not, layout),
            RowForm::Neighbours {
                target,
                source,
                boundary,
            } => self.operations.push(Operation::Neighbours(Neighbours {
                target,
                source,
                boundary,
            })),
        }
    }

    /// Makes the last two operations one; whether it did. `live`: as after the last.
    pub(super) fn join(&mut self, live: Live) -> bool {
        let [.., Operation::Store(first), Operation::Store(second)] = &self.operations[..] else {
            return false;
        };
        if live.has(first.register) {
            return false;
        }
        let Some(pair) = FusedStore::new(first, second, &self.bus_inputs) else {
            return false;
        };
        self.operations.truncate(self.operations.len() - 2);
        self.operations.push(Operation::Fused(Box::new(pair)));
        true
    }

    /// `target := [not] any source`: of no source it is a constant.
    fn logic(&mut self, target: Bit, sources: &[Bit], not: bool, layout: &Layout) {
        let few = Logic::new(target, sources, not, layout).map(Operation::Logic);
        let any = || MaskedLogic::new(target, sources, not, layout).map(Operation::MaskedLogic);
        self.operations.extend(few.or_else(any));
    }

    fn bus(
        &mut self,
        targets: &[Target],
        bus_inputs: &Range<usize>,
        step: u64,
        layout: &Layout,
        known: Known,
    ) {
        let place = |target: &Target| match target {
            Target::Register(register) => (*register, (0, 0)),
            Target::Neighbour(direction) => (layout.news, direction.step()),
        };
        let to_news = |target: &&Target| place(target).0 == layout.news;
        let several = targets.iter().filter(to_news).count() > 1;
        let share = |part| Share::new(targets.len(), part);
        for (part, target) in targets.iter().enumerate() {
            let (register, beside) = place(target);
            let lost = known.whole && !known.live.has(register);
            if lost || (several && register == layout.news) {
                continue;
            }
            let bus = &self.bus_inputs[bus_inputs.clone()];
            let border = Border::new(bus, beside);
            let planes = planes::count(layout);
            self.operations.push(Operation::Store(Store {
                bus_inputs: bus_inputs.clone(),
                register,
                share: share(part),
                beside,
                interior: known.whole
                    && matches!(bus.len(), 1..=3)
                    && bus.iter().all(|bus_input| bus_input.plane < planes),
                border,
                whole: known.whole,
                step,
            }));
        }
        if several {
            let driven = targets
                .iter()
                .enumerate()
                .filter(|(_, target)| to_news(target))
                .map(|(part, target)| (place(target).1, share(part)));
            self.operations.push(Operation::Drive {
                bus_inputs: bus_inputs.clone(),
                driven: driven.collect(),
                step,
            });
        }
    }

    /// What the sources put on the bus.
    fn bus_inputs(
        &mut self,
        sources: &[Source],
        word: &Word,
        copied: bool,
        layout: &Layout,
    ) -> Range<usize> {
        let first = self.bus_inputs.len();
        let news = if copied {
            planes::copy(layout)
        } else {
            usize::from(layout.news.0)
        };
        self.bus_inputs.extend(sources.iter().map(|source| {
            let (plane, beside) = match source {
                Source::Register(register) if *register == layout.news => (news, (0, 0)),
                Source::Register(register) => (usize::from(register.0), (0, 0)),
                Source::Pix => (planes::light(layout), (0, 0)),
                Source::In => (planes::count(layout) + word.input, (0, 0)),
                Source::Neighbour(direction) => (news, direction.step()),
            };
            BusInput { plane, beside }
        }));
        first..self.bus_inputs.len()
    }
}
