//! Why there is no program.

use crate::isa::{Device, Figure};

/// The largest value that a register holds with either sign, LSB.
#[must_use]
pub fn largest_of_both_signs(device: &Device) -> f64 {
    let (low, high) = device.register_range();
    high.min(-low)
}

/// The largest threshold that `scamp5_in` sets, negated, in LSB.
pub(super) fn most_threshold(device: &Device) -> f64 {
    -device.register_range().0
}

/// What part of a threshold of so many LSB can be set and passed: no more than `most` can be set,
/// and no result changes by more than `reach`.
fn part_to_take(lsb: f64, most: f64, reach: f64) -> String {
    // A change that is as large as the threshold does not pass it.
    part_that_fits(lsb, most.min(reach * (1.0 - 1e-9)))
}

/// What part of a threshold of so many LSB, more than can be set, can be: three digits, rounded
/// down; a tiny one in two, with its power of ten, and a twentieth less.
fn part_that_fits(lsb: f64, most: f64) -> String {
    let part = most / lsb;
    if part < 1e-6 {
        return format!("{:.1e}", 0.95 * part);
    }
    let mut place = 1000.0;
    while part * place < 100.0 && place < 1e300 {
        place *= 10.0;
    }
    ((part * place).floor() / place).to_string()
}

/// How many times as high a threshold must be, in four digits, rounded up.
pub(super) fn times_that_fit(times: f64) -> String {
    // What a product rounds must not make it lower.
    four_digits(times, |it| it >= times * (1.0 + 1e-9)).to_string()
}

/// The first number of four digits, from about this one on, that serves.
#[must_use]
pub fn four_digits(from: f64, serves: impl Fn(f64) -> bool) -> f64 {
    let mut place = 1000.0;
    while from * place >= 10_000.0 && place > 1e-9 {
        place /= 10.0;
    }
    while from * place < 1000.0 && place < 1e300 {
        place *= 10.0;
    }
    let first = (from * place).floor();
    let near = [first - 1.0, first, first + 1.0].map(|it| it / place);
    { near.into_iter() }
        .find(|it| serves(*it))
        .unwrap_or_else(|| (first + 2.0) / place)
}

/// How many bits are needed.
fn bits_needed(needed: Option<u8>) -> String {
    needed.map_or_else(
        || "on the chip no number of bits is enough for this threshold".to_owned(),
        |needed| {
            format!(
                "{} are needed for each kind",
                crate::unit::counted(needed, "bit")
            )
        },
    )
}

/// That so many memories do not fit.
fn no_room(count: usize, bits: u8) -> String {
    let bits = crate::unit::counted(bits, "bit");
    match count {
        1 => format!("a memory of {bits} does not fit"),
        count => format!("{count} memories of {bits} do not fit"),
    }
}

/// Kernels that cannot be compiled as asked.
#[derive(Clone, Debug, PartialEq, thiserror::Error, miette::Diagnostic)]
pub enum CompileError {
    /// Nobody waited for it any longer.
    #[error("the search was given up")]
    #[diagnostic(help("search again"))]
    GivenUp,
    /// A field of the request that cannot be.
    #[error("{field}: {what}")]
    #[diagnostic(help("{help}"))]
    Field {
        /// Its name.
        field: &'static str,
        /// What is wrong with it.
        what: String,
        /// What to give.
        help: &'static str,
    },
    /// A weight that sums and halves do not make exactly.
    #[error(
        "{kernel}, row {row}, column {column}: {weight} is not a multiple of 1/4096 of at most 4096"
    )]
    #[diagnostic(help(
        "the chip only adds and halves; quantise the kernel with --to (ternary, po2-3, int-5, q1.4 …), or write the weight as a fraction whose denominator is a power of two"
    ))]
    NotDyadic {
        /// Which kernel: its number, from 0, or [its name](Self::of_kernel).
        kernel: String,
        /// Row, from 0 in the north.
        row: usize,
        /// Column, from 0 in the west.
        column: usize,
        /// The weight that cannot be represented.
        weight: f64,
    },
    /// A kernel that is too large.
    #[error(
        "{kernel} is {} by {}; at most 15 by 15 here",
        crate::unit::counted(*height, "row"),
        crate::unit::counted(*width, "column")
    )]
    #[diagnostic(help("cut the kernel where its weights are small"))]
    Size {
        /// Which kernel: its number, from 0, or [its name](Self::of_kernel).
        kernel: String,
        /// Rows of the kernel.
        height: usize,
        /// Columns of the kernel.
        width: usize,
    },
    /// Too few registers.
    #[error(
        "{}: no program was found for the {} that {} free; {needed} registers suffice",
        if *kernels == 1 { "one kernel".to_owned() } else { format!("{kernels} kernels") },
        crate::unit::counted(*free, "analogue register"),
        if *free == 1 { "is" } else { "are" },
    )]
    #[diagnostic(help("{}", more_registers(*kernels, *free, *are_kept)))]
    Registers {
        /// How many kernels need them, each one for its result.
        kernels: usize,
        /// How many they need.
        needed: usize,
        /// How many there are.
        free: usize,
        /// Whether others are to keep what they hold.
        are_kept: bool,
    },
    /// Too few registers for a whole program.
    #[error(
        "{}, with {memory}: {needed} analogue registers are needed, {free} {} free: {} too few",
        crate::unit::counted(*count, "kind"),
        if *free == 1 { "is" } else { "are" },
        needed.saturating_sub(*free)
    )]
    #[diagnostic(help("{advice}"))]
    Kinds {
        /// How many kinds.
        count: usize,
        /// What they need registers for.
        memory: &'static str,
        /// Registers that they need.
        needed: usize,
        /// How many there are.
        free: usize,
        /// What was tried and works.
        advice: String,
    },
    /// Too few one-bit registers.
    #[error(
        "{} into the {free} one-bit registers that are free for memories",
        no_room(*count, *bits)
    )]
    #[diagnostic(help("{advice}"))]
    Bits {
        /// How many memories.
        count: usize,
        /// Bits of each.
        bits: u8,
        /// One-bit registers that are free for memories.
        free: usize,
        /// What was tried and works.
        advice: String,
    },
    /// Memories in bits whose levels are farther apart than the threshold allows.
    #[error(
        "the levels of a memory of {} are {step:.1} LSB apart: a drive between two levels is up to {:.1} LSB from both, more than the threshold of {threshold} LSB on the chip, so cells fire again and again; {}",
        crate::unit::counted(*bits, "bit"),
        step / 2.0,
        bits_needed(*needed)
    )]
    #[diagnostic(help("{advice}"))]
    Levels {
        /// Bits of each memory.
        bits: u8,
        /// The fewest bits with which no kind fires on the chip while the picture stays; none where
        /// what its stores err by is too much for the thresholds with any.
        needed: Option<u8>,
        /// The distance of two levels, LSB.
        step: f64,
        /// The lower of a kind's thresholds, as the chip's converter sets it, LSB.
        threshold: f64,
        /// How many times as high the thresholds of all kinds must be for these bits to serve; none
        /// where the chip can set none that do.
        times: Option<f64>,
        /// What was tried and works.
        advice: String,
    },
    /// A threshold that the chip's converter cannot set.
    #[error(
        "a threshold is {} LSB in the program, more than the {most} that the host can set",
        if *lsb < 1e6 { format!("{lsb:.0}") } else { format!("{lsb:.2e}") }
    )]
    #[diagnostic(help("lower the threshold to {} times this one, or less", part_to_take(*lsb, *most, *reach)))]
    Threshold {
        /// The threshold, LSB.
        lsb: f64,
        /// The largest that can be set, LSB.
        most: f64,
        /// By how much the result can change at most, LSB.
        reach: f64,
    },
    /// A word that the chip does not have.
    #[error("no program for {chip}: {why}")]
    #[diagnostic(help(
        "take a chip that has it (--chip), or give it to this one: primitives.toml, macros.scamp or [registers] of {chip}"
    ))]
    Missing {
        /// Name of the chip.
        chip: String,
        /// What is missing.
        why: String,
    },
    /// More words than the chip stores.
    #[error("the program has {words} instruction words, {} more than the {room} that {chip} holds", words - room)]
    #[diagnostic(help("{advice}"))]
    Store {
        /// How many it has.
        words: u64,
        /// How many the chip holds.
        room: u64,
        /// Name of the chip.
        chip: String,
        /// What was tried and works.
        advice: String,
    },
    /// Nothing that the chip leaves of the signal.
    #[error(
        "the chip's errors hide the kernel: the best program found has a correlation of {correlation:.2} with the exact filter at its best input, {offset:.0} LSB of constant errors and {noise:.1} LSB of noise"
    )]
    #[diagnostic(help(
        "fewer words make fewer errors: use fewer digits (--to int-4, po2-2), a smaller kernel, or search longer (--effort); --objective words compiles it as it is"
    ))]
    Nothing {
        /// The predicted correlation.
        correlation: f64,
        /// The constant errors in the result, LSB.
        offset: f64,
        /// The noise in it, LSB.
        noise: f64,
    },
    /// An input that no number of halvings brings into range.
    #[error(
        "an input from {low} to {high} LSB does not fit into {lowest}…{highest}, halved or not"
    )]
    #[diagnostic(help(
        "give a range with a low end below its high end, within {lowest} to {highest} LSB"
    ))]
    Range {
        /// Lowest input, LSB.
        low: f64,
        /// Highest input, LSB.
        high: f64,
        /// The lowest that a register of the chip holds, LSB.
        lowest: f64,
        /// The highest, LSB.
        highest: f64,
    },
}

impl CompileError {
    /// Of so many words, where the chip does not hold them.
    #[must_use]
    pub fn of_store(words: u64, device: &Device) -> Option<Self> {
        let room = device.value(Figure::Store) as u64;
        (words > room).then(|| Self::Store {
            words,
            room,
            chip: device.name().to_owned(),
            advice: "use fewer digits (--to), or a chip with a larger store (--chip)".to_owned(),
        })
    }

    /// The same with another advice, where it is one that was tried; any other as it is.
    #[must_use]
    pub(super) fn with_advice(mut self, advised: impl FnOnce() -> String) -> Self {
        if let Self::Kinds { advice, .. }
        | Self::Bits { advice, .. }
        | Self::Levels { advice, .. }
        | Self::Store { advice, .. } = &mut self
        {
            *advice = advised();
        }
        self
    }
}

impl CompileError {
    /// What is said of a kernel by its number, said of it by its name.
    #[must_use]
    pub fn of_kernel(mut self, name: &str) -> Self {
        if let Self::NotDyadic { kernel, .. } | Self::Size { kernel, .. } = &mut self {
            name.clone_into(kernel);
        }
        self
    }
}

/// What to do where registers do not suffice: where even the results have no room, no search helps.
fn more_registers(kernels: usize, free: usize, are_kept: bool) -> String {
    let longer = (kernels <= free).then_some("search longer (--effort)");
    let fewer = (kernels > 1).then_some("ask for fewer kinds or kernels");
    let kept = are_kept.then_some("keep fewer registers (--keep)");
    let all = [longer, fewer, kept].into_iter().flatten();
    let all: String = all.flat_map(|way| [way, ", "]).collect();
    format!("{all}or try a chip with more, such as --chip scamp5-wide")
}
