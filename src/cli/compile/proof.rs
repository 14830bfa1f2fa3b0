//! A filter read back from its program, as proof.

use miette::{WrapErr, miette};

use super::{Compiled, Proof, RANGED, TRACED, noises};
use crate::{
    array::{
        Arithmetic, Input, Settings, check_capture, effort,
        range::{self, Interval},
        taps,
    },
    compile::{CompileError, Filter, check_words, largest_of_both_signs, naive_cost},
    event::Packet,
    isa::{Analog, Figure, PrimitiveKind},
    number::Format,
    plane::{Plane, Size},
    program::{Action, Code, Overrides, Program, Step},
    sensor::Sensor as _,
    unit::Micros,
};

impl Proof<'_> {
    /// Reads the kernels back from the text, and the ranges.
    pub(super) fn compiled(
        &self,
        text: String,
        filter: Filter,
        limited: bool,
    ) -> miette::Result<Compiled> {
        check_words(&text, self.device)?;
        if self.input == Input::Light {
            check_capture(self.device)?;
        }
        let program = Program::parse("compiled", &text)?;
        let expansion = program.expand(self.device, &Overrides::default());
        let expansion = expansion.map_err(|faults| self.too_long(&filter, faults))?;
        let steps = &expansion.code.frame;
        let settings = Settings::from_device(self.device);
        let mut kernels = Vec::new();
        let filter_words = filter.words.len();
        let long = filter_words > TRACED;
        // Weights times the chip's scale of light would round; without it they are what they are.
        let unscaled = Settings {
            gain: 1.0,
            ..settings
        };
        let unscale = match self.input {
            Input::Light => settings.gain / self.scale,
            Input::Register(_) => 1.0 / self.scale,
        };
        for (kernel, register) in self.kernels.iter().zip(self.results) {
            let (read, others) = if long {
                (self.impulse(&expansion.code, unscaled, *register)?, false)
            } else {
                let taps = taps::read(steps, self.device, unscaled, *register)
                    .wrap_err("the program cannot be read back")?;
                let others = taps.taps.keys().any(|(input, ..)| *input != self.input);
                (taps.kernel(self.input), others)
            };
            let found = Self::framed(&read, kernel.weights().dim());
            let found = found.map(|found| found.mapv(|w| w * unscale + 0.0));
            if others || found.as_ref() != Some(kernel.weights()) {
                return Err(miette!(
                    help = "this is a fault of amacrine: please report the kernel and the command",
                    "the compiled program computes another kernel than asked for"
                ));
            }
            kernels.extend(found);
        }
        // What comes after the filter compares with a memory that may hold anything.
        let host = |step: &Step| matches!(step.action, Action::Host(_));
        let end = steps.iter().position(host).unwrap_or(steps.len());
        let words = &steps[..end];
        let weights = self.kernels.iter().map(|it| it.weights().len() as u64);
        let weights: u64 = weights.sum();
        let ranged = effort(words, self.device)
            .is_some_and(|effort| effort.saturating_mul(weights) <= RANGED);
        let (results, saturations) = if ranged {
            let ranges = range::of(words, self.device, settings, self.inputs)
                .wrap_err("the program's ranges cannot be determined")?;
            let of = |r: &Analog| ranges.registers.get(usize::from(r.0)).copied();
            let results: Vec<Interval> = self.results.iter().filter_map(of).collect();
            (results, ranges.saturations.len())
        } else {
            let high = match self.input {
                Input::Light => self.inputs.light.high * settings.gain,
                Input::Register(_) => self.inputs.registers.high,
            };
            let most = filter.peak * high;
            (
                self.bounds(&kernels),
                usize::from(most > largest_of_both_signs(self.device)),
            )
        };
        if limited && saturations > 0 && ranged {
            return Err(miette!(
                help = "this is a fault of amacrine: please report the kernel and the command",
                "the compiled program saturates for the input that it was made for"
            ));
        }
        Ok(Compiled {
            results,
            thresholds: Vec::new(),
            ranged: false,
            to_border: false,
            on_chip: Vec::new(),
            noises: noises(&filter, self.device, self.kernels),
            filters: vec![filter.clone()],
            memory: None,
            in_bits: Vec::new(),
            readouts: None,
            saturations,
            snake: naive_cost(self.kernels)? * self.device.row(PrimitiveKind::Bus).words(),
            results_in: self.results.to_vec(),
            scales: vec![self.scale; self.kernels.len()],
            text,
            expansion,
            filter,
            kernels,
        })
    }

    /// What kernels make of the inputs.
    pub(super) fn bounds(&self, kernels: &[Plane<f64>]) -> Vec<Interval> {
        let Interval { low, high } = match self.input {
            Input::Light => self.inputs.light,
            Input::Register(_) => self.inputs.registers,
        };
        let end = |kernel: &Plane<f64>, [least, most]: [f64; 2]| {
            let part = |w: &f64| if *w > 0.0 { w * most } else { w * least };
            self.scale * kernel.iter().map(part).sum::<f64>()
        };
        let bound = |kernel| Interval::new(end(kernel, [high, low]), end(kernel, [low, high]));
        kernels.iter().map(bound).collect()
    }

    /// The kernel by what one bright pixel leaves behind: for programs that reach too far to be
    /// read back as forms.
    fn impulse(
        &self,
        code: &Code,
        settings: Settings,
        register: Analog,
    ) -> miette::Result<Plane<f64>> {
        const SIDE: usize = 64;
        let middle = (SIDE / 2, SIDE / 2);
        let left_by = |level: f64| -> miette::Result<Plane<f64>> {
            let mut picture = Plane::zeros((SIDE, SIDE));
            picture[middle] = level;
            let size = Size::new(SIDE, SIDE);
            let code = code.clone();
            let mut chip = Arithmetic::Number(Format::F64).chip(
                "compiled",
                &code,
                self.device,
                size,
                settings,
            )?;
            match self.input {
                Input::Light => chip.expose(&picture)?,
                Input::Register(register) => chip.set_analog(register, &picture)?,
            }
            let mut packet = Packet::new(size, chip.channels());
            chip.run_frame(Micros(0), &mut packet)?;
            Ok(chip.analog(register))
        };
        let (dark, bright) = (left_by(0.0)?, left_by(1.0)?);
        let reach = 15;
        let weight = |(y, x): (usize, usize)| {
            let at = (middle.0 + reach - y, middle.1 + reach - x);
            bright[at] - dark[at]
        };
        Ok(Plane::from_shape_fn((2 * reach + 1, 2 * reach + 1), weight))
    }

    /// Too many words, said with numbers; else what the program's check says.
    pub(super) fn too_long(
        &self,
        filter: &Filter,
        faults: crate::config::Faults,
    ) -> miette::Report {
        let room = self.device.value(Figure::Store) as u64;
        let words = filter.word_count(self.device);
        if words > room {
            return CompileError::Store {
                words,
                room,
                chip: self.device.name().to_owned(),
                advice: "ask for fewer kinds, search longer (--effort), or use fewer digits (--to)"
                    .to_owned(),
            }
            .into();
        }
        faults.into()
    }

    /// The weights in a plane of this shape; `None` where one lies outside.
    pub(super) fn framed(found: &Plane<f64>, shape: (usize, usize)) -> Option<Plane<f64>> {
        let mut out = Plane::zeros(shape);
        let (height, width) = found.dim();
        for ((y, x), weight) in found.indexed_iter().filter(|(_, w)| **w != 0.0) {
            let y = (y + shape.0 / 2).checked_sub(height / 2)?;
            let x = (x + shape.1 / 2).checked_sub(width / 2)?;
            *out.get_mut((y, x))? = *weight;
        }
        Some(out)
    }
}
