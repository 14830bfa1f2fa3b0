//! A design: one cell with a kernel and a threshold, from which all sensors of a study are made:
//! the float model, and the compiled program on a chip in any arithmetic.
//!
//! ```
//! use amacrine::{
//!     array::{Arithmetic, Settings},
//!     compile::Effort,
//!     isa::Device,
//!     kernel::{Kernel, quantise::{Quantiser, Sum}},
//!     number::Format,
//!     plane::Size,
//!     reference::MemoryRule,
//!     study::design::Design,
//! };
//!
//! let (kernel, device) = (Kernel::builtin("csdvs-3").unwrap(), Device::scamp5());
//! let float = Design {
//!     kernel: &kernel,
//!     threshold: 20.0,
//!     device: &device,
//!     effort: Effort::states(2_000),
//!     seed: 0,
//! };
//! let quantised = float.quantise(Quantiser::TERNARY, Sum::Free)?;
//! let program = float.in_levels(&quantised).compile("ternary")?;
//! let size = Size::new(24, 32);
//! let reference = float.reference(size, MemoryRule::FilteredSnap, Format::F64)?;
//! let chip = program.chip(Arithmetic::Silicon { seed: 0 }, size, program.settings())?;
//! assert_eq!(reference.size(), amacrine::sensor::Sensor::size(&chip));
//! # Ok::<(), amacrine::study::design::DesignError>(())
//! ```

use std::ops::Deref;

use super::expanded::Expanded;
use crate::{
    array::{CaptureError, CodeError, check_capture},
    compile::{
        CellKind, CompileError, DriveMemory, Effort, EventReadout, Request, SensorProgram,
        check_words,
    },
    config::Faults,
    isa::Device,
    kernel::{
        Kernel,
        quantise::{QuantiseError, Quantised, Quantiser, Sum},
    },
    number::Format,
    photoreceptor::{Curve, Response},
    plane::Size,
    reference::{
        Border, Channel, Description, MemoryRule, Noise, PolarityRule, Reference, Refractory,
        RefractoryRule, Threshold,
    },
    sensor::{Sensor, SensorError},
};

/// A cell, and the chip that it may run on.
///
/// The drive is kernel times light (0 to 255), zeros beyond the border. There is no other
/// response, noise or refractory period.
#[derive(Clone, Copy, Debug)]
pub struct Design<'a> {
    /// Its kernel.
    pub kernel: &'a Kernel,
    /// Events of either sign where the drive moved by more than this.
    pub threshold: f64,
    /// The chip.
    pub device: &'a Device,
    /// How long to search for a program.
    pub effort: Effort,
    /// Seed of the search and of stochastic rounding.
    pub seed: u64,
}

/// Why a sensor of a design cannot be made.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum DesignError {
    /// A threshold that no drive can cross, or that every drive does.
    #[error("the threshold is {0}")]
    #[diagnostic(help("give a positive number, in units of kernel times light (0 to 255)"))]
    Threshold(f64),
    /// The kernel cannot be quantised as asked.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Quantise(#[from] QuantiseError),
    /// The compiler finds no program for the chip.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Compile(#[from] CompileError),
    /// The chip's capture leaves something else than the light.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Capture(#[from] CaptureError),
    /// The chip does not take the program that was compiled: a few words more than it stores,
    /// or a threshold beyond what its converter sets.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Program(#[from] Faults),
    /// No sensor of this size.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Sensor(#[from] SensorError),
    /// The array has not what the program names.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Code(#[from] CodeError),
}

impl DesignError {
    /// Whether it is the chip that says no: another kernel, quantiser or chip may do.
    #[must_use]
    pub const fn is_refusal(&self) -> bool {
        matches!(self, Self::Compile(_) | Self::Program(_))
    }
}

/// The float model as a sensor, with signals, weights and memory in a number format.
pub(super) fn float(
    description: Description,
    size: Size,
    seed: u64,
    format: Format,
) -> Result<Box<dyn Sensor + Send>, SensorError> {
    Ok(Reference::in_format(format, description, size, seed)?)
}

/// All kernels in these few values; or why one of them is not to be had in them.
///
/// # Errors
/// When the quantiser is not what says no.
pub fn quantise_all(
    designs: &[Design<'_>],
    to: Quantiser,
    sum: Sum,
) -> Result<Result<Vec<Quantised>, String>, DesignError> {
    let mut all = Vec::new();
    for design in designs {
        match design.quantise(to, sum) {
            Ok(few) => all.push(few),
            Err(error @ DesignError::Quantise(_)) => return Ok(Err(error.to_string())),
            Err(error) => return Err(error),
        }
    }
    Ok(Ok(all))
}

impl<'a> Design<'a> {
    /// Each kernel with its threshold, on one chip, with one effort and seed.
    #[must_use]
    pub fn each(
        kernels: &'a [Kernel],
        thresholds: &[f64],
        device: &'a Device,
        (effort, seed): (Effort, u64),
    ) -> Vec<Self> {
        { kernels.iter().zip(thresholds) }
            .map(|(kernel, threshold)| Self {
                kernel,
                threshold: *threshold,
                device,
                effort,
                seed,
            })
            .collect()
    }

    /// The float model with a memory rule such as `filtered-snap` or `filtered-step`.
    ///
    /// # Errors
    /// When the threshold is not positive.
    pub fn description(&self, memory: MemoryRule) -> Result<Description, DesignError> {
        let threshold = self.checked()?;
        Ok(Description {
            name: "float".to_owned(),
            response: Response {
                curve: Curve::Identity,
                round_f32: false,
            },
            memory,
            shared: false,
            polarity: PolarityRule::Filtered,
            border: Border::Zero,
            refractory: Refractory {
                us: 0.0,
                rule: RefractoryRule::DeadTime,
            },
            noise: Noise::NONE,
            channels: vec![Channel {
                name: None,
                kernels: vec![self.kernel.clone()],
                surrounds: None,
                thresholds: vec![Threshold {
                    on: threshold,
                    off: threshold,
                    sigma: 0.0,
                }],
                memory_kernel: None,
                log_temporal: false,
            }],
        })
    }

    /// The float model as a sensor, its signals, weights and memory in a number format.
    ///
    /// # Errors
    /// When the threshold is not positive, or the size has no addresses.
    pub fn reference(
        &self,
        size: Size,
        memory: MemoryRule,
        format: Format,
    ) -> Result<Box<dyn Sensor + Send>, DesignError> {
        let description = self.description(memory)?;
        Ok(float(description, size, self.seed, format)?)
    }

    /// Its kernel quantised, with levels of at most 1.
    ///
    /// # Errors
    /// When the kernel cannot be quantised as asked.
    pub fn quantise(&self, to: Quantiser, sum: Sum) -> Result<Quantised, DesignError> {
        Ok(to.quantise(self.kernel, sum, self.seed)?.within_one())
    }

    /// The same cell with the levels as its kernel; the threshold absorbs the scale.
    #[must_use]
    pub fn in_levels<'b>(&self, quantised: &'b Quantised) -> Design<'b>
    where
        'a: 'b,
    {
        Design {
            kernel: &quantised.levels,
            threshold: self.threshold / quantised.scale,
            ..*self
        }
    }

    /// The program for the chip: memory `filtered-snap`, one decision a frame. The kernel is
    /// one of levels.
    ///
    /// # Errors
    /// When the threshold is not positive, or there is no program that the chip takes.
    pub fn compile(&self, title: &str) -> Result<Compiled, DesignError> {
        self.compile_with(&[], DriveMemory::Analogue, title)
    }

    /// One program of several cells, its own kind the first; chip, effort and seed are its own.
    ///
    /// # Errors
    /// As [`compile`](Self::compile); and when the chip has not the registers for all of them.
    pub fn compile_with(
        &self,
        others: &[Design<'_>],
        memory: DriveMemory,
        title: &str,
    ) -> Result<Compiled, DesignError> {
        let mut kinds = vec![self.kind()?];
        for other in others {
            kinds.push(other.kind()?);
        }
        let search = (self.effort, self.seed);
        Compiled::new(title, (&kinds, memory), self.device, search)
    }

    /// Its kind of cell.
    pub(super) fn kind(&self) -> Result<CellKind, DesignError> {
        let threshold = self.checked()?;
        Ok(CellKind {
            name: None,
            kernel: self.kernel.clone(),
            on: threshold,
            off: threshold,
        })
    }

    fn checked(&self) -> Result<f64, DesignError> {
        if self.threshold > 0.0 && self.threshold.is_finite() {
            Ok(self.threshold)
        } else {
            Err(DesignError::Threshold(self.threshold))
        }
    }
}

/// A design as a program of a chip.
#[derive(Clone, Debug)]
pub struct Compiled {
    /// Its text, and the filter in it.
    pub program: SensorProgram,
    /// Its text expanded into instruction words, which is what runs.
    pub expanded: Expanded,
}

impl Deref for Compiled {
    type Target = Expanded;

    fn deref(&self) -> &Expanded {
        &self.expanded
    }
}

impl Compiled {
    /// Finds a program of these kinds that remembers in this way, with an effort and a seed of the
    /// search.
    ///
    /// # Errors
    /// When there is no program that the chip takes.
    pub fn new(
        title: &str,
        (kinds, memory): (&[CellKind], DriveMemory),
        device: &Device,
        (effort, seed): (Effort, u64),
    ) -> Result<Self, DesignError> {
        if memory != DriveMemory::Shared {
            check_capture(device)?;
        }
        let first = kinds.first().map(|kind| kind.kernel.clone());
        let kernels: Vec<Kernel> = first.into_iter().collect();
        let mut request = Request::new(&kernels, device)?;
        request.effort = effort;
        request.seed = seed;
        let program = SensorProgram::new(kinds, memory, title, &request)?;
        Self::from_program(title, program, device)
    }

    /// Of a program that was found.
    ///
    /// # Errors
    /// When its text is more than the chip takes.
    pub fn from_program(
        title: &str,
        program: SensorProgram,
        device: &Device,
    ) -> Result<Self, DesignError> {
        let expanded = Expanded::from_text(title, &program.text, device)?;
        Ok(Self { program, expanded })
    }

    /// Of a program that was found, written otherwise: with another readout, say.
    ///
    /// # Errors
    /// When the text is no program, or more than the chip takes.
    pub fn from_text(
        title: &str,
        program: SensorProgram,
        text: &str,
        device: &Device,
    ) -> Result<Self, DesignError> {
        check_words(text, device)?;
        let expanded = Expanded::from_text(title, text, device)?;
        Ok(Self { program, expanded })
    }

    /// Of a program that was found for these kinds, written with another readout.
    ///
    /// # Errors
    /// When there is no room for it in the chip's store.
    pub fn reading(&self, kinds: &[CellKind], readout: EventReadout) -> Result<Self, DesignError> {
        let (title, device) = (&self.title, &self.device);
        let text = self.program.text_with(kinds, title, device, readout);
        Self::from_text(title, self.program.clone(), &text, device)
    }

    /// Analogue registers that the filter holds at a time.
    #[must_use]
    pub fn registers(&self) -> usize {
        let live = &self.program.filter.live;
        live.iter().map(Vec::len).max().unwrap_or(1)
    }
}
