//! The program of a kernel in few values.

use super::{plan::Entry, refusal::Refusal, study::Settings};
use crate::{
    compile::{CellKind, DriveMemory, Effort},
    kernel::{
        Kernel,
        quantise::{Quantiser, Sum},
    },
    rig::guard::Warning,
    study::design::Compiled,
};

/// The program of a kernel in few values.
#[derive(Clone, Debug)]
pub(super) struct LevelProgram {
    pub compiled: Compiled,
    pub quantisation_error: f64,
    /// What the levels have lost of its shape, by the names of the warnings.
    pub erased: Vec<&'static str>,
}

impl LevelProgram {
    /// Of the kernel of a point, for its ON and OFF thresholds.
    ///
    /// # Errors
    /// Why there is none.
    pub fn new(
        settings: &Settings,
        entry: &Entry,
        seed: u64,
        (on, off): (f64, f64),
    ) -> Result<Self, Refusal> {
        let kernel = &entry.kernel;
        let point = &entry.point;
        let device = entry
            .chip
            .as_ref()
            .ok_or_else(|| Refusal::Cannot("there is no chip".to_owned()))?;
        let name = point.word("quantise").unwrap_or("none");
        let (levels, scale, quantisation_error, erased) = if name == "none" {
            (Kernel::clone(kernel), 1.0, 0.0, Vec::new())
        } else {
            let to: Quantiser = name.parse()?;
            let sum = match point.word("sum") {
                Some("zero") => Sum::Zero,
                Some("free") => Sum::Free,
                _ => Sum::Kept,
            };
            let quantised = to.quantise(kernel, sum, seed)?.within_one();
            let error = quantised.relative_error(kernel);
            let erased = { quantised.erasures(kernel).into_iter() }
                .map(|erasure| Warning::erased(name, erasure).about.name())
                .collect();
            (quantised.levels, quantised.scale, error, erased)
        };
        let kind = CellKind {
            name: None,
            kernel: levels,
            on: on / scale,
            off: off / scale,
        };
        let memory = point
            .word("memory")
            .and_then(|word| word.strip_prefix("bits:"));
        let memory = memory.and_then(|bits| bits.parse().ok());
        let memory = memory.map_or(DriveMemory::Analogue, DriveMemory::Bits);
        let title = format!("{} as {name}", point.word("kernel").unwrap_or_default());
        let effort = Effort::states(settings.effort);
        let compiled = Compiled::new(&title, (&[kind], memory), device, (effort, 0))?;
        Ok(Self {
            compiled,
            quantisation_error,
            erased,
        })
    }
}
