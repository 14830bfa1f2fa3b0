//! What comes out of a filter on the chip: it is run in the model of the chip, beside itself in exact
//! arithmetic.

use super::{Aim, Compiled};
use crate::{
    array::{
        Settings,
        range::{Inputs, Interval},
        survival::{Analogue, Survival, survival},
    },
    compile::{DriveMemory, Filter, Forecast, Signal},
    isa::{Analog, Cell, Device, Errors},
    kernel::Kernel,
    program::{Overrides, Program},
    unit::Lsb,
};

/// A chip to run on; others differ in which pixels are off by how much.
const SEED: u64 = 0;

/// A result of a filter in the chip's model, of inputs that are uniform round their middle.
#[derive(Clone, Copy, serde::Serialize)]
pub(super) struct OnChip {
    /// The farthest of an input from the middle, LSB.
    pub(super) amplitude: f64,
    /// The least and the most input, LSB.
    pub(super) inputs: [f64; 2],
    /// With the exact filter, over all pixels of all frames, its constant left out; none where a
    /// result is the same everywhere.
    pub(super) correlation: Option<f64>,
    /// Standard deviation of what follows the exact filter, LSB of the result.
    pub(super) signal: f64,
    /// Standard deviation of what does not: noise, mismatch, saturation, LSB.
    pub(super) noise: f64,
    /// Where the exact result is 0, LSB.
    pub(super) offset: f64,
}

impl OnChip {
    /// Runs the words of a filter.
    ///
    /// # Errors
    /// When the array cannot run them.
    pub(super) fn run(
        filter: &Filter,
        device: &Device,
        results: &[Analog],
        signal: Signal,
    ) -> miette::Result<Vec<Self>> {
        let Signal { mean, amplitude } = signal;
        // Without a word the input is the result.
        if filter.words.is_empty() {
            let exact = Self {
                amplitude,
                inputs: [mean - amplitude, mean + amplitude],
                correlation: Some(1.0),
                signal: amplitude / 3f64.sqrt(),
                noise: 0.0,
                offset: 0.0,
            };
            return Ok(vec![exact; results.len()]);
        }
        let program = Program::parse("filter", &filter.text(device, 0))?;
        let code = program.expand(device, &Overrides::default())?.code;
        let inputs = Inputs {
            registers: Interval::new(mean - amplitude, mean + amplitude),
            ..Inputs::from_device(device)
        };
        let settings = Settings::from_device(device);
        let cells: Vec<Cell> = results.iter().map(|it| Cell::Analog(*it)).collect();
        let all = survival(&code, true, device, settings, inputs, SEED, &cells)?;
        let of = |it: Survival| match it {
            Survival::Analogue(found) => Some(Self::new(signal, found)),
            // A filter leaves no bits.
            Survival::Bits(_) => None,
        };
        Ok(all.into_iter().filter_map(of).collect())
    }

    const fn new(Signal { mean, amplitude }: Signal, found: Analogue) -> Self {
        Self {
            amplitude,
            inputs: [mean - amplitude, mean + amplitude],
            correlation: found.correlation,
            signal: found.signal,
            noise: found.noise,
            offset: found.offset,
        }
    }

    /// The correlation; 0 where there is none.
    pub(super) fn kept(&self) -> f64 {
        self.correlation.unwrap_or(0.0)
    }

    /// For people.
    pub(super) fn line(&self, device: &Device) -> String {
        // Of what is the same everywhere there is none.
        let correlation = self.correlation.map_or_else(
            || "no correlation".to_owned(),
            |it| format!("correlation {it:.3}"),
        );
        format!(
            "{correlation} with the exact filter, for inputs from {} to {} LSB: {:.2} of noise and mismatch beside {:.2} of signal, {:.0} of constant (run in the model of the chip: {})",
            Lsb(self.inputs[0]).rounded(),
            Lsb(self.inputs[1]).rounded(),
            Lsb(self.noise),
            Lsb(self.signal),
            Lsb(self.offset + 0.0),
            Errors::evidence_with_range(device).word(),
        )
    }
}

impl Compiled {
    /// What to know before a program is taken of which hardly anything comes out of the chip.
    pub(super) fn warning(&self, kernels: &[Kernel], aim: Aim) -> Option<String> {
        // Without a word the input is the result.
        if self.filter.words.is_empty() {
            return None;
        }
        let asked = { self.on_chip.iter().zip(kernels) }.filter(|(_, kernel)| !kernel.is_zero());
        let worst = asked.map(|(it, _)| it.kept()).fold(1.0, f64::min);
        let other = match aim {
            Aim::Silicon => "search longer (--effort)",
            Aim::Events | Aim::Exact | Aim::Words => "leave --objective out",
        };
        let what = if worst < Forecast::NOTHING {
            "the chip's errors hide the kernel"
        } else if worst < Forecast::NOISE {
            "the chip gives more noise than signal"
        } else {
            return None;
        };
        let narrower = if self.memory.is_some() {
            "a higher threshold"
        } else {
            "a narrower range of the input (--input)"
        };
        // Weights that are all as large have no digit to spare.
        let is_flat = |kernel: &Kernel| {
            let sizes = kernel.weights().iter().map(|w| w.abs());
            let mut sizes = sizes.filter(|size| *size != 0.0);
            let first = sizes.next();
            sizes.all(|size| Some(size) == first)
        };
        let fewer = if kernels.iter().all(is_flat) {
            ""
        } else {
            "fewer digits (--to), "
        };
        Some(format!(
            "warning: {what} (correlation {worst:.3} with the exact filter): the program is useful in exact arithmetic only; use {fewer}{narrower}, or {other}\n"
        ))
    }

    /// What to know of an aim that looks at one kernel's events.
    pub(super) fn aimed(&self, kernels: &[Kernel], aim: Aim) -> Option<String> {
        let apart = kernels.len() > 1 && self.memory != Some(DriveMemory::Shared);
        (aim == Aim::Events && apart).then(|| {
            "warning: --objective events is for one kernel: several kinds with a memory each are compiled as with --objective exact; --memory shared compiles each kind for its events\n"
                .to_owned()
        })
    }

    /// What to know of thresholds that no change of the light reaches, with what the kinds are called.
    pub(super) fn unreached(&self, names: &[Option<String>], device: &Device) -> Option<String> {
        let own = |kind: usize| match names.get(kind) {
            Some(Some(name)) => format!("{kind} ({name})"),
            _ => kind.to_string(),
        };
        let (mut never, mut one_sign) = (Vec::new(), Vec::new());
        for (kind, (thresholds, result)) in self.thresholds.iter().zip(&self.results).enumerate() {
            let reach = self.reach(result, device);
            let dead = [0, 1].map(|sign| thresholds[sign] >= reach[sign]);
            let told = |threshold: f64, reach: f64| {
                format!(
                    "kind {} has a threshold of {threshold:.1} LSB, but its result changes by {reach:.1} at most",
                    own(kind)
                )
            };
            match dead {
                [true, true] => {
                    let nearer = usize::from(thresholds[1] < thresholds[0]);
                    never.push(told(thresholds[nearer], reach[nearer]));
                }
                [true, false] => one_sign.push(format!("ON: {}", told(thresholds[0], reach[0]))),
                [false, true] => one_sign.push(format!("OFF: {}", told(thresholds[1], reach[1]))),
                [false, false] => {}
            }
        }
        let warning = |what: &str, told: &[String]| {
            (!told.is_empty()).then(|| {
                format!(
                    "warning: {what}: {}; lower the threshold\n",
                    told.join("; ")
                )
            })
        };
        let both = [
            warning("no light gives an event", &never),
            warning("no light gives an event of one sign", &one_sign),
        ];
        let all: Vec<String> = both.into_iter().flatten().collect();
        (!all.is_empty()).then(|| all.concat())
    }

    /// By how much a result can change upwards and downwards. What is compared with a memory of the
    /// drive moves from end to end; with one of the pixel the result is the change itself.
    fn reach(&self, result: &Interval, device: &Device) -> [f64; 2] {
        if self.memory == Some(DriveMemory::Shared) {
            let (low, high) = device.register_range();
            // What lies beyond is cut off in the register.
            [result.high.min(high), (-result.low).min(-low) + 0.0]
        } else {
            [result.high - result.low; 2]
        }
    }
}
