//! Numbers that a program puts into cells, and that a format with ends does not hold.

use std::fmt;

use super::{Arithmetic, Settings};
use crate::{
    isa::Device,
    number::Format,
    program::{Action, Host, Step},
};

/// What of a program's numbers a format with ends does not hold. Displayed, it says so.
#[derive(Clone, Debug, PartialEq)]
pub struct Unheld {
    /// What cells hold.
    format: Format,
    /// What the photodiodes begin at, in LSB, where that is too large.
    reset: Option<f64>,
    /// The constant that is farthest beyond, in LSB, and the line that loads it.
    constant: Option<(f64, u32)>,
}

impl Unheld {
    /// Of a program that does these steps; none where the cells hold all of its numbers.
    #[must_use]
    pub fn of_program(
        cells: Arithmetic,
        parts: &[&[Step]],
        device: &Device,
        settings: &Settings,
    ) -> Option<Self> {
        let mut numbers = Numbers::default();
        for steps in parts {
            numbers.see(steps, device, settings);
        }
        Self::new(cells, &numbers, settings)
    }

    /// Of a program of which is known only that it reads the photodiodes.
    #[must_use]
    pub fn of_light(cells: Arithmetic, settings: &Settings) -> Option<Self> {
        let numbers = Numbers {
            reads_light: true,
            ..Numbers::default()
        };
        Self::new(cells, &numbers, settings)
    }

    fn new(cells: Arithmetic, numbers: &Numbers, settings: &Settings) -> Option<Self> {
        let Arithmetic::Number(format) = cells else {
            return None;
        };
        let [low, high] = format.ends()?;
        // What rounds to the last number lies within.
        let near = format.half_step();
        let beyond = |value: f64| f64::max(low - near - value, value - (high - near));
        let reset = Some(settings.reset_level).filter(|_| numbers.reads_light);
        let constants = numbers.constants.iter().copied();
        let unheld = Self {
            format,
            reset: reset.filter(|level| beyond(*level) > 0.0),
            constant: { constants.filter(|(value, _)| beyond(*value) > 0.0) }
                .max_by(|(a, _), (b, _)| beyond(*a).total_cmp(&beyond(*b))),
        };
        (unheld.reset.is_some() || unheld.constant.is_some()).then_some(unheld)
    }

    /// What becomes of these numbers.
    #[must_use]
    pub fn why(&self) -> &'static str {
        if self.format.wraps() {
            "values beyond that wrap around, so the program computes with other numbers"
        } else {
            "values beyond that are clipped, so the program computes with other numbers"
        }
    }

    /// The format to take instead.
    #[must_use]
    pub fn change(&self) -> String {
        let values = self.reset.into_iter();
        let values = values.chain(self.constant.map(|(value, _)| value));
        let held = |bits: &u8| {
            let most = (1_u64 << (*bits - 1)) as f64;
            values.clone().all(|value| -most <= value && value < most)
        };
        let bits = (1..32).find(held).unwrap_or(32);
        let own = 8 * self.format.bytes();
        let all = [16, 32]
            .into_iter()
            .find(|all| bits <= *all && own <= u64::from(*all));
        let fraction = all.unwrap_or(32) - bits;
        format!("take a format of {bits} bits or more before the point, such as q{bits}.{fraction}")
    }
}

impl fmt::Display for Unheld {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (low, last) = self.format.limits();
        let shown = |number: f64| (number * 1e3).round() / 1e3;
        write!(
            f,
            "{} holds {} to {} LSB",
            self.format,
            shown(low),
            shown(last)
        )?;
        if let Some(reset) = self.reset {
            write!(
                f,
                ", and not the {} LSB at which the photodiodes begin (light.reset)",
                shown(reset)
            )?;
        }
        let and = if self.reset.is_some() {
            "nor"
        } else {
            "and not"
        };
        match self.constant {
            Some((value, line)) => {
                write!(f, ", {and} the {} LSB that line {line} loads", shown(value))
            }
            None => Ok(()),
        }
    }
}

/// The numbers of a program.
#[derive(Default)]
struct Numbers {
    reads_light: bool,
    /// What the global input is driven with, in LSB, and in which line.
    constants: Vec<(f64, u32)>,
}

impl Numbers {
    fn see(&mut self, steps: &[Step], device: &Device, settings: &Settings) {
        for step in steps {
            let loaded = match &step.action {
                Action::Word(word) => {
                    let operands = device.operands(word);
                    self.reads_light |= operands.reads_light();
                    None
                }
                Action::Repeat { body, .. } => {
                    self.see(body, device, settings);
                    None
                }
                Action::Host(Host::LoadIn { value } | Host::LoadInRaw { value }) => Some(*value),
                Action::Host(Host::LoadDac { code }) => Some(settings.converters.drive(*code)),
                Action::Host(_) => None,
            };
            self.constants
                .extend(loaded.map(|value| (value, step.line)));
        }
    }
}
