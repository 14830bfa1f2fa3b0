//! The program of the kernels of a point in few values.

use std::sync::Arc;

use crate::{
    compile::{CellKind, DriveMemory, Effort},
    isa::Device,
    kernel::{
        Kernel,
        quantise::{Quantiser, Sum},
    },
    rig::guard::Warning,
    study::{
        design::Compiled,
        sweep::{measurement::refusal::Refusal, points::point::Point},
    },
};

/// All that a program is made of: points that have the same have the same program.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::study::sweep) struct ProgramSpec {
    kinds: Vec<Kind>,
    chip: Chip,
    /// None takes weights as they are.
    quantiser: Option<Quantiser>,
    sum: Sum,
    memory: DriveMemory,
    /// The seed of a rounding by chance; 0 for any other.
    rounding: u64,
    /// States that the search may look at.
    effort: u64,
    /// What its kernels are called.
    name: String,
}

/// A kernel, with the thresholds at which a program is to decide best.
#[derive(Clone, Debug, PartialEq)]
struct Kind {
    kernel: Kernel,
    on: f64,
    off: f64,
}

/// A chip that was opened once for all points that name it.
#[derive(Clone, Debug)]
struct Chip(Arc<Device>);

impl PartialEq for Chip {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl ProgramSpec {
    /// That of an array point.
    ///
    /// # Errors
    /// When there is no such quantiser.
    pub(super) fn of(
        point: &Point,
        kernels: &[Kernel],
        chip: &Arc<Device>,
        effort: u64,
    ) -> Result<Self, Refusal> {
        let quantiser: Option<Quantiser> = match point.word("quantise").unwrap_or("none") {
            "none" => None,
            name => Some(name.parse()?),
        };
        let kinds = kernels.iter().enumerate().map(|(kind, kernel)| {
            let [on, off, _] = point.threshold(kind);
            let kernel = kernel.clone();
            Kind { kernel, on, off }
        });
        let is_random = quantiser.as_ref().is_some_and(Quantiser::is_random);
        let seed = point.whole("seed").unwrap_or(0);
        Ok(Self {
            kinds: kinds.collect(),
            chip: Chip(Arc::clone(chip)),
            quantiser,
            sum: { point.word("sum") }.map_or(Ok(Sum::Kept), str::parse)?,
            memory: { point.word("memory") }.map_or(Ok(DriveMemory::default()), str::parse)?,
            rounding: if is_random { seed } else { 0 },
            effort,
            name: point.word("kernel").unwrap_or_default().to_owned(),
        })
    }
}

/// The program of the kernels of a point in few values.
#[derive(Clone, Debug)]
pub(in crate::study::sweep) struct LevelProgram {
    pub compiled: Compiled,
    /// The largest of its kernels.
    pub quantisation_error: f64,
    /// What the levels have lost of their shape, by the names of the warnings.
    pub erased: Vec<&'static str>,
}

impl LevelProgram {
    /// Of each kernel in the same values, for the thresholds of each.
    ///
    /// # Errors
    /// Why there is none.
    pub fn new(spec: &ProgramSpec) -> Result<Self, Refusal> {
        let ProgramSpec {
            kinds: given,
            chip: Chip(device),
            quantiser,
            sum,
            memory,
            rounding,
            effort,
            name,
        } = spec;
        let to = quantiser.map_or_else(|| "none".to_owned(), |to| to.to_string());
        let (mut kinds, mut quantisation_error, mut erased) = (Vec::new(), 0.0, Vec::new());
        for Kind { kernel, on, off } in given {
            let (mut on, mut off) = (*on, *off);
            let mut levels = kernel.clone();
            if let Some(quantiser) = quantiser {
                let quantised = quantiser.quantise(kernel, *sum, *rounding)?.within_one();
                quantisation_error = f64::max(quantisation_error, quantised.relative_error(kernel));
                erased.extend(quantised.erasures(kernel));
                (on, off) = (on / quantised.scale, off / quantised.scale);
                levels = quantised.levels;
            }
            kinds.push(CellKind {
                name: None,
                kernel: levels,
                on,
                off,
            });
        }
        let mut names = Vec::new();
        for erasure in erased {
            let about = Warning::erased(&to, erasure).about.word();
            if !names.contains(&about) {
                names.push(about);
            }
        }
        let title = format!("{name} as {to}");
        let effort = Effort::states(*effort);
        let compiled = Compiled::new(&title, (&kinds, *memory), device, (effort, 0))?;
        Ok(Self {
            compiled,
            quantisation_error,
            erased: names,
        })
    }
}
