//! What a program costs: folds over its steps and the chip's numbers.

use super::{Action, Host, Step, SumOver};
use crate::{
    isa::{Device, Figure},
    unit::Words,
};

/// What some steps cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Cost {
    /// Instruction words that run.
    pub words: Words,
    /// Their time at the chip's clock, the launch of each kernel included, in microseconds.
    pub array_us: f64,
    /// Time of the host's operations, in microseconds.
    pub host_us: f64,
}

impl Cost {
    /// Of some steps. A repetition counts as often as it runs; what a program expands to
    /// ([`Program::expand`](super::Program::expand)) ends long before counts do.
    #[must_use]
    pub fn of(steps: &[Step], device: &Device) -> Self {
        let mut cost = Self::default();
        let mut launched = false;
        for step in steps {
            match &step.action {
                Action::Word(word) => {
                    let words = device.words(word);
                    cost.words.0 = cost.words.0.saturating_add(words);
                    cost.array_us += words as f64 / device.value(Figure::Clock);
                    if !launched {
                        cost.array_us += device.value(Figure::Launch);
                    }
                    launched = true;
                }
                Action::Host(host) => {
                    cost.host_us += host_us(host, device);
                    launched = false;
                }
                Action::Repeat { times, body } => {
                    let once = Self::of(body, device);
                    let times = u64::from(*times);
                    let words = once.words.0.saturating_mul(times);
                    cost.words.0 = cost.words.0.saturating_add(words);
                    cost.array_us += once.array_us * times as f64;
                    cost.host_us += once.host_us * times as f64;
                    launched = false;
                }
            }
        }
        cost
    }

    /// All of its time, in microseconds.
    #[must_use]
    pub fn micros(&self) -> f64 {
        self.array_us + self.host_us
    }
}

/// Instruction words that some steps take in the kernel store, whoever launches them: a repetition is
/// stored once. Of a program it is [`Expansion::stored`](super::Expansion::stored).
#[must_use]
pub fn stored(steps: &[Step], device: &Device) -> Words {
    steps
        .iter()
        .map(|step| match &step.action {
            Action::Word(word) => Words(device.words(word)),
            Action::Host(_) => Words(0),
            Action::Repeat { body, .. } => stored(body, device),
        })
        .sum()
}

/// Time of a host operation, in microseconds.
#[must_use]
pub fn host_us(host: &Host, device: &Device) -> f64 {
    let row = device.host(host.kind());
    let pixels = device.value(Figure::Height) * device.value(Figure::Width);
    let span = |a: u16, b: u16| f64::from(b.abs_diff(a)) + 1.0;
    let (calls, items) = match host {
        Host::ScanEvents { slots, .. } | Host::ScanEventsFrom { slots, .. } => {
            (1.0, f64::from(*slots))
        }
        Host::ReadAnalog { .. } => (1.0, pixels),
        Host::ScanAnalog { window, step, .. } => {
            let rows = (span(window.top, window.bottom) / f64::from(step.0.max(1))).ceil();
            let columns = (span(window.right, window.left) / f64::from(step.1.max(1))).ceil();
            (1.0, rows * columns)
        }
        Host::ScanBlocks { .. } => (1.0, 64.0),
        Host::ScanDigital {
            first_row,
            last_row,
            ..
        } => (1.0, span(*first_row, *last_row)),
        Host::GlobalSum {
            over: SumOver::Grid8,
            ..
        }
        | Host::GlobalCount {
            over: SumOver::Grid8,
            ..
        } => (2.0, 0.0),
        Host::LoadIn { .. }
        | Host::LoadInRaw { .. }
        | Host::LoadDac { .. }
        | Host::ReadPixel { .. }
        | Host::ScanBoundingBox { .. }
        | Host::GlobalSum { .. }
        | Host::GlobalOr { .. }
        | Host::GlobalCount { .. }
        | Host::Load { .. }
        | Host::Select { .. }
        | Host::DrawBegin { .. }
        | Host::Draw { .. }
        | Host::DrawEnd => (1.0, 0.0),
    };
    calls * row.call.value + items * row.item.as_ref().map_or(0.0, |i| i.value)
}
