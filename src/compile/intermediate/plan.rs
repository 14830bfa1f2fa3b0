//! Plans: a filter as bus words over values, before register allocation.

use super::linear_form::{LinearForm, step};
use crate::isa::{self, Device, Direction, Errors, StoreTerms};

/// A value in an ordinary register: 0 is the input, the others in the order of their stores.
pub(in crate::compile) type Value = usize;

/// Where a word stores.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::compile) enum Store {
    /// In an ordinary register, as the next value.
    Register,
    /// In NEWS of this pixel or of a neighbour.
    News(Option<Direction>),
    /// In both at once, halved.
    Both(Option<Direction>),
}

/// The errors that every store adds on the chip, LSB.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::compile) struct StoreErrors {
    /// The transfer error.
    pub(in crate::compile) transfer: f64,
    /// The division error, which is added where the bus splits a sum.
    pub(in crate::compile) division: f64,
}

impl StoreErrors {
    /// As a chip's data has them.
    pub(in crate::compile) fn from_device(device: &Device) -> Self {
        Self::of(&Errors::from_device(device))
    }

    /// Of all that a chip errs by.
    pub(in crate::compile) const fn of(errors: &Errors) -> Self {
        let StoreTerms {
            transfer,
            division,
            // A part of the signal, in `Errors::gain`; plans do not follow it.
            loss: _,
            // Of an average cell, and on average.
            gain_mismatch: _,
            offset_mismatch: _,
            mismatch_correlation: _,
            division_mismatch: _,
            noise: _,
        } = errors.of_a_store();
        Self { transfer, division }
    }

    /// What a store adds.
    pub(in crate::compile) fn added(self, splits: bool) -> f64 {
        isa::added(self.transfer, self.division, splits)
    }

    /// What is stored of a sum, LSB, by a store that loses nothing.
    pub(in crate::compile) fn stored(self, sum: f64, splits: bool) -> f64 {
        let share = if splits { sum / 2.0 } else { sum };
        isa::stored(share, -1.0, self.added(splits))
    }
}

/// Sources that one word takes, and that one word takes which stores in two parts: the
/// vendor's `bus` and `bus2`.
pub(in crate::compile) const SOURCES: usize = 4;
pub(in crate::compile) const SOURCES_SPLIT: usize = 2;

/// One bus word: `store := -(sum of sources) / (number of targets)`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::compile) struct Word {
    /// The destination.
    pub(in crate::compile) store: Store,
    /// NEWS cells that are read.
    pub(in crate::compile) views: Vec<Option<Direction>>,
    /// Values that are read.
    pub(in crate::compile) values: Vec<Value>,
    /// Whether half of the sum goes to a target that nobody reads (the bus divides by the number of
    /// targets).
    pub(in crate::compile) halved: bool,
}

impl Word {
    /// Whether the bus splits the sum between two targets.
    pub(in crate::compile) const fn splits(&self) -> bool {
        self.halved || matches!(self.store, Store::Both(_))
    }

    /// A word of values alone that stores in an ordinary register.
    pub(in crate::compile) const fn register(values: Vec<Value>, halved: bool) -> Self {
        Self {
            store: Store::Register,
            views: Vec::new(),
            values,
            halved,
        }
    }

    /// Whether what it stores is a value: in an ordinary register.
    pub(in crate::compile) const fn makes_value(&self) -> bool {
        matches!(self.store, Store::Register | Store::Both(_))
    }

    /// Whether it stores in NEWS, of this pixel or of a neighbour.
    pub(in crate::compile) const fn writes_news(&self) -> bool {
        matches!(self.store, Store::News(_) | Store::Both(_))
    }
}

/// The values that words make.
pub(in crate::compile) fn values_made(words: &[Word]) -> usize {
    words.iter().filter(|word| word.makes_value()).count()
}

/// Straight-line code that makes the goals from the input.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(in crate::compile) struct Plan {
    /// In the order in which they run.
    pub(in crate::compile) words: Vec<Word>,
    /// The value of each goal.
    pub(in crate::compile) goals: Vec<Value>,
}

/// The symbolic values of a run.
#[derive(Clone, Debug)]
pub(in crate::compile) struct Trace {
    /// Every value in a register, the input first.
    pub(in crate::compile) values: Vec<LinearForm>,
    /// The form that each word stored.
    pub(in crate::compile) stored: Vec<LinearForm>,
    /// Whether the result is right up to the border, where zeros lie beyond it.
    pub(in crate::compile) border: bool,
}

impl Plan {
    /// Register pressure: the most values that are live at a time.
    pub(in crate::compile) fn pressure(&self, input_is_kept: bool) -> usize {
        self.pressures(input_is_kept).into_iter().max().unwrap_or(1)
    }

    /// The values that are live at each word. The input is live until it is last read, or to the
    /// end.
    pub(in crate::compile) fn pressures(&self, input_is_kept: bool) -> Vec<usize> {
        let mut last: Vec<usize> = vec![if input_is_kept { self.words.len() } else { 0 }];
        for (i, word) in self.words.iter().enumerate() {
            for value in &word.values {
                if let Some(last) = last.get_mut(*value) {
                    *last = i.max(*last);
                }
            }
            if word.makes_value() {
                last.push(i);
            }
        }
        for goal in &self.goals {
            if let Some(last) = last.get_mut(*goal) {
                *last = self.words.len();
            }
        }
        let mut stored = 1;
        let held = self.words.iter().enumerate().map(|(i, word)| {
            stored += usize::from(word.makes_value());
            last.iter().take(stored).filter(|last| **last >= i).count()
        });
        held.collect()
    }

    /// What each word stores in the dark, LSB: accumulated transfer errors, those of the input
    /// included.
    pub(in crate::compile) fn dark(&self, input: f64, errors: StoreErrors) -> Vec<f64> {
        let mut values = vec![input];
        let mut news = 0.0;
        let mut all = Vec::new();
        for word in &self.words {
            let mut sum = news * word.views.len() as f64;
            sum += word
                .values
                .iter()
                .filter_map(|v| values.get(*v))
                .sum::<f64>();
            let stored = errors.stored(sum, word.splits());
            if word.writes_news() {
                news = stored;
            }
            if word.makes_value() {
                values.push(stored);
            }
            all.push(stored);
        }
        all
    }

    /// Symbolic execution: runs the words on an input of one `unit`. `None` where a half is not
    /// whole.
    pub(in crate::compile) fn trace(&self, unit: i64) -> Option<Trace> {
        let mut trace = Trace {
            values: vec![LinearForm::unit(unit)],
            stored: Vec::new(),
            border: true,
        };
        let mut news = LinearForm::default();
        for word in &self.words {
            let mut sum = LinearForm::default();
            for view in &word.views {
                trace.border &= news.is_outward(step(*view));
                sum = sum.plus(&news.shifted(step(*view)), 1);
            }
            for value in &word.values {
                sum = sum.plus(trace.values.get(*value)?, 1);
            }
            let mut stored = sum.times(-1);
            if word.splits() {
                stored = stored.half()?;
            }
            if let Store::News(to) | Store::Both(to) = word.store {
                // A pixel that stores into its western neighbour is that neighbour's east.
                let from = to.map(Direction::opposite);
                trace.border &= stored.is_outward(step(from));
                news = stored.shifted(step(from));
            }
            if word.makes_value() {
                trace.values.push(stored.clone());
            }
            trace.stored.push(stored);
        }
        Some(trace)
    }
}
