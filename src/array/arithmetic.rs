//! A domain of numbers chosen at run time.

use std::{fmt, str::FromStr};

use super::{
    Array, Bfloat, Chip, CodeError, Exact, Fixed, Half, Layout, Settings, Silicon, Single,
};
use crate::{
    config::asked,
    isa::{Device, Errors, Figure},
    number::{FIXED, FixedFormat, Format, FormatError, Q, Width, known_floats},
    plane::Size,
    program::Code,
};

/// The arithmetic of an array, by name: `exact`, `f32`, `f16`, `bf16`, `qM.N`, `silicon`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Arithmetic {
    /// Cells hold a number format and do not err otherwise.
    Number(Format),
    /// Cells err as the real chip's do.
    Silicon {
        /// Which chip, and which noise.
        seed: u64,
    },
}

/// No such arithmetic.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("unknown domain `{name}`")]
#[diagnostic(help(
    "{}known are {}, qM.N for fixed point (for instance q8.8, q4.12, q8.24, q1.7; qM.N-wrap wraps; M + N is 8, 16 or 32), and silicon",
    asked(name, ["exact", "silicon"]),
    known_floats()
))]
pub struct ArithmeticError {
    /// What was given.
    pub name: String,
}

impl Arithmetic {
    /// What is to be said of something that was set, where it changes nothing since these cells do
    /// not err; `option` sets the domain.
    #[must_use]
    pub fn changes_nothing(self, set: &str, option: &str) -> Option<String> {
        if matches!(self, Self::Silicon { .. }) {
            return None;
        }
        Some(format!(
            "{set} changes nothing in the domain {self}, whose cells do not err: {option} silicon has errors"
        ))
    }

    /// The same of a number of the chip; none of one that does not say how cells err.
    #[must_use]
    pub fn unused(self, figure: Figure, option: &str) -> Option<String> {
        let is_error = figure.key().0 == "error";
        is_error.then(|| self.changes_nothing(&figure.to_string(), option))?
    }
}

impl FromStr for Arithmetic {
    type Err = ArithmeticError;

    fn from_str(name: &str) -> Result<Self, ArithmeticError> {
        if name == "silicon" {
            return Ok(Self::Silicon { seed: 0 });
        }
        let known = name.parse().map(Self::Number);
        known.map_err(|_: FormatError| ArithmeticError { name: name.into() })
    }
}

impl fmt::Display for Arithmetic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(Format::F64) => f.write_str("exact"),
            Self::Number(format) => format.fmt(f),
            Self::Silicon { .. } => f.write_str("silicon"),
        }
    }
}

impl Arithmetic {
    /// The names of all, with commas between: `exact, f32, …`, [`FIXED`], `silicon`.
    #[must_use]
    pub fn names() -> String {
        let floats = Format::floats().map(|format| Self::Number(format).to_string() + ", ");
        floats.collect::<String>() + FIXED + ", silicon"
    }

    /// The same with another seed, where chance plays a part.
    #[must_use]
    pub const fn with_seed(self, seed: u64) -> Self {
        match self {
            Self::Number(_) => self,
            Self::Silicon { .. } => Self::Silicon { seed },
        }
    }

    /// Bytes that a chip of this size holds while it runs: registers, photodiodes and bits,
    /// and the errors of `silicon`.
    #[must_use]
    pub fn bytes(self, device: &Device, size: Size) -> u128 {
        let planes = u128::from(Layout::new(device, size).analog) + 1;
        let errors = match self {
            Self::Silicon { .. } => 2 * 4 * planes + 8,
            Self::Number(_) => 0,
        };
        self.bytes_of_registers(device, size) + size.pixels() as u128 * errors
    }

    /// Bytes of all that its registers, photodiodes and bits hold.
    #[must_use]
    pub fn bytes_of_registers(self, device: &Device, size: Size) -> u128 {
        let layout = Layout::new(device, size);
        let cell = match self {
            Self::Number(Format::F64) => 8,
            // The halves are held in f32.
            Self::Number(Format::F32 | Format::F16 | Format::Bf16) | Self::Silicon { .. } => 4,
            Self::Number(Format::Fixed(format)) => u128::from(format.bits()) / 8,
        };
        let planes = u128::from(layout.analog) + 1;
        // In eighths of a byte: three more planes of bits than there are registers.
        let bits = u128::from(layout.digital) + 3;
        let pixel = 8 * cell * planes + bits;
        size.pixels() as u128 * pixel / 8
    }

    /// A chip in this arithmetic.
    ///
    /// # Errors
    /// As [`Chip::new`].
    pub fn chip(
        self,
        name: &str,
        code: &Code,
        device: &Device,
        size: Size,
        settings: Settings,
    ) -> Result<Box<dyn Array + Send>, CodeError> {
        macro_rules! chip {
            ($domain:expr) => {
                Ok(Box::new(Chip::new(
                    name, $domain, code, device, size, settings,
                )?))
            };
        }
        match self {
            Self::Number(Format::F64) => chip!(Exact),
            Self::Number(Format::F32) => chip!(Single),
            Self::Number(Format::F16) => chip!(Half),
            Self::Number(Format::Bf16) => chip!(Bfloat),
            Self::Number(Format::Fixed(format)) => match format.bits() {
                8 => chip!(fixed::<i8>(format)),
                16 => chip!(fixed::<i16>(format)),
                _ => chip!(fixed::<i32>(format)),
            },
            Self::Silicon { seed } => {
                let errors = Errors::from_device(device);
                chip!(Silicon::new(errors, seed, &Layout::new(device, size)))
            }
        }
    }
}

fn fixed<T: Width>(format: FixedFormat) -> Fixed<T> {
    Fixed::new(Q::new(format.fraction()).with_overflow(format.overflow()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chip_has_the_domain_that_was_asked_for() {
        for name in [
            "exact",
            "f32",
            "f16",
            "bf16",
            "q8.8",
            "q8.0",
            "q1.7",
            "q8.24",
            "q4.12-wrap",
            "silicon",
        ] {
            let arithmetic: Arithmetic = name.parse().unwrap();
            assert_eq!(arithmetic.to_string(), name);
            let device = Device::scamp5();
            let settings = Settings::from_device(&device);
            let chip = arithmetic.chip("x", &Code::default(), &device, Size::new(2, 2), settings);
            assert_eq!(chip.unwrap().domain(), name);
        }
        assert!("silicone".parse::<Arithmetic>().is_err());
    }
}
