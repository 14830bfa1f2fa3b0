//! The program of the kernels of a point in few values.

use crate::{
    compile::{CellKind, DriveMemory, Effort},
    kernel::quantise::{Quantiser, Sum},
    rig::guard::Warning,
    study::{
        design::Compiled,
        sweep::{measurement::refusal::Refusal, points::plan::Entry, study_file::study::Settings},
    },
};

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
    /// Of the kernels of a point, each in the same values, for the thresholds of each.
    ///
    /// # Errors
    /// Why there is none.
    pub fn new(settings: &Settings, entry: &Entry, seed: u64) -> Result<Self, Refusal> {
        let point = &entry.point;
        let device = entry
            .chip
            .as_ref()
            .ok_or_else(|| Refusal::Cannot("there is no chip".to_owned()))?;
        let name = point.word("quantise").unwrap_or("none");
        let to: Option<Quantiser> = match name {
            "none" => None,
            name => Some(name.parse()?),
        };
        let sum = match point.word("sum") {
            Some("zero") => Sum::Zero,
            Some("free") => Sum::Free,
            _ => Sum::Kept,
        };
        let (mut kinds, mut quantisation_error, mut erased) = (Vec::new(), 0.0, Vec::new());
        for (kind, kernel) in entry.kernels.iter().enumerate() {
            let [mut on, mut off, _] = point.threshold(kind);
            let mut levels = kernel.clone();
            if let Some(to) = to {
                let quantised = to.quantise(kernel, sum, seed)?.within_one();
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
            let about = Warning::erased(name, erasure).about.word();
            if !names.contains(&about) {
                names.push(about);
            }
        }
        let memory = point.word("memory").unwrap_or_default();
        let bits = { memory.strip_prefix("bits:") }.and_then(|bits| bits.parse().ok());
        let memory = match bits {
            Some(bits) => DriveMemory::Bits(bits),
            None if memory == "shared" => DriveMemory::Shared,
            None => DriveMemory::Analogue,
        };
        let title = format!("{} as {name}", point.word("kernel").unwrap_or_default());
        let effort = Effort::states(settings.effort);
        let compiled = Compiled::new(&title, (&kinds, memory), device, (effort, 0))?;
        Ok(Self {
            compiled,
            quantisation_error,
            erased: names,
        })
    }
}
