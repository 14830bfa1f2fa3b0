//! From kernels to instruction words.
//!
//! A filter is found backwards, from the kernels to the input: each step takes the last bus
//! word away and puts what it read in place of what it stored. Whatever a bus does in one word
//! is a step: up to four sources, neighbours among them, the sign that turns with every store,
//! halving by two targets. So symmetry, separability, sums along a walk and work shared between
//! kernels are found without being named. A `walk` over the kernel is the plan to beat.
//!
//! ```
//! use amacrine::{compile::{Effort, Request}, isa::Device, kernel::Kernel};
//!
//! let device = Device::scamp5();
//! let kernels = [Kernel::builtin("sobel-x").unwrap()];
//! let mut request = Request::new(&kernels, &device)?;
//! request.effort = Effort { states: 20_000 };
//! let filter = request.filter()?;
//! assert!(filter.words.len() <= 10);
//! # Ok::<(), amacrine::compile::CompileError>(())
//! ```

mod allocate;
mod beam;
mod comb;
mod digit;
mod draft;
mod error;
mod field;
mod noise;
mod plan;
mod route;
mod scale;
mod sensor;
mod separable;
mod snake;
mod solve;
mod walk;

pub use error::CompileError;
pub use noise::Noise;
pub use sensor::{Kind, Memory, SLOTS, SensorProgram, Steps};
pub use snake::snake_words;

use crate::{
    isa::{Analog, Device, Figure, Primitive, Source, Target},
    kernel::Kernel,
};
use allocate::Room;
use field::{Field, Tap};
use plan::Errors;
use solve::{FINE, Job, Limits, Solved, fine};

/// How long to search, in states looked at: the result does not depend on the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Effort {
    /// States.
    pub states: u64,
}

impl Effort {
    /// What two cores of 2024 look at in so many seconds, about.
    #[must_use]
    pub fn seconds(seconds: f64) -> Self {
        Self {
            states: (seconds.clamp(0.0, 1e6) * 400_000.0) as u64,
        }
    }
}

impl Default for Effort {
    fn default() -> Self {
        Self::seconds(3.0)
    }
}

/// Kernels, and what may be used for them.
#[derive(Clone, Debug)]
pub struct Request<'a> {
    /// One for each goal; weights are whole numbers of 2^-12, at most 4096 in size.
    pub kernels: &'a [Kernel],
    /// The chip.
    pub device: &'a Device,
    /// The register in which the input begins.
    pub input: Analog,
    /// The register of each result.
    pub into: Vec<Analog>,
    /// Registers that stay as they are.
    pub keep: Vec<Analog>,
    /// Try to be right up to the border of the array, zeros beyond it.
    pub border: bool,
    /// What the input can be, in LSB; with it, the input is halved first as often as nothing
    /// then saturates.
    pub range: Option<(f64, f64)>,
    /// How long to search.
    pub effort: Effort,
    /// Another seed may find another program.
    pub seed: u64,
}

/// A filter in instruction words.
#[derive(Clone, Debug)]
pub struct Filter {
    /// The words, bus words all.
    pub words: Vec<Primitive>,
    /// The registers that hold a value while each word runs, NEWS left out.
    pub live: Vec<Vec<Analog>>,
    /// Halvings of the input: the results are 2^-prescale of the kernels' sums.
    pub prescale: u32,
    /// Whether it is right up to the border.
    pub border: bool,
    /// For an input of size 1 the largest value that is stored, in size.
    pub peak: f64,
    /// With a range: nothing saturates, the chip's transfer errors included.
    pub holds: bool,
    /// What is left of the transfer error in each result, in errors of one store.
    pub offsets: Vec<f64>,
    /// States looked at.
    pub states: u64,
}

/// Weights are whole numbers of 2^-FRACTION.
const FRACTION: i32 = 12;

/// The largest weight.
const LARGEST: f64 = 4096.0;

/// The longest side of a kernel.
const SIDE: usize = 15;

impl<'a> Request<'a> {
    /// From the first register into the first ones, everything else free to use.
    ///
    /// # Errors
    /// When there are more kernels than registers.
    pub fn new(kernels: &'a [Kernel], device: &'a Device) -> Result<Self, CompileError> {
        let all = ordinary(device);
        let Some(into) = all.get(..kernels.len()) else {
            return Err(CompileError::Registers {
                what: format!("{} kernels", kernels.len()),
                needed: kernels.len(),
                free: all.len(),
            });
        };
        Ok(Self {
            kernels,
            device,
            input: all.first().copied().unwrap_or(Analog(0)),
            into: into.to_vec(),
            keep: Vec::new(),
            border: false,
            range: None,
            effort: Effort::default(),
            seed: 0,
        })
    }

    /// Searches for the filter.
    ///
    /// # Errors
    /// When a weight is not dyadic, or the registers do not suffice.
    pub fn filter(&self) -> Result<Filter, CompileError> {
        let (goals, unit) = goals(self.kernels)?;
        let all: Vec<Analog> = ordinary(self.device)
            .into_iter()
            .filter(|register| !self.keep.contains(register))
            .collect();
        let Some((low, high)) = self.range else {
            let plus = self.solve(&goals, unit, self.input, &all, None)?;
            return Ok(self.finished(&plus, unit, 0, Vec::new()));
        };
        let figure = |figure| self.device.value(figure);
        let mut limits = Limits {
            input: (low, high),
            odd: false,
            errors: Errors {
                transfer: figure(Figure::TransferError),
                division: figure(Figure::DivisionError),
            },
        };
        let plus = self.solve(&goals, unit, self.input, &all, Some(limits))?;
        if !plus.holds {
            // On a chip without errors, at least.
            limits.errors = Errors {
                transfer: 0.0,
                division: 0.0,
            };
        }
        let other = all.iter().copied().find(|r| *r != self.input);
        let (Some(bits), Some(other)) = (halvings(&plus, unit, limits), other) else {
            return Err(CompileError::Range { low, high });
        };
        if bits.is_multiple_of(2) {
            let first = prefix(self.device, self.input, other, bits);
            return Ok(self.finished(&plus, unit, bits, first));
        }
        // Each halving negates, and after an odd number of them the input lies elsewhere.
        let goals: Vec<Field> = goals.iter().map(|goal| goal.times(-1)).collect();
        limits.input = (-high, -low);
        limits.odd = true;
        let mut minus = self.solve(&goals, unit, other, &all, Some(limits))?;
        minus.holds &= plus.holds;
        let Some(bits) = halvings(&minus, unit, limits) else {
            return Err(CompileError::Range { low, high });
        };
        let first = prefix(self.device, self.input, other, bits);
        Ok(self.finished(&minus, unit, bits, first))
    }

    fn solve(
        &self,
        goals: &[Field],
        unit: i64,
        input: Analog,
        all: &[Analog],
        limits: Option<Limits>,
    ) -> Result<Solved, CompileError> {
        let job = Job {
            goals: goals.to_vec(),
            unit,
            room: Room {
                news: self.device.news(),
                input,
                into: self.into.clone(),
                all: all.to_vec(),
            },
            border: self.border,
            seed: self.seed,
            states: self.effort.states,
            limits,
        };
        job.solve().ok_or_else(|| CompileError::Registers {
            what: match goals.len() {
                1 => "one kernel".to_owned(),
                n => format!("{n} kernels"),
            },
            needed: goals.len() + walk::LEAST - 1,
            free: all.len(),
        })
    }

    fn finished(
        &self,
        solved: &Solved,
        unit: i64,
        prescale: u32,
        mut words: Vec<Primitive>,
    ) -> Filter {
        let mut live: Vec<Vec<Analog>> = words
            .iter()
            .map(|word| registers(word, self.device))
            .collect();
        words.extend(solved.allocated.words.iter().cloned());
        for held in &solved.allocated.live {
            live.push(held.iter().map(|(register, _)| *register).collect());
        }
        Filter {
            offsets: offsets(&words, &self.into, self.device),
            words,
            live,
            prescale,
            border: solved.border,
            holds: solved.holds,
            peak: stored(solved, unit)
                .map(|field| field.bounds(-1.0, 1.0).1 / fine(unit))
                .fold(1.0, f64::max),
            states: solved.seen,
        }
    }
}

/// The analogue registers but NEWS.
fn ordinary(device: &Device) -> Vec<Analog> {
    let count = device.registers().analog.len() as u8;
    let all = (0..count).map(Analog);
    all.filter(|register| *register != device.news()).collect()
}

/// The ordinary registers of a word.
fn registers(word: &Primitive, device: &Device) -> Vec<Analog> {
    let Primitive::Bus { targets, sources } = word else {
        return Vec::new();
    };
    let targets = targets.iter().filter_map(|target| match target {
        Target::Register(register) => Some(*register),
        Target::Neighbour(_) => None,
    });
    let sources = sources.iter().filter_map(|source| match source {
        Source::Register(register) => Some(*register),
        Source::Pix | Source::In | Source::Neighbour(_) => None,
    });
    let mut all: Vec<Analog> = targets.chain(sources).collect();
    all.retain(|register| *register != device.news());
    all.sort_unstable();
    all.dedup();
    all
}

/// Halvings to and fro.
fn prefix(device: &Device, from: Analog, other: Analog, bits: u32) -> Vec<Primitive> {
    let ends = [from, other];
    let half = |i: u32| Primitive::Bus {
        targets: vec![
            Target::Register(ends[(i as usize + 1) % 2]),
            Target::Register(device.news()),
        ],
        sources: vec![Source::Register(ends[i as usize % 2])],
    };
    (0..bits).map(half).collect()
}

/// All that a plan stores.
fn stored(solved: &Solved, unit: i64) -> impl Iterator<Item = Field> {
    let trace = solved.plan.trace(unit * FINE);
    trace.into_iter().flat_map(|trace| trace.stored)
}

/// How often the input must be halved for nothing to saturate.
fn halvings(solved: &Solved, unit: i64, limits: Limits) -> Option<u32> {
    let trace = solved.plan.trace(unit * FINE)?;
    limits.halvings(&solved.plan, &trace, unit)
}

/// Transfer errors left in some registers, in errors of one store, when the input has none.
fn offsets(words: &[Primitive], of: &[Analog], device: &Device) -> Vec<f64> {
    let news = usize::from(device.news().0);
    let mut held = vec![0.0; device.registers().analog.len()];
    for word in words {
        let Primitive::Bus { targets, sources } = word else {
            continue;
        };
        let cell = |source: &Source| match source {
            Source::Register(register) => usize::from(register.0),
            Source::Pix | Source::In | Source::Neighbour(_) => news,
        };
        let sum: f64 = sources.iter().filter_map(|s| held.get(cell(s))).sum();
        for target in targets {
            let at = match target {
                Target::Register(register) => usize::from(register.0),
                Target::Neighbour(_) => news,
            };
            if let Some(cell) = held.get_mut(at) {
                *cell = 1.0 - sum / targets.len() as f64;
            }
        }
    }
    let one = |register: &Analog| held.get(usize::from(register.0)).copied();
    of.iter().filter_map(one).collect()
}

/// The kernels in whole numbers of one unit, and the input in that unit.
fn goals(kernels: &[Kernel]) -> Result<(Vec<Field>, i64), CompileError> {
    let mut fraction = 0;
    for (kernel, field) in kernels.iter().enumerate() {
        let (height, width) = field.weights().dim();
        if height.max(width) > SIDE {
            return Err(CompileError::Size {
                kernel,
                height,
                width,
            });
        }
        for ((row, column), &weight) in field.weights().indexed_iter() {
            let whole = |bits: &i32| (weight * 2f64.powi(*bits)).fract() == 0.0;
            let bits = (0..=FRACTION).find(whole);
            let Some(bits) = bits.filter(|_| weight.abs() <= LARGEST) else {
                return Err(CompileError::NotDyadic {
                    kernel,
                    row,
                    column,
                    weight,
                });
            };
            fraction = fraction.max(bits);
        }
    }
    let of = |kernel: &Kernel| {
        let (rows, columns) = kernel.reach();
        let tap = |((y, x), weight): ((usize, usize), &f64)| Tap {
            y: y as i16 - rows as i16,
            x: x as i16 - columns as i16,
            weight: (weight * 2f64.powi(fraction)) as i64,
        };
        Field::of(kernel.weights().indexed_iter().map(tap).collect())
    };
    Ok((kernels.iter().map(of).collect(), 1 << fraction))
}
