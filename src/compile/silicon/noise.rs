//! Error propagation, to first order: what the chip's errors leave in the results of straight
//! bus words.
//!
//! Every store adds temporal noise to its cell, drawn anew for every word, and fixed-pattern
//! noise: a deviation of gain and of offset, which adds up where one register is written more
//! than once. Each is an independent random variable. A cell is followed as a linear form over
//! the variables of its own pixel and of those round it.

use std::collections::BTreeMap;

use crate::{
    compile::codegen::{
        bus_word::{Wired, wired},
        filter::Filter,
    },
    isa::{self, Analog, Device, Errors, StoreTerms},
};

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
    Gain(usize),
    /// Fixed offset deviation of a cell.
    Offset(usize),
    /// Fixed imbalance of a pixel's bus when it splits a sum.
    Split(usize),
}

/// What a cell holds: a level, LSB, and the coefficient of every variable of the pixels round it.
#[derive(Clone, Debug, Default)]
struct ErrorForm {
    level: f64,
    draws: BTreeMap<(Draw, (i32, i32)), f64>,
}

impl ErrorForm {
    fn add(&mut self, other: &Self, (dy, dx): (i32, i32), times: f64) {
        self.level += times * other.level;
        for ((draw, (y, x)), part) in &other.draws {
            *self.draws.entry((*draw, (y + dy, x + dx))).or_default() += times * part;
        }
    }

    fn draw(&mut self, draw: Draw, part: f64) {
        *self.draws.entry((draw, (0, 0))).or_default() += part;
    }
}

impl FilterNoise {
    /// The input for which it is stated, LSB: the middle of what light fills of a register.
    pub const MIDDLE: f64 = 64.0;
}

impl Filter {
    /// Noise and mismatch in each result, for a uniform input of `level` LSB that is free of
    /// both; saturation is left out. As silicon's store in `array` has it, with the numbers of
    /// `[figure.error]` in the chip's data.
    #[must_use]
    pub fn noise(&self, device: &Device, level: f64) -> Vec<FilterNoise> {
        let mut held: BTreeMap<usize, ErrorForm> = BTreeMap::new();
        held.insert(
            usize::from(self.input.0),
            ErrorForm {
                level,
                ..ErrorForm::default()
            },
        );
        let errors = Errors::from_device(device);
        for (at, word) in wired(&self.words, device).iter().enumerate() {
            run(&mut held, &errors, at, word);
        }
        let spread = |form: &ErrorForm, temporal: bool| {
            let own = |draw: &Draw| matches!(draw, Draw::Store(..)) == temporal;
            let parts = form.draws.iter().filter(|((draw, _), _)| own(draw));
            parts.map(|(_, part)| part * part).sum::<f64>().sqrt()
        };
        let noise = |register: &Analog| {
            held.get(&usize::from(register.0))
                .map_or(FilterNoise::default(), |form| FilterNoise {
                    temporal: spread(form, true),
                    fixed: spread(form, false),
                })
        };
        self.results.iter().map(noise).collect()
    }
}

fn run(held: &mut BTreeMap<usize, ErrorForm>, errors: &Errors, at: usize, word: &Wired) {
    let mut bus = ErrorForm::default();
    for (cell, place) in &word.sources {
        if let Some(form) = held.get(cell) {
            bus.add(form, *place, 1.0);
        }
    }
    let StoreTerms {
        transfer,
        division,
        offset_mismatch,
        division_mismatch,
        noise,
        // In `Errors::gain` and `Errors::of_gain`.
        loss: _,
        gain_mismatch: _,
        mismatch_correlation: _,
    } = errors.of_a_store();
    let gain = errors.gain(0.0);
    let count = word.targets.len();
    for (part, (target, (y, x))) in word.targets.iter().enumerate() {
        let current = bus.level / count as f64;
        let mut cell = ErrorForm::default();
        cell.add(&bus, (-y, -x), gain / count as f64);
        cell.level += transfer;
        cell.draw(Draw::Gain(*target), errors.of_gain(current));
        cell.draw(Draw::Offset(*target), offset_mismatch * errors.apart());
        cell.draw(Draw::Store(at, part), noise);
        if count > 1 {
            cell.level += division;
            for k in 0..count - 1 {
                let more = f64::from(isa::uneven(part, count, k));
                cell.draw(Draw::Split(k), gain * current * division_mismatch * more);
            }
        }
        held.insert(*target, cell);
    }
}
