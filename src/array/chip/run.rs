//! A lowered body run: blocks of words, host operations between them.

use std::sync::Arc;

use super::{
    super::{
        Reading, RowOps, Scanned,
        engine::{Counted, Lowered, Semantics, Stage},
        host, propagate,
    },
    Chip, RunError,
};
use crate::{
    event::{Event, Packet, Polarity},
    program::Host,
    unit::Micros,
};

impl<D: RowOps> Chip<D> {
    pub(super) fn run(
        &mut self,
        body: &Lowered,
        t: Micros,
        packet: &mut Packet,
    ) -> Result<(), RunError> {
        self.refresh(&body.refreshed);
        self.stages(&body.stages, &body.blocks, t, packet)
    }

    fn stages(
        &mut self,
        stages: &[Stage],
        blocks: &[Counted],
        t: Micros,
        packet: &mut Packet,
    ) -> Result<(), RunError> {
        for stage in stages {
            match stage {
                Stage::Block(k) => self.block(&blocks[*k])?,
                Stage::Propagate { boundary, cost } => {
                    self.ledger.block(cost);
                    propagate::propagate(&mut self.state, self.settings.propagation, *boundary);
                    self.step += 1;
                }
                Stage::Host {
                    operation,
                    line,
                    origin,
                } => {
                    self.ledger.host(operation, &self.device);
                    self.host(operation, (*line, origin.as_ref()), t, packet);
                }
                Stage::Repeat { times, body } => {
                    for _ in 0..*times {
                        self.stages(body, blocks, t, packet)?;
                    }
                }
            }
        }
        Ok(())
    }

    fn block(&mut self, Counted { block, cost }: &Counted) -> Result<(), RunError> {
        self.ledger.block(cost);
        let converters = &self.settings.converters;
        let inputs = block.inputs.iter().filter_map(|operation| {
            self.ledger.host(operation, &self.device);
            host::input(&self.domain, converters, operation)
        });
        self.engine.begin(self.step, &self.state.input, inputs);
        let semantics = Semantics {
            domain: &self.domain,
            settings: &self.settings,
        };
        let result = self.engine.run(semantics, &mut self.state, block);
        self.step += block.words.len() as u64;
        result.map_err(|(line, undecided)| RunError {
            line,
            operation: undecided.operation,
            domain: self.domain.name(),
        })
    }

    /// An operation of the host, written in this line.
    fn host(
        &mut self,
        operation: &Host,
        (line, origin): (u32, Option<&Arc<str>>),
        t: Micros,
        packet: &mut Packet,
    ) {
        if let Host::ScanDigital {
            source,
            first_row,
            last_row,
            events: Some((polarity, channel)),
        } = *operation
        {
            let rows = usize::from(first_row)..=usize::from(last_row);
            let (bits, size) = (self.state.digital(source), self.state.layout.size);
            let scan = Scanned::of_rows(bits, size, rows.clone());
            self.ledger.events += scan.found.len() as u64;
            let read_as = (source, polarity, channel);
            let left = self.unscanned.see(read_as, bits, size, &rows);
            for counted in [&mut self.ledger.unscanned, &mut packet.dropped.unscanned] {
                *counted = (*counted + left.more).saturating_sub(left.read);
            }
            deliver(&scan, polarity, channel, t, packet);
            return;
        }
        let Host::ScanEvents {
            source,
            polarity,
            channel,
            slots,
            order,
            by_rows,
        } = *operation
        else {
            let values = host::execute(
                &self.domain,
                &self.settings.converters,
                &mut self.state,
                operation,
            );
            let reading = values.map(|values| Reading {
                line,
                origin: origin.cloned(),
                values,
            });
            self.readings.extend(reading);
            return;
        };
        let (bits, size) = (self.state.digital(source), self.state.layout.size);
        let scan = if by_rows {
            Scanned::by_rows(bits, size, slots, order)
        } else {
            Scanned::new(bits, size, slots, order)
        };
        self.ledger.events += scan.found.len() as u64;
        self.ledger.missed += scan.missed;
        self.ledger.ambiguous += u64::from(scan.ambiguous);
        deliver(&scan, polarity, channel, t, packet);
    }
}

fn deliver(scan: &Scanned, polarity: Polarity, channel: u8, t: Micros, packet: &mut Packet) {
    packet.dropped.no_slot += scan.missed;
    packet.events.extend(scan.found.iter().map(|at| Event {
        t,
        x: at.x as u16,
        y: at.y as u16,
        polarity,
        channel,
    }));
}
