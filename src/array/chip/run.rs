//! A body run: words in segments, host operations between them.

use super::{
    super::{
        Converters, Domain, Reading, Scan, Undecided,
        active::{Active, Item},
        cone, host, logic,
        segment::Segment,
        sweep::Array as Meaning,
    },
    Chip, RunError,
};
use crate::{
    event::{Event, Packet, Polarity},
    isa::Primitive,
    program::{Action, Host, Step},
    unit::Micros,
};

impl<D: Domain> Chip<D> {
    pub(super) fn run(
        &mut self,
        body: &[Step],
        t: Micros,
        packet: &mut Packet,
    ) -> Result<(), RunError> {
        let mut segment = Segment::new(&self.state);
        self.body(body, &mut segment, t, packet)?;
        self.flush(&mut segment)
    }

    pub(super) fn body<'a>(
        &mut self,
        body: &'a [Step],
        segment: &mut Segment<'a, D::Cell>,
        t: Micros,
        packet: &mut Packet,
    ) -> Result<(), RunError> {
        let mut launched = false;
        for step in body {
            let word = matches!(step.action, Action::Word(_));
            self.ledger.launches += u64::from(word && !launched);
            launched = word;
            match &step.action {
                Action::Word(word) => {
                    self.ledger.word(word, &self.device);
                    if self.looks.is_some() {
                        // It has run.
                    } else if let Primitive::Prop { boundary } = word {
                        self.flush(segment)?;
                        logic::propagate(&mut self.state, self.settings.propagation, *boundary);
                    } else {
                        segment.push(word, self.step, step.line);
                        if segment.is_full() {
                            self.flush(segment)?;
                        }
                    }
                    self.step += 1;
                }
                Action::Host(operation) => {
                    self.ledger.host(operation, &self.device);
                    let input = cone::is_input(operation);
                    if !input {
                        self.flush(segment)?;
                    }
                    self.look(cone::looked_at(operation).is_some());
                    self.host(operation, step.line, t, packet);
                    self.look(cone::looked_at(operation).is_some());
                    if input {
                        segment.input(&self.state);
                    }
                }
                Action::Repeat { times, body } => {
                    for _ in 0..*times {
                        self.body(body, segment, t, packet)?;
                    }
                }
            }
        }
        Ok(())
    }

    /// Runs a body for a frame.
    pub(super) fn frame(
        &mut self,
        body: &[Step],
        t: Micros,
        packet: &mut Packet,
    ) -> Result<(), RunError> {
        let exposed = |active: &&mut Active<_>| active.unseen().is_some();
        let Some(active) = self.active.as_mut().filter(exposed) else {
            self.forget();
            return self.run(body, t, packet);
        };
        let mut items = Vec::new();
        flat(&self.domain, &self.settings.converters, body, &mut items);
        let meaning = Meaning {
            domain: &self.domain,
            settings: &self.settings,
        };
        let result = active.frame(meaning, &mut self.plan, &mut self.state, &items);
        result.map_err(|error| stopped(&self.domain, error))?;
        self.looks = Some(0);
        let result = self.run(body, t, packet);
        self.looks = None;
        result
    }

    /// Where words have run already: shows the host what a register held, or takes it back.
    pub(super) fn look(&mut self, looks: bool) {
        if let (Some(twice), Some(active), true) = (&mut self.looks, &mut self.active, looks) {
            active.swap(*twice / 2, &mut self.state);
            *twice += 1;
        }
    }

    /// Something else than frames has changed the array: nothing is as it was.
    pub(super) fn forget(&mut self) {
        if let Some(active) = &mut self.active {
            if let Some(light) = active.unseen() {
                self.state.pix.clone_from_slice(light);
            }
            active.forget();
        }
    }

    /// Runs the words that wait.
    pub(super) fn flush(&mut self, segment: &mut Segment<'_, D::Cell>) -> Result<(), RunError> {
        let meaning = Meaning {
            domain: &self.domain,
            settings: &self.settings,
        };
        let result = self.plan.run(meaning, &mut self.state, segment);
        segment.clear();
        result.map_err(|error| stopped(&self.domain, error))
    }

    pub(super) fn host(&mut self, operation: &Host, line: u32, t: Micros, packet: &mut Packet) {
        let mut scan = |source, polarity, channel, slots, from_left, from_bottom| {
            let bits = self.state.digital(source);
            let scan = Scan::new(bits, self.state.layout.size, slots, from_left, from_bottom);
            self.ledger.events += scan.found.len() as u64;
            self.ledger.missed += scan.missed;
            self.ledger.ambiguous += u64::from(scan.ambiguous);
            deliver(&scan, polarity, channel, t, packet);
        };
        match *operation {
            Host::ScanEvents {
                source,
                polarity,
                channel,
                slots,
            } => scan(source, polarity, channel, slots, false, false),
            Host::ScanEventsFrom {
                source,
                polarity,
                channel,
                slots,
                columns_reversed,
                rows_reversed,
            } => scan(
                source,
                polarity,
                channel,
                slots,
                columns_reversed,
                rows_reversed,
            ),
            _ => {
                let values = host::execute(
                    &self.domain,
                    &self.settings.converters,
                    &mut self.state,
                    operation,
                );
                let reading = values.map(|values| Reading { line, values });
                self.readings.extend(reading);
            }
        }
    }
}

pub(super) fn stopped<D: Domain>(domain: &D, (line, undecided): (u32, Undecided)) -> RunError {
    RunError {
        line,
        operation: undecided.operation,
        domain: domain.name(),
    }
}

/// A body without its loops.
pub(super) fn flat<'a, D: Domain>(
    domain: &D,
    converters: &Converters,
    body: &'a [Step],
    items: &mut Vec<Item<'a, D::Cell>>,
) {
    for step in body {
        match &step.action {
            Action::Word(word) => items.push(Item::Word(word, step.line)),
            Action::Host(operation) => {
                let input = host::input(domain, converters, operation).map(Item::Input);
                let look = cone::looked_at(operation).map(Item::Look);
                items.extend(input.or(look));
            }
            Action::Repeat { times, body } => {
                for _ in 0..*times {
                    flat(domain, converters, body, items);
                }
            }
        }
    }
}

pub(super) fn deliver(
    scan: &Scan,
    polarity: Polarity,
    channel: u8,
    t: Micros,
    packet: &mut Packet,
) {
    packet.dropped.no_slot += scan.missed;
    packet.events.extend(scan.found.iter().map(|at| Event {
        t,
        x: at.x as u16,
        y: at.y as u16,
        polarity,
        channel,
    }));
}
