//! The linear kernel that a program computes, read back from the program itself.
//!
//! Every cell holds a linear form of what went in: sums and halves of forms are forms, so at
//! the end each register is its own kernel, in dyadic rationals, without rounding. Where the
//! program does something else (a third, a square, a store that depends on FLAG) the cell
//! remembers which line it was.
//!
//! Nothing is limited on the way: [`range`](super::range) says for which inputs that is true.

use std::collections::BTreeMap;

use super::{
    super::{Domain, Place, Settings, Share},
    form::Form,
    form::Input,
    pixel::{GenericError, GenericPixel, Symbolic},
};
use crate::{
    isa::{Analog, Device},
    number::Dyadic,
    plane::{At, Plane},
    program::{Action, Host, Step},
};

/// `register(p) = constant + Σ weight · input(p + (dy, dx))`, far from the border.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Taps {
    /// By input and place `(dy, dx)`, row offsets downwards; no weight is 0.
    pub taps: BTreeMap<(Input, isize, isize), Dyadic>,
    /// What does not depend on any input, in LSB.
    pub constant: Dyadic,
}

impl Taps {
    /// The weights of one input as the smallest centred plane with odd sides, row 0 north.
    #[must_use]
    pub fn kernel(&self, input: Input) -> Plane<f64> {
        let own = || self.taps.iter().filter(|((of, _, _), _)| *of == input);
        let far = |along: fn((isize, isize)) -> isize| {
            let distances = own().map(|((_, dy, dx), _)| along((*dy, *dx)).unsigned_abs());
            distances.max().unwrap_or(0)
        };
        let (rows, columns) = (far(|(dy, _)| dy), far(|(_, dx)| dx));
        let mut kernel = Plane::zeros((2 * rows + 1, 2 * columns + 1));
        for ((_, dy, dx), weight) in own() {
            let at = (
                rows.wrapping_add_signed(*dy),
                columns.wrapping_add_signed(*dx),
            );
            kernel[at] = weight.to_f64();
        }
        kernel
    }
}

/// A register holds no linear map of what went in.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("{}: `{what}` {why}", stands(*line, origin.as_deref()))]
#[diagnostic(help("{}", why.help()))]
pub struct NoTaps {
    /// Line of the program text, from 1.
    pub line: u32,
    /// Which of the words that run it is, from 0.
    pub at: u64,
    /// Where it is written, `file:line`, if that is another file; who has the statements knows.
    pub origin: Option<String>,
    /// The instruction word.
    pub what: String,
    /// Why.
    pub why: Why,
}

fn stands(line: u32, origin: Option<&str>) -> String {
    origin.map_or_else(|| format!("line {line}"), str::to_owned)
}

/// Why a word has no linear result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Why {
    /// Division by a number of targets that is no power of two.
    #[error("splits the bus into parts that are no dyadic rationals")]
    Parts,
    /// The squarer.
    #[error("squares what went in")]
    Square,
    /// A store under a FLAG, or of bits, that are not known beforehand.
    #[error("stores as FLAG or other bits say")]
    Flag,
    /// More than 127 bits.
    #[error("needs more than 127 bits")]
    Bits,
}

impl Why {
    const fn help(self) -> &'static str {
        match self {
            Self::Parts => "divide by two or four",
            Self::Square | Self::Flag => "only straight lines of sums and shares are linear",
            Self::Bits => "scale the program down in fewer steps",
        }
    }
}

/// Why there is no answer for a program or a register.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
pub enum TapsError {
    /// Pixels are not treated alike.
    #[error(transparent)]
    #[diagnostic(transparent)]
    GenericPixel(#[from] GenericError),
    /// The register is not linear in what went in.
    #[error(transparent)]
    #[diagnostic(transparent)]
    NoTaps(#[from] NoTaps),
    /// The chip has no such register.
    #[error("analogue register number {0} is not on this chip")]
    #[diagnostic(help("name one of the chip's registers"))]
    Register(u8),
}

/// The kernel that `steps` leave in `register`.
///
/// Light, and what every register held beforehand, are the inputs.
///
/// # Errors
/// When pixels are not treated alike, or the register is not linear in the inputs.
pub fn read(
    steps: &[Step],
    device: &Device,
    settings: Settings,
    register: Analog,
) -> Result<Taps, TapsError> {
    let mut all = read_all(steps, device, settings)?;
    if usize::from(register.0) >= all.len() {
        return Err(TapsError::Register(register.0));
    }
    Ok(all.swap_remove(register.0.into())?)
}

/// How many words so many steps run that [`NoTaps::at`] counts.
#[must_use]
pub fn words(steps: &[Step]) -> u64 {
    let of = |step: &Step| match &step.action {
        Action::Word(_) | Action::Host(Host::GlobalCount { .. }) => 1,
        Action::Host(_) => 0,
        Action::Repeat { times, body } => u64::from(*times) * words(body),
    };
    steps.iter().map(of).sum()
}

/// The kernel that `steps` leave in each analogue register.
///
/// # Errors
/// When pixels are not treated alike.
pub fn read_all(
    steps: &[Step],
    device: &Device,
    settings: Settings,
) -> Result<Vec<Result<Taps, NoTaps>>, GenericError> {
    let settings = Settings {
        clip: false,
        ..settings
    };
    let mut generic = GenericPixel::new(&Algebra, device, settings, steps)?;
    generic.run(steps, &mut |_, _| {})?;
    let centre = generic.centre();
    let of = |register| match generic.cell(Analog(register)) {
        Ok(form) => Ok(around(form, centre)),
        Err(Lost { step, why }) => {
            let (line, what) = generic
                .words
                .get(*step as usize)
                .cloned()
                .unwrap_or_default();
            Err(NoTaps {
                line,
                at: *step,
                origin: None,
                what,
                why: *why,
            })
        }
    };
    Ok((0..generic.state.layout.analog).map(of).collect())
}

fn around(form: &Form, centre: At) -> Taps {
    let apart = |a: usize, b: usize| a as isize - b as isize;
    let tap = |((input, at), weight): (&(Input, At), &Dyadic)| {
        let place = (*input, apart(at.y, centre.y), apart(at.x, centre.x));
        (place, *weight)
    };
    Taps {
        taps: form.taps.iter().map(tap).collect(),
        constant: form.constant,
    }
}

/// Cells hold linear forms.
#[derive(Clone, Copy, Debug)]
struct Algebra;

/// Where a form was lost.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Lost {
    step: u64,
    why: Why,
}

/// Without a place: too many bits, here and now.
type Sum = Result<Form, Option<Lost>>;

/// What is lost first stays what is lost.
fn plus(sum: &mut Sum, other: Result<&Form, Option<Lost>>, times: i32) {
    if let Ok(form) = sum {
        match other {
            Ok(other) if form.add(other, times).is_some() => {}
            Ok(_) => *sum = Err(None),
            Err(lost) => *sum = Err(lost),
        }
    }
}

impl Domain for Algebra {
    type Cell = Result<Form, Lost>;
    type Sum = Sum;

    fn name(&self) -> String {
        "taps".into()
    }

    fn hold(&self, value: f64) -> Self::Cell {
        let lost = Lost {
            step: 0,
            why: Why::Bits,
        };
        Dyadic::from_f64(value).map(Form::constant).ok_or(lost)
    }

    fn value(&self, cell: &Self::Cell) -> f64 {
        let known = cell.as_ref().ok().and_then(Form::known);
        known.map_or(f64::NAN, Dyadic::to_f64)
    }

    fn nothing(&self) -> Self::Sum {
        Ok(Form::default())
    }

    fn add(&self, sum: &mut Self::Sum, cell: &Self::Cell, times: i32) {
        plus(sum, cell.as_ref().map_err(|lost| Some(*lost)), times);
    }

    fn join(&self, sum: &mut Self::Sum, other: &Self::Sum) {
        plus(sum, other.as_ref().map_err(|lost| *lost), 1);
    }

    fn store(&self, sum: &Self::Sum, share: Share, place: Place) -> Self::Cell {
        let lost = |why| Lost {
            step: place.step,
            why,
        };
        let form = sum.as_ref().map_err(|l| l.unwrap_or(lost(Why::Bits)))?;
        let why = if share.by.is_power_of_two() {
            Why::Bits
        } else {
            Why::Parts
        };
        form.stored(share.by).ok_or(lost(why))
    }

    fn square(&self, sum: &Self::Sum, gain: f64, place: Place) -> Option<Self::Cell> {
        let lost = |why| Lost {
            step: place.step,
            why,
        };
        Some(match sum {
            Err(known) => Err(known.unwrap_or(lost(Why::Bits))),
            Ok(form) => form.known().ok_or(lost(Why::Square)).and_then(|sum| {
                let square = sum.times(sum).zip(Dyadic::from_f64(gain));
                let square = square.and_then(|(square, gain)| square.times(gain));
                square.map(Form::constant).ok_or(lost(Why::Bits))
            }),
        })
    }

    fn positive(&self, sum: &Self::Sum) -> Option<bool> {
        Some(sum.as_ref().ok()?.known()?.to_f64() > 0.0)
    }

    fn limit(&self, cell: Self::Cell, _: (f64, f64)) -> Self::Cell {
        cell
    }
}

impl Symbolic for Algebra {
    fn unknown(&self, input: Input, at: At) -> Self::Cell {
        Ok(Form::input(input, at))
    }

    fn light(&self, settings: &Settings, at: At) -> Self::Cell {
        let mut form = self.hold(settings.reset_level)?;
        let gain = self.hold(settings.gain)?.constant;
        if !gain.is_zero() {
            form.taps.insert((Input::Light, at), gain);
        }
        Ok(form)
    }

    fn either(&self, _: &Self::Cell, new: &Self::Cell, step: u64) -> Self::Cell {
        // What was lost before keeps its own line.
        Err(new.as_ref().err().copied().unwrap_or(Lost {
            step,
            why: Why::Flag,
        }))
    }
}
