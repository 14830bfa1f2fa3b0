//! What a program takes of its chip: words, registers, time, and what its errors do.

use std::collections::BTreeSet;

use super::{super::design::Compiled, estimate::Estimate, named::Named, time::Time};
use crate::{
    compile::{FilterNoise, SensorProgram},
    isa::{Cell, Device, Evidence, Figure, Role},
    program::{CellEffect, Code, Cost},
};

/// A program on its chip.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct OnChip {
    /// Instruction words of the filter.
    pub filter_words: u64,
    /// Instruction words of a frame.
    pub frame_words: u64,
    /// Words that the program takes of the store, the first frame's included.
    pub stored_words: u64,
    /// Words that the store holds.
    pub store: Estimate,
    /// Analogue registers that the whole program uses.
    pub registers: usize,
    /// Analogue registers that a pixel has, NEWS left out.
    pub registers_of: usize,
    /// Halvings of the light before anything else, a bit each.
    pub prescale_bits: u32,
    /// What they are for.
    pub halved_for: HalvedFor,
    /// Whether results are right up to the border.
    pub border: bool,
    /// Whether all sums stay in range, the chip's transfer errors included.
    pub holds: bool,
    /// Time.
    pub time: Time,
    /// What the chip's errors leave in a result.
    pub noise: Noise,
}

/// What light, or its change, is halved for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum HalvedFor {
    /// Every sum stays in range.
    Range,
    /// The most events on the chip: large sums may leave the range.
    Events,
}

impl HalvedFor {
    pub(super) fn of(program: &SensorProgram) -> Self {
        let mut filters = program.each_filter().iter();
        if filters.any(|filter| filter.decided.is_some()) {
            Self::Events
        } else {
            Self::Range
        }
    }
}

/// The compiler's prediction, to first order, at one uniform level of light.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Noise {
    /// The level.
    pub at_lsb: f64,
    /// From frame to frame.
    pub temporal: Estimate,
    /// From pixel to pixel, the same in every frame.
    pub fixed: Estimate,
    /// The threshold, where it is compared.
    pub threshold_lsb: f64,
    /// The threshold over the noise of a difference of two frames; none without noise.
    pub margin: Option<f64>,
    /// The same at the most noise that the public data allow.
    pub least_margin: Option<f64>,
    /// Transfer errors of one store that stay in the result.
    pub offset_stores: f64,
}

impl OnChip {
    /// Of a compiled program and the threshold that it compares with, in LSB.
    pub(super) fn new(
        compiled: &Compiled,
        device: &Device,
        threshold_lsb: f64,
        time: Time,
    ) -> Self {
        let (program, code) = (&compiled.program, &compiled.code);
        let filter = &program.filter;
        Self {
            filter_words: filter.word_count(device),
            frame_words: Cost::of(&code.frame, device).words.0,
            stored_words: compiled.stored.0,
            store: Estimate::figure(device, Figure::Store),
            registers: registers(code, device),
            registers_of: device.registers().analog.len() - 1,
            prescale_bits: filter.prescale,
            halved_for: HalvedFor::of(program),
            border: filter.wrong_from_border(device) == 0,
            holds: filter.holds,
            noise: Noise::new(program, device, threshold_lsb),
            time,
        }
    }
}

/// Analogue registers that a program uses, NEWS left out.
pub(super) fn registers(code: &Code, device: &Device) -> usize {
    let mut cells = BTreeSet::new();
    for steps in [&code.init, &code.frame] {
        let CellEffect { reads, writes, .. } = CellEffect::of(steps, device);
        cells.extend(reads);
        cells.extend(writes);
    }
    let news = device.news();
    let ordinary = |cell: &&Cell| matches!(cell, Cell::Analog(register) if *register != news);
    cells.iter().filter(ordinary).count()
}

impl Noise {
    fn new(program: &SensorProgram, device: &Device, threshold_lsb: f64) -> Self {
        let filter = &program.filter;
        let of = |device: &Device| {
            let of = filter.noise(device, FilterNoise::MIDDLE);
            of.first().map_or((0.0, 0.0), |n| (n.temporal, n.fixed))
        };
        let (temporal, fixed) = of(device);
        let noisiest = Figure::in_role(Role::Noise).try_fold(device.clone(), |device, figure| {
            let most = Named::Figure(figure).ends(&device)[1];
            device.what_if(figure, most)
        });
        let noisiest = noisiest.map_or(temporal, |device| of(&device).0);
        let made_of = |value, role: Role, source: &str| {
            let one = Estimate::one(value, "LSB", Evidence::Modelled, source);
            let figures: Vec<Named> = Figure::in_role(role).map(Named::Figure).collect();
            one.made_of(device, &figures)
        };
        // A decision takes the difference of two frames.
        let margin = |temporal: f64| threshold_lsb / (2f64.sqrt() * temporal);
        Self {
            at_lsb: FilterNoise::MIDDLE,
            temporal: made_of(
                temporal,
                Role::Noise,
                "noise of every store, to first order, at the value of the chip's data",
            ),
            fixed: made_of(
                fixed,
                Role::Mismatch,
                "mismatch of every store and of every bus that splits, to first order, at the values of the chip's data",
            ),
            threshold_lsb,
            margin: (temporal > 0.0).then(|| margin(temporal)),
            least_margin: (noisiest > 0.0).then(|| margin(noisiest)),
            offset_stores: filter.offsets.first().copied().unwrap_or(0.0),
        }
    }
}
