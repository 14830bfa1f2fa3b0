//! How many events a program keeps: its filter, tried on moving light
//! ([`dead_leaves`](super::dead_leaves)) as the chip errs.
//!
//! A forecast of a result's noise does not say this. What counts is where the result lies beside
//! its threshold: a result that saturates is far above it and decides as it should, so that halving
//! it costs signal and gains nothing; a partial sum that saturates may decide wrongly. So the words
//! are run, store by store as `isa/errors.rs` has it, on an array of a few thousand cells, from
//! the photodiode through memory and filter to both comparisons, and the events are compared with
//! those of the kernel itself. Where a chip's constants do not drop out of what is compared, the array
//! has a border, and what lies near it counts as often as on the chip.

use std::sync::OnceLock;

use super::{
    dead_leaves::{Light, SIDE},
    f1_score::Decided,
};
use crate::{
    compile::{
        codegen::bus_word::{Wired, wired},
        sensor::cell_kind::CellKind,
    },
    isa::{self, Analog, Device, Errors, Figure, Primitive, StoreTerms},
    kernel::Kernel,
    plane::Plane,
    rng::{Hash, normal},
};

/// What is compared with the threshold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compared {
    /// The filter of the light less a memory of the pixel: a chip's constants, and what its pixels
    /// differ by, are in it.
    Difference,
    /// The filter of the light less the same at the last event.
    Drives,
}

/// What the result of a filter is for: events where it has moved by more than a threshold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decision {
    /// The ON threshold, in the unit of kernel times input, LSB.
    pub on: f64,
    /// The OFF threshold, likewise.
    pub off: f64,
    /// What is compared with them.
    pub compared: Compared,
}

impl Decision {
    /// Of a kind on this chip.
    pub(in crate::compile) fn new(kind: &CellKind, device: &Device, compared: Compared) -> Self {
        let light = device.value(Figure::LightScale);
        Self {
            on: kind.on * light,
            off: kind.off * light,
            compared,
        }
    }
}

/// Cells of one picture.
const CELLS: usize = SIDE * SIDE;

/// Kinds of chance.
const GAIN: u64 = 0;
const OFFSET: u64 = 1;
const SPLIT: u64 = 2;
const NOISE: u64 = 3;

/// Normal numbers that noise is taken from.
const NOISES: usize = 4096 + CELLS;

/// One number for each cell.
type Cells = Vec<f32>;

/// The arrays that filters are tried on.
pub(super) struct Trials {
    errors: Errors,
    /// Lowest and highest of a register without errors, LSB.
    range: (f32, f32),
    /// NEWS.
    news: usize,
    /// What registers hold off the array, LSB; of an array that wraps round, nothing.
    edge: Option<f32>,
    /// How often there are cells like each on the chip, beside those in the middle; 0 off the array.
    weights: Vec<f64>,
    /// Of each kind of light.
    arrays: Vec<Vec<Array>>,
    noise: Cells,
}

/// One array, with the light before and after.
struct Array {
    light: [Cells; 2],
    /// Of each register: the gain and the offset of its cells.
    gain: Vec<Cells>,
    offset: Vec<Cells>,
    /// Of each part of a bus that splits.
    split: [Cells; 2],
}

/// Which errors a run has.
#[derive(Clone, Copy, PartialEq, Eq)]
enum As {
    Silicon,
    Exact,
}

/// A picture before and after.
type Pair = [Plane<f64>; 2];

/// Pairs of pictures of a kind of light, made once.
fn pairs(light: Light) -> &'static [Pair] {
    static PAIRS: [OnceLock<Vec<Pair>>; Light::ALL.len()] =
        [const { OnceLock::new() }; Light::ALL.len()];
    let make = || light.numbers().iter().map(|n| light.pair(*n)).collect();
    PAIRS[light as usize].get_or_init(make)
}

/// What is shown. A difference from the pixel's own memory does not have the light that stays.
const fn shown(compared: Compared) -> &'static [Light] {
    match compared {
        Compared::Difference => &[Light::Leaves],
        Compared::Drives => &Light::ALL,
    }
}

/// The kernel's own events on each array: -1, 0 or 1 at each cell.
pub(super) type Truth = Vec<Vec<Vec<i8>>>;

impl Trials {
    /// For a chip whose input is at most `most` LSB.
    pub(super) fn new(device: &Device, most: f64, compared: Compared) -> Self {
        let errors = Errors::from_device(device);
        let StoreTerms {
            division_mismatch,
            noise,
            // In `Errors::gain` and `Errors::offset`.
            transfer: _,
            loss: _,
            gain_mismatch: _,
            offset_mismatch: _,
            mismatch_correlation: _,
            // Where a word stores.
            division: _,
        } = errors.of_a_store();
        let registers = device.registers().analog.len();
        let draw = |array: usize, reason: u64, number: usize| -> Cells {
            let place = Hash::new(0xDEC1).with(array as u64).with(reason);
            let place = place.with(number as u64);
            (0..CELLS).map(|i| drawn(place.with(i as u64))).collect()
        };
        let array = |(number, pair): (usize, &Pair)| {
            let gain: Vec<Cells> = (0..registers).map(|r| draw(number, GAIN, r)).collect();
            let own = |(r, gain): (usize, &Cells)| -> Cells {
                let both = gain.iter().zip(draw(number, OFFSET, r));
                both.map(|(gain, own)| errors.offset((*gain).into(), own.into()) as f32)
                    .collect()
            };
            let offset = gain.iter().enumerate().map(own).collect();
            let all = |of: &dyn Fn(f64) -> f64, cells: Cells| -> Cells {
                { cells.into_iter() }
                    .map(|cell| of(cell.into()) as f32)
                    .collect()
            };
            Array {
                light: [0, 1].map(|i| pair[i].iter().map(|it| (it * most) as f32).collect()),
                offset,
                gain: { gain.into_iter() }
                    .map(|cells| all(&|own| errors.gain(own), cells))
                    .collect(),
                split: [0, 1].map(|k| all(&|own| division_mismatch * own, draw(number, SPLIT, k))),
            }
        };
        let draws = Hash::new(0xDEC1).with(NOISE);
        // A constant of the chip drops out of a difference of drives, at the border too.
        let edge = match compared {
            Compared::Difference => Some(device.value(Figure::Edge) as f32),
            Compared::Drives => None,
        };
        let (lowest, highest) = device.register_range();
        let chip = [Figure::Height, Figure::Width].map(|side| device.value(side));
        Self {
            edge,
            weights: match edge {
                Some(_) => (0..CELLS).map(|cell| weight(cell, chip)).collect(),
                None => vec![1.0; CELLS],
            },
            range: (lowest as f32, highest as f32),
            news: usize::from(device.news().0),
            arrays: { shown(compared).iter() }
                .map(|light| pairs(*light).iter().enumerate().map(array).collect())
                .collect(),
            noise: { 0..NOISES }
                .map(|i| drawn(draws.with(i as u64)) * noise as f32)
                .collect(),
            errors,
        }
    }

    /// The changes of the light that belong to each array, and where kernel times change exceeds a
    /// threshold: -1, 0 or 1.
    pub(super) fn truth(&self, kernel: &Kernel, decision: Decision) -> Truth {
        let (rows, columns) = kernel.reach();
        let of = |array: &Array| {
            let mut change: Vec<f64> = { array.light[1].iter().zip(&array.light[0]) }
                .map(|(after, before)| f64::from(*after) - f64::from(*before))
                .collect();
            if self.edge.is_some() {
                off_array(&mut change, 0.0);
            }
            let mut drive = vec![0.0; CELLS];
            for ((y, x), weight) in kernel.weights().indexed_iter() {
                if *weight == 0.0 {
                    continue;
                }
                let place = (y as i32 - rows as i32, x as i32 - columns as i32);
                for (i, drive) in drive.iter_mut().enumerate() {
                    *drive += weight * change[beside(i, place)];
                }
            }
            let sign = |drive: f64| i8::from(drive > decision.on) - i8::from(-drive > decision.off);
            drive.into_iter().map(sign).collect()
        };
        let all = |arrays: &Vec<Array>| arrays.iter().map(of).collect();
        self.arrays.iter().map(all).collect()
    }

    /// What is kept of the events by these words, whose result is `scale` times the kernel's. `None`
    /// where in exact arithmetic they keep less than `least` of any kind of light.
    pub(super) fn decided(
        &self,
        words: &[Primitive],
        device: &Device,
        (input, result): (Analog, Analog),
        (decision, scale): (Decision, f64),
        (truth, least): (&Truth, f64),
    ) -> Option<Decided> {
        let filter = Filtered {
            trials: self,
            words: wired(words, device),
            registers: (usize::from(input.0), usize::from(result.0)),
            decision,
            scale,
        };
        let each = |how: As| -> Vec<f64> {
            let both = self.arrays.iter().zip(truth);
            both.map(|(arrays, truth)| filter.f1(how, arrays, truth))
                .collect()
        };
        let exact = each(As::Exact).into_iter().fold(1.0, f64::min);
        if exact < least {
            return None;
        }
        let silicon = each(As::Silicon);
        Some(Decided {
            silicon: silicon.iter().sum::<f64>() / silicon.len().max(1) as f64,
            exact,
            any: truth.iter().flatten().flatten().any(|sign| *sign != 0),
        })
    }
}

/// A filter and what its result is for.
struct Filtered<'a> {
    trials: &'a Trials,
    words: Vec<Wired>,
    /// Of the input and of the result.
    registers: (usize, usize),
    decision: Decision,
    scale: f64,
}

impl Filtered<'_> {
    /// F1 on all arrays of one kind of light.
    fn f1(&self, how: As, arrays: &[Array], truth: &[Vec<i8>]) -> f64 {
        // The host sets whole LSB.
        let set = |threshold: f64| match how {
            As::Silicon => (threshold * self.scale).round_ties_even(),
            As::Exact => threshold * self.scale,
        };
        let Decision { on, off, compared } = self.decision;
        let (on, off) = (set(on) as f32, set(off) as f32);
        let (mut both, mut either) = (0.0, 0.0);
        for (number, (array, truth)) in arrays.iter().zip(truth).enumerate() {
            let mut run = Run {
                trials: self.trials,
                array,
                how,
                at: number * 7919,
                cells: vec![vec![self.trials.edge.unwrap_or(0.0); CELLS]; array.gain.len()],
            };
            let drive = run.drive(&self.words, self.registers, compared);
            let cells = drive.iter().zip(truth).zip(&self.trials.weights);
            for ((drive, truth), weight) in cells {
                for (fires, is_true) in [(*drive > on, *truth > 0), (-drive > off, *truth < 0)] {
                    both += weight * f64::from(2 * u8::from(fires && is_true));
                    either += weight * f64::from(u8::from(fires) + u8::from(is_true));
                }
            }
        }
        if either == 0.0 { 1.0 } else { both / either }
    }
}

/// A normal number.
fn drawn(place: Hash) -> f32 {
    normal(place.nth(1).uniform(), place.nth(2).uniform()) as f32
}

/// Pixels from the border that are weighed apart: what most kernels reach.
const RIM: usize = 3;

/// How far a cell lies from the cells off the array, the outermost ones.
fn from_border(cell: usize) -> Option<usize> {
    let (y, x) = (cell / SIDE, cell % SIDE);
    y.min(x).min(SIDE - 1 - y).min(SIDE - 1 - x).checked_sub(1)
}

/// How often there are cells like this on a chip of so many rows and columns, beside those in the
/// middle.
fn weight(cell: usize, chip: [f64; 2]) -> f64 {
    let Some(from) = from_border(cell) else {
        return 0.0;
    };
    if from >= RIM {
        return 1.0;
    }
    // The share of a ring that far from the border of an array.
    let share = |sides: [f64; 2]| {
        let ring: f64 = sides
            .iter()
            .map(|side| side - 2.0 * from as f64 - 1.0)
            .sum();
        let [rows, columns] = sides.map(|side| (side - 2.0 * RIM as f64).max(1.0));
        2.0 * ring / (rows * columns)
    };
    share(chip).max(0.0) / share([SIDE as f64 - 2.0; 2])
}

/// Sets what lies off the array.
fn off_array<T: Copy>(cells: &mut [T], to: T) {
    let (first, rest) = cells.split_at_mut(SIDE);
    let (rest, last) = rest.split_at_mut(rest.len() - SIDE);
    first.fill(to);
    last.fill(to);
    for row in rest.chunks_mut(SIDE) {
        row[0] = to;
        row[SIDE - 1] = to;
    }
}

/// The number of the cell that lies so many rows and columns from another; the array wraps round.
fn beside(i: usize, (dy, dx): (i32, i32)) -> usize {
    let moved = |at: usize, by: i32| (at as i32 + by).rem_euclid(SIDE as i32) as usize;
    moved(i / SIDE, dy) * SIDE + moved(i % SIDE, dx)
}

/// One run of words on an array.
struct Run<'a> {
    trials: &'a Trials,
    array: &'a Array,
    how: As,
    /// Where in the noise the next word begins.
    at: usize,
    cells: Vec<Cells>,
}

impl Run<'_> {
    /// What is compared with the thresholds, of each cell.
    fn drive(&mut self, words: &[Wired], (input, result): (usize, usize), of: Compared) -> Cells {
        let news = self.trials.news;
        let [before, after] = &self.array.light;
        // A register that no filter of few words uses, else the memory's own errors would not be
        // its own.
        let memory = (0..self.cells.len()).rev();
        let memory = { memory }
            .find(|cell| *cell != news && *cell != input && *cell != result)
            .unwrap_or(result);
        match of {
            Compared::Difference => {
                self.store(before, &[(news, (0, 0))]);
                self.store(&self.cells[news].clone(), &[(memory, (0, 0))]);
                self.store(after, &[(news, (0, 0))]);
                let sum = added(&self.cells[news], &self.cells[memory]);
                self.store(&sum, &[(input, (0, 0))]);
                self.words(words);
                self.cells[result].clone()
            }
            Compared::Drives => {
                self.capture(before, input);
                self.words(words);
                let first = self.cells[result].clone();
                // Minus the memory.
                self.store(&vec![0.0; CELLS], &[(news, (0, 0))]);
                let sum = added(&first, &self.cells[news]);
                self.store(&sum, &[(memory, (0, 0))]);
                let remembered = self.cells[memory].clone();
                self.capture(after, input);
                self.words(words);
                added(&self.cells[result], &remembered)
            }
        }
    }

    fn capture(&mut self, light: &Cells, input: usize) {
        let news = self.trials.news;
        self.store(light, &[(news, (0, 0))]);
        self.store(&self.cells[news].clone(), &[(input, (0, 0))]);
    }

    fn words(&mut self, words: &[Wired]) {
        let mut sum = vec![0.0; CELLS];
        for word in words {
            sum.fill(0.0);
            for (cell, place) in &word.sources {
                add_moved(&mut sum, &self.cells[*cell], *place);
            }
            if let Some(edge) = self.trials.edge {
                off_array(&mut sum, edge * word.sources.len() as f32);
            }
            self.store(&sum, &word.targets);
        }
    }

    /// Stores a sum as the chip does, or without its errors.
    fn store(&mut self, sum: &[f32], targets: &[(usize, (i32, i32))]) {
        let Trials {
            errors,
            range,
            noise,
            ..
        } = self.trials;
        let count = targets.len() as f32;
        for (part, (cell, place)) in targets.iter().enumerate() {
            let own = &mut self.cells[*cell];
            if self.how == As::Exact {
                for (i, sum) in sum.iter().enumerate() {
                    let to = if *place == (0, 0) {
                        i
                    } else {
                        beside(i, *place)
                    };
                    own[to] = (-sum / count).clamp(range.0, range.1);
                }
                if let Some(edge) = self.trials.edge {
                    off_array(own, edge);
                }
                continue;
            }
            let splits = targets.len() > 1;
            let division = if splits { errors.division as f32 } else { 0.0 };
            let (low, high) = (errors.range.0 as f32, errors.range.1 as f32);
            let (gain, offset) = (&self.array.gain[*cell], &self.array.offset[*cell]);
            let noise = &noise[self.at % (NOISES - CELLS)..];
            self.at += 1009;
            // Words of filters have two targets at most.
            let more = splits.then(|| [0, 1].map(|split| isa::uneven(part, targets.len(), split)));
            let [one, two] = &self.array.split;
            for (i, sum) in sum.iter().enumerate() {
                let mut current = sum / count;
                if let Some([first, second]) = more {
                    current = isa::split(current, first * one[i] + second * two[i]);
                }
                let to = if *place == (0, 0) {
                    i
                } else {
                    beside(i, *place)
                };
                let stored = isa::stored(current, gain[to], offset[to] + noise[i] + division);
                own[to] = stored.clamp(low, high);
            }
            if let Some(edge) = self.trials.edge {
                off_array(own, edge);
            }
        }
    }
}

fn added(a: &[f32], b: &[f32]) -> Cells {
    a.iter().zip(b).map(|(a, b)| a + b).collect()
}

/// Adds what the neighbours hold that lie so far away.
fn add_moved(sum: &mut [f32], cells: &[f32], (dy, dx): (i32, i32)) {
    let way = dx.rem_euclid(SIDE as i32) as usize;
    for (y, row) in sum.chunks_mut(SIDE).enumerate() {
        let from = (y as i32 + dy).rem_euclid(SIDE as i32) as usize * SIDE;
        let other = &cells[from..from + SIDE];
        let (near, far) = row.split_at_mut(SIDE - way);
        let moved = near.iter_mut().zip(&other[way..]);
        let wrapped = far.iter_mut().zip(&other[..way]);
        for (sum, cell) in moved.chain(wrapped) {
            *sum += cell;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The outermost ring of an array of 256x256 is twice the share of one of 512x512.
    #[test]
    fn the_border_of_a_large_chip_counts_less() {
        let outermost = SIDE + SIDE / 2;
        assert_eq!(from_border(outermost), Some(0));
        let share = |sides| weight(outermost, sides);
        let halved = share([256.0; 2]) / share([512.0; 2]);
        assert!((halved - 2.04).abs() < 0.01, "{halved}");
        let wide = share([256.0, 512.0]);
        assert!(wide < share([256.0; 2]) && wide > share([512.0; 2]));
        // The middle is what all others are beside.
        let middle = (SIDE + 1) * (SIDE / 2);
        assert_eq!(weight(middle, [512.0; 2]), 1.0);
        assert_eq!(weight(0, [512.0; 2]), 0.0);
    }
}
