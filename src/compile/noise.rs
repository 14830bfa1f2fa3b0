//! Error propagation, to first order: what the chip's errors leave in the results of straight
//! bus words.
//!
//! Every store adds temporal noise to its cell, drawn anew for every word, and fixed-pattern
//! noise: a deviation of gain and of offset, which adds up where one register is written more
//! than once. Each is an independent random variable. A cell is followed as a linear form over
//! the variables of its own pixel and of those round it.

use std::collections::BTreeMap;

use super::{digit::Place, filter::Filter};
use crate::isa::{Analog, Device, Figure, Primitive, Source, Target};

/// What a filter adds to its result, as standard deviations in LSB.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FilterNoise {
    /// Temporal noise, drawn anew in every frame.
    pub temporal: f64,
    /// Fixed-pattern noise, the same in every frame: mismatch between pixels, at the given input.
    pub fixed: f64,
}

/// One random variable, normally distributed with variance 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Draw {
    /// Temporal noise of a store: the word and its target.
    Store(usize, usize),
    /// Fixed gain deviation of a cell.
    Gain(Analog),
    /// Fixed offset deviation of a cell.
    Offset(Analog),
    /// Fixed imbalance of a pixel's bus when it splits a sum.
    Split(usize),
}

/// What a cell holds: a level, LSB, and the coefficient of every variable of the pixels round it.
#[derive(Clone, Debug, Default)]
struct ErrorForm {
    level: f64,
    draws: BTreeMap<(Draw, Place), f64>,
}

impl ErrorForm {
    fn add(&mut self, other: &Self, (dy, dx): Place, times: f64) {
        self.level += times * other.level;
        for ((draw, (y, x)), part) in &other.draws {
            *self.draws.entry((*draw, (y + dy, x + dx))).or_default() += times * part;
        }
    }

    fn draw(&mut self, draw: Draw, part: f64) {
        *self.draws.entry((draw, (0, 0))).or_default() += part;
    }
}

impl Filter {
    /// Noise and mismatch in each result, for a uniform input of `level` LSB that is free of
    /// both; saturation is left out. As silicon's store in `array` has it, with the numbers of
    /// `[figure.error]` in the chip's data.
    #[must_use]
    pub fn noise(
        &self,
        device: &Device,
        input: Analog,
        level: f64,
        results: &[Analog],
    ) -> Vec<FilterNoise> {
        let mut held: BTreeMap<Analog, ErrorForm> = BTreeMap::new();
        held.insert(
            input,
            ErrorForm {
                level,
                ..ErrorForm::default()
            },
        );
        for (word, primitive) in self.words.iter().enumerate() {
            if let Primitive::Bus { targets, sources } = primitive {
                run(&mut held, device, word, targets, sources);
            }
        }
        let spread = |form: &ErrorForm, temporal: bool| {
            let own = |draw: &Draw| matches!(draw, Draw::Store(..)) == temporal;
            let parts = form.draws.iter().filter(|((draw, _), _)| own(draw));
            parts.map(|(_, part)| part * part).sum::<f64>().sqrt()
        };
        let noise = |register: &Analog| {
            held.get(register)
                .map_or(FilterNoise::default(), |form| FilterNoise {
                    temporal: spread(form, true),
                    fixed: spread(form, false),
                })
        };
        results.iter().map(noise).collect()
    }
}

fn run(
    held: &mut BTreeMap<Analog, ErrorForm>,
    device: &Device,
    word: usize,
    targets: &[Target],
    sources: &[Source],
) {
    let value = |figure| device.value(figure);
    let far = |direction: crate::isa::Direction| {
        let (y, x) = direction.step();
        (y as i16, x as i16)
    };
    let mut bus = ErrorForm::default();
    for source in sources {
        let (register, place) = match source {
            Source::Register(register) => (*register, (0, 0)),
            Source::Neighbour(direction) => (device.news(), far(*direction)),
            Source::Pix | Source::In => continue,
        };
        if let Some(form) = held.get(&register) {
            bus.add(form, place, 1.0);
        }
    }
    let gain = 1.0 - value(Figure::StoreLoss);
    let together = value(Figure::MismatchCorrelation);
    let count = targets.len();
    for (part, target) in targets.iter().enumerate() {
        let (register, place) = match target {
            Target::Register(register) => (*register, (0, 0)),
            Target::Neighbour(direction) => {
                let (y, x) = far(*direction);
                (device.news(), (-y, -x))
            }
        };
        let current = bus.level / count as f64;
        let mut cell = ErrorForm::default();
        cell.add(&bus, place, -gain / count as f64);
        cell.level += value(Figure::TransferError);
        let offset = value(Figure::OffsetMismatch);
        let own = offset * together - current * value(Figure::GainMismatch);
        cell.draw(Draw::Gain(register), own);
        let apart = (1.0 - together * together).sqrt();
        cell.draw(Draw::Offset(register), offset * apart);
        cell.draw(Draw::Store(word, part), value(Figure::StoreNoise));
        if count > 1 {
            cell.level += value(Figure::DivisionError);
            // The shares of a split add up to 1: what the others get more, the last gets less.
            let mut more = vec![0.0; count - 1];
            match more.get_mut(part) {
                Some(own) => *own = 1.0,
                None => more.fill(-1.0),
            }
            for (k, more) in more.into_iter().enumerate() {
                let uneven = value(Figure::DivisionMismatch);
                cell.draw(Draw::Split(k), -gain * current * uneven * more);
            }
        }
        held.insert(register, cell);
    }
}
