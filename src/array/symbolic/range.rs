//! Between which values each register stays, and where a store can leave the range.
//!
//! As long as a program is linear, each cell is a linear form of what went in, and its bounds
//! are reached by some input. Beyond that (squares, limits, stores under an unknown FLAG)
//! cells are intervals; bounds hold, but need not be reached.

use std::collections::BTreeMap;

use super::{
    super::{Domain, Place, Settings, Share},
    form::Form,
    form::Input,
    pixel::{GenericError, GenericPixel, Ran, Symbolic},
};
use crate::{
    isa::{Analog, Device, operands::Access},
    number::Dyadic,
    plane::At,
    program::Step,
};

/// From `low` to `high`, both included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// The smallest value.
    pub low: f64,
    /// The largest value.
    pub high: f64,
}

impl Interval {
    /// From one to the other.
    #[must_use]
    pub const fn new(low: f64, high: f64) -> Self {
        Self { low, high }
    }

    /// Whether a value lies in it.
    #[must_use]
    pub fn contains(self, value: f64) -> bool {
        self.low <= value && value <= self.high
    }

    fn hull(self, other: Self) -> Self {
        Self::new(self.low.min(other.low), self.high.max(other.high))
    }
}

/// What can go in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inputs {
    /// The light on every pixel.
    pub light: Interval,
    /// What every register may hold beforehand, in LSB.
    pub registers: Interval,
}

impl Inputs {
    /// 8-bit light, and registers within the chip's range.
    #[must_use]
    pub fn from_device(device: &Device) -> Self {
        let (low, high) = device.register_range();
        Self {
            light: Interval::new(0.0, 255.0),
            registers: Interval::new(low, high),
        }
    }
}

/// What a program can do to the registers.
#[derive(Clone, Debug, PartialEq)]
pub struct Ranges {
    /// What each analogue register may hold in the end, in LSB.
    pub registers: Vec<Interval>,
    /// Stores that can leave the chip's range, by line, then by register.
    pub saturations: Vec<Saturation>,
}

/// A store that can leave the range of a register.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Saturation {
    /// Line of the program text, from 1.
    pub line: u32,
    /// Which register.
    pub register: Analog,
    /// What would be stored, were nothing limited here, in LSB.
    pub interval: Interval,
}

/// What `steps` can do with these inputs, in exact arithmetic, far from the border.
///
/// # Errors
/// When pixels are not treated alike.
pub fn of(
    steps: &[Step],
    device: &Device,
    settings: Settings,
    inputs: Inputs,
) -> Result<Ranges, GenericError> {
    let limits = settings.range();
    let bounds = Bounds { inputs };
    let mut generic = GenericPixel::new(&bounds, device, settings, steps)?;
    let mut found: BTreeMap<(u32, Analog), Interval> = BTreeMap::new();
    generic.run(steps, &mut |generic, Ran { line, word }| {
        let operands = device.operands(word);
        for register in operands.writes().filter_map(Access::analog) {
            let stored = generic.cell(register).stored;
            if stored.low < limits.0 || stored.high > limits.1 {
                let so_far = found.entry((line, register)).or_insert(stored);
                *so_far = so_far.hull(stored);
            }
        }
    })?;
    let registers = (0..generic.state.layout.analog)
        .map(|register| bounds.interval(&generic.cell(Analog(register)).value))
        .collect();
    let saturations = found
        .into_iter()
        .map(|((line, register), interval)| Saturation {
            line,
            register,
            interval,
        })
        .collect();
    Ok(Ranges {
        registers,
        saturations,
    })
}

/// Cells hold forms or intervals.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    inputs: Inputs,
}

#[derive(Clone, Debug, PartialEq)]
enum Value {
    Form(Form),
    Within(Interval),
}

#[derive(Clone, Debug, PartialEq)]
struct Cell {
    value: Value,
    /// What the last store would have stored, were nothing limited.
    stored: Interval,
}

impl Bounds {
    fn interval(&self, value: &Value) -> Interval {
        match value {
            Value::Within(interval) => *interval,
            Value::Form(form) => Interval::new(
                self.end(form, false).unwrap_or(f64::NEG_INFINITY),
                self.end(form, true).unwrap_or(f64::INFINITY),
            ),
        }
    }

    /// The lowest or the highest value of a form; `None` beyond what can be said exactly.
    fn end(&self, form: &Form, high: bool) -> Option<f64> {
        let mut end = form.constant;
        for ((input, _), weight) in &form.taps {
            let interval = match input {
                Input::Light => self.inputs.light,
                Input::Register(_) => self.inputs.registers,
            };
            let value = if (weight.to_f64() > 0.0) == high {
                interval.high
            } else {
                interval.low
            };
            end = end.plus(weight.times(Dyadic::from_f64(value)?)?)?;
        }
        Some(end.to_f64())
    }

    fn cell(&self, value: Value) -> Cell {
        Cell {
            stored: self.interval(&value),
            value,
        }
    }

    fn plus(&self, sum: &mut Value, other: &Value, times: i32) {
        if let (Value::Form(form), Value::Form(other)) = (&mut *sum, other) {
            let before = form.clone();
            if form.add(other, times).is_some() {
                return;
            }
            *form = before;
        }
        let (a, b) = (self.interval(sum), self.interval(other));
        let times = f64::from(times);
        let ends = [b.low * times, b.high * times];
        *sum = Value::Within(Interval::new(
            a.low + ends[0].min(ends[1]),
            a.high + ends[0].max(ends[1]),
        ));
    }
}

impl Domain for Bounds {
    type Cell = Cell;
    type Sum = Value;

    fn name(&self) -> String {
        "range".into()
    }

    fn hold(&self, value: f64) -> Cell {
        self.cell(match Dyadic::from_f64(value) {
            Some(value) => Value::Form(Form::constant(value)),
            None => Value::Within(Interval::new(value, value)),
        })
    }

    fn value(&self, cell: &Cell) -> f64 {
        let Interval { low, high } = self.interval(&cell.value);
        if low == high { low } else { f64::NAN }
    }

    fn nothing(&self) -> Value {
        Value::Form(Form::default())
    }

    fn add(&self, sum: &mut Value, cell: &Cell, times: i32) {
        self.plus(sum, &cell.value, times);
    }

    fn join(&self, sum: &mut Value, other: &Value) {
        self.plus(sum, other, 1);
    }

    fn store(&self, sum: &Value, share: Share, _: Place) -> Cell {
        let form = match sum {
            Value::Form(form) => form.stored(share.by),
            Value::Within(_) => None,
        };
        self.cell(form.map_or_else(
            || {
                let (sum, by) = (self.interval(sum), f64::from(share.by));
                // Rounding keeps order, so the ends of the rounded are the rounded ends.
                Value::Within(Interval::new((0.0 - sum.high) / by, (0.0 - sum.low) / by))
            },
            Value::Form,
        ))
    }

    fn square(&self, sum: &Value, gain: f64, _: Place) -> Option<Cell> {
        let Interval { low, high } = self.interval(sum);
        let most = low.abs().max(high.abs());
        let least = if low <= 0.0 && high >= 0.0 {
            0.0
        } else {
            low.abs().min(high.abs())
        };
        let ends = [least * least * gain, most * most * gain];
        let interval = Interval::new(ends[0].min(ends[1]), ends[0].max(ends[1]));
        Some(self.cell(Value::Within(interval)))
    }

    fn positive(&self, sum: &Value) -> Option<bool> {
        let Interval { low, high } = self.interval(sum);
        if low > 0.0 {
            Some(true)
        } else if high <= 0.0 {
            Some(false)
        } else {
            None
        }
    }

    fn limit(&self, cell: Cell, (lowest, highest): (f64, f64)) -> Cell {
        let Interval { low, high } = cell.stored;
        if low >= lowest && high <= highest {
            return cell;
        }
        let limited = |end: f64| end.clamp(lowest, highest);
        Cell {
            value: Value::Within(Interval::new(limited(low), limited(high))),
            ..cell
        }
    }
}

impl Symbolic for Bounds {
    fn unknown(&self, input: Input, at: At) -> Cell {
        self.cell(Value::Form(Form::input(input, at)))
    }

    fn light(&self, settings: &Settings, at: At) -> Cell {
        let mut light = self.hold(settings.reset_level).value;
        let gain = Dyadic::from_f64(settings.gain).filter(|gain| !gain.is_zero());
        if let (Value::Form(form), Some(gain)) = (&mut light, gain) {
            form.taps.insert((Input::Light, at), gain);
        } else {
            let one = |light: f64| settings.reset_level + settings.gain * light;
            let ends = [one(self.inputs.light.low), one(self.inputs.light.high)];
            light = Value::Within(Interval::new(ends[0].min(ends[1]), ends[0].max(ends[1])));
        }
        self.cell(light)
    }

    fn either(&self, old: &Cell, new: &Cell, _: u64) -> Cell {
        if old.value == new.value {
            return new.clone();
        }
        let hull = self.interval(&old.value).hull(self.interval(&new.value));
        Cell {
            value: Value::Within(hull),
            stored: new.stored,
        }
    }
}
