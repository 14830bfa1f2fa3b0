//! A compiled filter: its words, and their properties.

use std::fmt::Write as _;

use super::bus_word::{Extent, wired};
use crate::{
    compile::{
        decision::f1_score::Decided,
        intermediate::{linear_form::LinearForm, plan::StoreErrors},
        search::solve::{FINE, Solved, fine},
    },
    isa::{Analog, Device, Figure, Primitive},
    unit::counted,
};

/// A filter in instruction words.
#[derive(Clone, Debug)]
pub struct Filter {
    /// The words: each a bus word.
    pub words: Vec<Primitive>,
    /// The register in which the input begins.
    pub input: Analog,
    /// The register of each result.
    pub results: Vec<Analog>,
    /// The registers that hold a value while each word runs, NEWS left out.
    pub live: Vec<Vec<Analog>>,
    /// Halvings of the input: the results are 2^-prescale of the kernels' sums.
    pub prescale: u32,
    /// Whether the results are right up to the border, zeros beyond it.
    pub border: bool,
    /// The largest that any store gets from inputs of ±1.
    pub peak: f64,
    /// Where a range was given: whether nothing saturates, the chip's transfer errors included.
    /// Without one it says nothing.
    pub holds: bool,
    /// Inputs up to this size, LSB, are filtered as the kernel says: no store saturates, the chip's
    /// transfer errors included. Where the result is a difference that is compared with a threshold,
    /// its own store may: it decides as it should at the end of the range too.
    pub exact_within: f64,
    /// Where it is known with what the result is compared: how well it decides.
    pub decided: Option<Decided>,
    /// What is left of the transfer error in each result, in errors of one store.
    pub offsets: Vec<f64>,
    /// States that the search looked at.
    pub states: u64,
    /// Where it is not right at the border: how many pixels in it may be wrong.
    pub from_border: usize,
}

impl Filter {
    /// The words as statements, one a line.
    #[must_use]
    pub fn text(&self, device: &Device, indent: usize) -> String {
        let mut text = String::new();
        for word in &self.words {
            let _ = writeln!(text, "{:indent$}{};", "", word.text(device));
        }
        text
    }

    /// A program of the filter alone. Its head says by how much results are less than the kernels'.
    #[must_use]
    pub fn alone(&self, device: &Device) -> String {
        let text = self.text(device, 0);
        match self.prescale {
            0 => text,
            bits => format!(
                "// the results are those of the kernels over {}: {} on the way\n{text}",
                1u64 << bits,
                counted(bits, "halving")
            ),
        }
    }

    /// Instruction words that it takes on a chip.
    #[must_use]
    pub fn word_count(&self, device: &Device) -> u64 {
        self.words.iter().map(|word| device.words(word)).sum()
    }

    /// How many pixels in from the border of the array the results may be wrong: where registers beyond
    /// it hold no 0, as far as a result looks.
    #[must_use]
    pub fn wrong_from_border(&self, device: &Device) -> usize {
        let is_right = self.border && device.value(Figure::Edge) == 0.0;
        if is_right { 0 } else { self.from_border }
    }

    /// From kernel times input to the result: what the halvings leave of it.
    #[must_use]
    pub fn scale(&self) -> f64 {
        2f64.powi(-(self.prescale as i32))
    }

    /// A solved plan behind `words`, which halve the input once each; its results are in `results`,
    /// halved `prescale` times in all. `range`: of the input, if it is known, and whether the result
    /// is a difference that is compared with a threshold.
    pub(in crate::compile) fn from_solved(
        (device, input, results): (&Device, Analog, &[Analog]),
        range: (Option<(f64, f64)>, bool),
        solved: &Solved,
        unit: i64,
        prescale: u32,
        mut words: Vec<Primitive>,
    ) -> Self {
        let one = fine(unit) * 2f64.powi(words.len() as i32);
        let mut live: Vec<Vec<Analog>> = words.iter().map(|word| registers(word, device)).collect();
        words.extend(solved.allocated.words.iter().cloned());
        for held in &solved.allocated.live {
            live.push(held.iter().map(|(register, _)| *register).collect());
        }
        Self {
            offsets: offsets(&words, results, device),
            from_border: from_border(&words, results, device),
            words,
            input,
            results: results.to_vec(),
            live,
            prescale,
            border: solved.border,
            holds: solved.holds,
            exact_within: exact_within(solved, (unit, one), device, range),
            decided: None,
            peak: stored(solved, unit)
                .map(|form| form.bounds(-1.0, 1.0).1 / one)
                .fold(1.0, f64::max),
            states: solved.seen,
        }
    }
}

/// The ordinary registers of a word.
fn registers(word: &Primitive, device: &Device) -> Vec<Analog> {
    let words = wired(std::slice::from_ref(word), device);
    let cells = words
        .iter()
        .flat_map(|it| it.targets.iter().chain(&it.sources));
    let mut all: Vec<Analog> = cells.map(|(cell, _)| Analog(*cell as u8)).collect();
    all.retain(|register| *register != device.news());
    all.sort_unstable();
    all.dedup();
    all
}

/// The linear form that each word of a plan stores.
fn stored(solved: &Solved, unit: i64) -> impl Iterator<Item = LinearForm> {
    let trace = solved.plan.trace(unit * FINE);
    trace.into_iter().flat_map(|trace| trace.stored)
}

/// The largest input with which no store saturates, LSB; limited to a register's range. An input that
/// is never negative, as light, reaches less of it. A result that is compared with an earlier one is
/// no longer known where both are at the end of the range; one that is a difference itself decides
/// there too, so that its store does not count. `one`: an input of 1 in the units of its trace.
fn exact_within(
    solved: &Solved,
    (unit, one): (i64, f64),
    device: &Device,
    (range, is_difference): (Option<(f64, f64)>, bool),
) -> f64 {
    let least = match range {
        Some((least, _)) if least >= 0.0 => 0.0,
        _ => -1.0,
    };
    let (low, high) = device.register_range();
    let darks = solved.plan.dark(0.0, StoreErrors::from_device(device));
    let mut forms: Vec<_> = stored(solved, unit).zip(darks).collect();
    if is_difference {
        forms.pop();
    }
    let most = forms.iter().map(|(form, dark)| {
        let (down, up) = form.bounds(least, 1.0);
        let room = [high - dark.max(0.0), dark.min(0.0) - low];
        (room[0] * one / up).min(room[1] * one / down.abs())
    });
    most.fold(high, f64::min).max(0.0)
}

/// How far from the pixel the ways of the results go: farther from the border all of them are on
/// the array.
fn from_border(words: &[Primitive], results: &[Analog], device: &Device) -> usize {
    let pixel = Extent::default();
    let mut held = vec![pixel; device.registers().analog.len()];
    for word in wired(words, device) {
        let read = { word.sources.iter() }.map(|(cell, at)| held[*cell].moved(*at));
        let way = read.fold(pixel, Extent::joined);
        for (cell, at) in word.targets {
            held[cell] = way.moved((-at.0, -at.1)).joined(pixel);
        }
    }
    let far = results.iter().map(|it| held[usize::from(it.0)].farthest());
    far.max().unwrap_or(0) as usize
}

/// The transfer error that is left in each of `results`, in errors of one store, for an input
/// without any.
fn offsets(words: &[Primitive], results: &[Analog], device: &Device) -> Vec<f64> {
    let mut held = vec![0.0; device.registers().analog.len()];
    for word in wired(words, device) {
        let sum: f64 = word.sources.iter().map(|(cell, _)| held[*cell]).sum();
        for (cell, _) in &word.targets {
            held[*cell] = 1.0 - sum / word.targets.len() as f64;
        }
    }
    let one = |register: &Analog| held.get(usize::from(register.0)).copied();
    results.iter().filter_map(one).collect()
}
