//! The order of a macro's words, where two of its operands are one register.

use super::{Scope, Sink, cell};
use crate::{
    config::Fault,
    isa::{
        Cell, Device, Macro, Source, Value,
        text::{Argument, Statement, Term},
    },
    program::effect::CellEffect,
};

/// Which operands of a macro are written so far.
pub(super) struct Order<'a> {
    of: &'a Macro,
    scope: Scope<'a>,
    /// The operands that words have written, with their registers.
    written: Vec<(&'a str, Cell)>,
    /// Where the macro's words begin.
    start: usize,
    told: bool,
}

impl<'a> Order<'a> {
    /// Before the first word; none where the order loses no operand, since all are registers that
    /// differ.
    pub(super) fn new(of: &'a Macro, scope: Scope<'a>, sink: &Sink) -> Option<Self> {
        let is_beside = |value: &Value| matches!(value, Value::Source(Source::Neighbour(_)));
        let twice = |(i, (_, value)): (usize, &(&str, Value))| {
            cell(value).is_some() && scope[..i].iter().any(|(_, other)| other == value)
        };
        let may_lose =
            scope.iter().any(|(_, value)| is_beside(value)) || scope.iter().enumerate().any(twice);
        may_lose.then(|| Self {
            of,
            scope,
            written: Vec::new(),
            start: sink.steps.len(),
            told: false,
        })
    }

    /// Looks at the words of a statement, those from `from` on: a warning where it reads an operand
    /// that words before it have overwritten.
    pub(super) fn see(
        &mut self,
        statement: &Statement,
        (sink, from): (&Sink, usize),
        device: &Device,
    ) -> Option<Fault> {
        let steps = &sink.steps;
        let effect = CellEffect::of(&steps[from..], device);
        let news = Cell::Analog(device.news());
        let given = statement.arguments.iter().flat_map(Argument::items);
        let named = given.filter_map(|it| match &it.term {
            Term::Name(name) => self.scope.iter().find(|(own, _)| own == name),
            _ => None,
        });
        let named: Vec<&(&str, Value)> = named.collect();
        let mut lost = None;
        for (name, value) in &named {
            let before = &steps[self.start.min(from)..from];
            if let Value::Source(Source::Neighbour(_)) = value
                && CellEffect::of(before, device).writes.contains(&news)
            {
                let news = news.name(device);
                lost = lost.or(Some((
                    *name,
                    format!("it has written {news}, of which {name} reads a neighbour's"),
                )));
            }
            let Some(own) = cell(value).filter(|own| effect.reads.contains(own)) else {
                continue;
            };
            let by = self
                .written
                .iter()
                .find(|(by, at)| by != name && *at == own);
            if let Some((by, _)) = by {
                let register = own.name(device);
                lost = lost.or(Some((
                    *name,
                    format!("it has written {register}, which is {by} too"),
                )));
            }
        }
        // Results stand first: of two operands of one register it is the first that is written.
        let mut cells: Vec<Cell> = Vec::new();
        for (name, value) in named {
            let written = cell(value).filter(|own| effect.writes.contains(own));
            if let Some(own) = written.filter(|own| !cells.contains(own)) {
                cells.push(own);
                self.written.push((*name, own));
            }
        }
        let (name, why) = lost.filter(|_| !self.told)?;
        self.told = true;
        let of = &self.of.signature.name;
        Some(
            Fault::warning(
                sink.place,
                format!("`{of}` reads its {name} after {why}"),
                "this statement",
            )
            .help("use another register, or copy it first: the chip would give the result of the sequence of words"),
        )
    }
}
