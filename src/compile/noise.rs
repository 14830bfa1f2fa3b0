//! What the chip's errors leave in the results of straight bus words, to first order.
//!
//! Every store adds to its cell: noise, drawn anew for every word; and what belongs to the cell
//! for good, a deviation of gain and of offset, which adds up where one register is written
//! more than once. Each of these is a draw of its own; a cell is followed as what it holds of
//! every draw, of its own pixel's and of those round it.

use std::collections::BTreeMap;

use super::{Filter, digit::Place};
use crate::isa::{Analog, Device, Figure, Primitive, Source, Target};

/// What a filter adds to its result, as standard deviations in LSB.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Noise {
    /// From frame to frame.
    pub temporal: f64,
    /// From pixel to pixel, the same in every frame: mismatch, at the given input.
    pub fixed: f64,
}

/// A draw from the normal distribution.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Draw {
    /// Of a store: the word and its target.
    Store(usize, usize),
    /// Of a cell.
    Gain(Analog),
    Offset(Analog),
    /// Of a pixel's bus that splits.
    Split(usize),
}

/// What a cell holds: a level, and its part of every draw of the pixels round it.
#[derive(Clone, Debug, Default)]
struct Form {
    level: f64,
    draws: BTreeMap<(Draw, Place), f64>,
}

impl Form {
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
    pub fn noise(&self, device: &Device, input: Analog, level: f64, of: &[Analog]) -> Vec<Noise> {
        let mut held: BTreeMap<Analog, Form> = BTreeMap::new();
        held.insert(
            input,
            Form {
                level,
                ..Form::default()
            },
        );
        for (word, primitive) in self.words.iter().enumerate() {
            if let Primitive::Bus { targets, sources } = primitive {
                run(&mut held, device, word, targets, sources);
            }
        }
        let spread = |form: &Form, temporal: bool| {
            let own = |draw: &Draw| matches!(draw, Draw::Store(..)) == temporal;
            let parts = form.draws.iter().filter(|((draw, _), _)| own(draw));
            parts.map(|(_, part)| part * part).sum::<f64>().sqrt()
        };
        let noise = |register: &Analog| {
            held.get(register).map_or(Noise::default(), |form| Noise {
                temporal: spread(form, true),
                fixed: spread(form, false),
            })
        };
        of.iter().map(noise).collect()
    }
}

fn run(
    held: &mut BTreeMap<Analog, Form>,
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
    let mut bus = Form::default();
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
        let mut cell = Form::default();
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
            // What the others get more the last gets less.
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
