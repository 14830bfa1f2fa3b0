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
        let Counts {
            words,
            launches,
            host_us,
        } = Counts::of(steps, device);
        Self {
            words: Words(words),
            array_us: array_us(Words(words), launches, device),
            host_us,
        }
    }

    /// All of its time, in microseconds.
    #[must_use]
    pub fn micros(&self) -> f64 {
        self.array_us + self.host_us
    }

    /// Frames a second at most, of a frame that costs this.
    #[must_use]
    pub fn frames_per_second(&self) -> f64 {
        1e6 / self.micros()
    }
}

/// Time of words on the array, and of launches, in microseconds.
#[must_use]
pub fn array_us(words: Words, launches: u64, device: &Device) -> f64 {
    let launches = launches as f64 * device.value(Figure::Launch);
    words.0 as f64 / device.value(Figure::Clock) + launches
}

/// What is counted first and timed as a whole: a sum of times has the rounding of each.
#[derive(Clone, Copy, Default)]
struct Counts {
    words: u64,
    launches: u64,
    host_us: f64,
}

impl Counts {
    fn of(steps: &[Step], device: &Device) -> Self {
        let mut counts = Self::default();
        let mut launched = false;
        for step in steps {
            match &step.action {
                Action::Word(word) => {
                    counts.words = counts.words.saturating_add(device.words(word));
                    counts.launches = counts.launches.saturating_add(u64::from(!launched));
                    launched = true;
                }
                Action::Host(host) => {
                    counts.host_us += host_us(host, device);
                    launched = false;
                }
                Action::Repeat { times, body } => {
                    let once = Self::of(body, device);
                    let times = u64::from(*times);
                    let add = |all: u64, once: u64| all.saturating_add(once.saturating_mul(times));
                    counts.words = add(counts.words, once.words);
                    counts.launches = add(counts.launches, once.launches);
                    counts.host_us += once.host_us * times as f64;
                    launched = false;
                }
            }
        }
        counts
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
    let [calls, items] = host_calls(host, device);
    calls * row.call.value + items * row.item.as_ref().map_or(0.0, |i| i.value)
}

/// How often a host operation is called, and how many slots, samples or rows it takes.
pub(super) fn host_calls(host: &Host, device: &Device) -> [f64; 2] {
    let pixels = device.value(Figure::Height) * device.value(Figure::Width);
    let span = |a: u16, b: u16| f64::from(b.abs_diff(a)) + 1.0;
    match host {
        Host::ScanEvents { slots, .. } => [1.0, f64::from(*slots)],
        Host::ReadAnalog { .. } => [1.0, pixels],
        Host::ScanAnalog { window, step, .. } => {
            let rows = (span(window.top, window.bottom) / f64::from(step.0.max(1))).ceil();
            let columns = (span(window.right, window.left) / f64::from(step.1.max(1))).ceil();
            [1.0, rows * columns]
        }
        Host::ScanBlocks { .. } => [1.0, 64.0],
        Host::ScanDigital {
            first_row,
            last_row,
            ..
        } => [1.0, span(*first_row, *last_row)],
        Host::GlobalSum {
            over: SumOver::Grid8,
            ..
        }
        | Host::GlobalCount {
            over: SumOver::Grid8,
            ..
        } => [2.0, 0.0],
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
        | Host::DrawEnd => [1.0, 0.0],
    }
}
