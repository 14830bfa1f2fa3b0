//! What the chip makes of kernels.
//!
//! Which program is the best for a kernel hangs on the threshold that its drive is compared with, so
//! a kernel is compiled for a threshold; those within a quarter of an octave share a program.

use std::{
    collections::HashMap,
    sync::{Arc, Mutex, PoisonError},
};

use amacrine::{
    compile::{CellKind, DriveMemory, Effort, FilterNoise, Request, SensorProgram, Signal},
    elementary,
    isa::{Device, Errors, StoreTerms},
    kernel::Kernel,
};

use super::{error::LevelsError, project::Projected};

/// Thresholds in an octave for which a kernel is compiled anew.
const CLASSES: f64 = 4.0;

/// The least and the largest threshold that a program is sought for.
const LEAST: f64 = 0.5;
const MOST: f64 = 255.0;

/// A chip, and what was compiled for it: a kernel is compiled once.
#[derive(Debug)]
pub struct Chip {
    device: Device,
    effort: Effort,
    seed: u64,
    compiled: Mutex<HashMap<Vec<i64>, Arc<OnChip>>>,
}

/// Kernels as the chip computes them.
#[derive(Clone, Debug)]
pub struct OnChip {
    /// The program; its thresholds are placeholders: see [`OnChip::program`].
    sensor: SensorProgram,
    /// The kernels that it was made of.
    pub kernels: Vec<Kernel>,
    /// Words of the filter, for all kinds.
    pub words: usize,
    /// Halvings of the light before the filter.
    pub halvings: u32,
    /// LSB of a drive for each unit of kernel times light, light being 0 to 255.
    pub scale: f64,
    /// The correlation with the exact filter that is predicted on silicon, for light that is
    /// independent from pixel to pixel and uniform over the capture's range; the least of the kinds.
    pub correlation: f64,
    /// What the filter adds to each drive, LSB. Its fixed part is in the drive and in the memory of
    /// it alike.
    pub noise: Vec<FilterNoise>,
}

/// What the memory of a drive leaves between cells, as a standard deviation in LSB: it is written by
/// two stores, through NEWS, and each cell's offset is its own. It shifts what is compared with the
/// thresholds; a filter's own mismatch is in the drive and in the memory of it alike.
#[must_use]
pub fn memory_spread(device: &Device) -> f64 {
    let StoreTerms {
        offset_mismatch,
        // Alike in all cells.
        transfer: _,
        loss: _,
        division: _,
        // In the drive and in the memory of it alike.
        gain_mismatch: _,
        mismatch_correlation: _,
        division_mismatch: _,
        // Another in each frame.
        noise: _,
    } = Errors::from_device(device).of_a_store();
    std::f64::consts::SQRT_2 * offset_mismatch
}

impl Chip {
    /// A chip without anything compiled for it.
    #[must_use]
    pub fn new(device: Device, effort: Effort, seed: u64) -> Self {
        Self {
            device,
            effort,
            seed,
            compiled: Mutex::default(),
        }
    }

    /// Its description.
    #[must_use]
    pub const fn device(&self) -> &Device {
        &self.device
    }

    /// How many sets of kernels were compiled.
    #[must_use]
    pub fn compiled(&self) -> usize {
        self.compiled
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .len()
    }

    /// The filter of these kernels, one for each kind, as a sensor's program has it: the one that
    /// decides best where drives are compared with about this `threshold`, told for kernels of length
    /// 1 ([`Projected::unit`]) and light from 0 to 255.
    ///
    /// # Errors
    /// When there are too few registers or too many words.
    pub fn compile(&self, kinds: &[Projected], threshold: f64) -> Result<Arc<OnChip>, LevelsError> {
        // The program is a function of what is in the key, not of who asked first.
        let octaves = elementary::log2(threshold.clamp(LEAST, MOST));
        let class = (octaves * CLASSES).round();
        let threshold = elementary::pow(2.0, class / CLASSES);
        let key: Vec<i64> = { kinds.iter() }
            .flat_map(|kind| {
                let (height, width) = kind.levels.dim();
                let levels = kind.levels.iter().map(|level| *level as i64);
                [height as i64, width as i64]
                    .into_iter()
                    .chain(levels)
                    .collect::<Vec<_>>()
            })
            .chain([class as i64])
            .collect();
        let known = self
            .compiled
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .get(&key)
            .cloned();
        if let Some(known) = known {
            return Ok(known);
        }
        let made = Arc::new(self.make(kinds, threshold)?);
        let mut compiled = self.compiled.lock().unwrap_or_else(PoisonError::into_inner);
        Ok(Arc::clone(compiled.entry(key).or_insert(made)))
    }

    fn request<'a>(&'a self, kernels: &'a [Kernel]) -> Result<Request<'a>, LevelsError> {
        Ok(Request {
            effort: self.effort,
            seed: self.seed,
            ..Request::new(kernels, &self.device)?
        })
    }

    fn make(&self, kinds: &[Projected], threshold: f64) -> Result<OnChip, LevelsError> {
        let mut cells = Vec::new();
        let mut kernels = Vec::new();
        for kind in kinds {
            let (kernel, power) = kind.kernel()?;
            let own = threshold * kind.norm() / power;
            kernels.push(kernel.clone());
            cells.push(CellKind {
                name: None,
                kernel,
                on: own,
                off: own,
            });
        }
        let request = self.request(&kernels)?;
        let sensor = SensorProgram::new(&cells, DriveMemory::Analogue, "learned", &request)?;
        let noise = sensor.filter.noise(&self.device, FilterNoise::MIDDLE);
        let signal = Signal::from_range((0.0, 2.0 * FilterNoise::MIDDLE - 1.0));
        let forecasts = sensor.filter.forecast(&self.device, &kernels, signal);
        Ok(OnChip {
            correlation: { forecasts.iter() }
                .map(|forecast| forecast.correlation)
                .fold(1.0, f64::min),
            words: sensor.filter.words.len(),
            halvings: sensor.filter.prescale,
            scale: sensor.scale(),
            noise,
            kernels,
            sensor,
        })
    }
}

impl OnChip {
    /// The nearest threshold that the chip can hold, in units of kernel times light: a whole
    /// number of LSB, one at the least.
    #[must_use]
    pub fn threshold(&self, wanted: f64) -> f64 {
        (wanted * self.scale).round().max(1.0) / self.scale
    }

    /// Noise of the light, in its unit and independent from pixel to pixel, that leaves as much
    /// temporal noise in the drive of a kind as the filter does.
    #[must_use]
    pub fn light_noise(&self, kind: usize) -> f64 {
        let norm = self.kernels[kind]
            .weights()
            .iter()
            .map(|w| w * w)
            .sum::<f64>()
            .sqrt();
        self.noise[kind].temporal / (self.scale * norm)
    }

    /// The filter and the sensor round it.
    #[must_use]
    pub const fn sensor(&self) -> &SensorProgram {
        &self.sensor
    }

    /// Source text of the program with these thresholds, ON and OFF for each kind, in units of
    /// kernel times light.
    #[must_use]
    pub fn program(&self, thresholds: &[[f64; 2]], title: &str, chip: &Chip) -> String {
        let kinds: Vec<CellKind> = { self.kernels.iter().zip(thresholds) }
            .map(|(kernel, [on, off])| CellKind {
                name: None,
                kernel: kernel.clone(),
                on: *on,
                off: *off,
            })
            .collect();
        self.sensor.text_with(
            &kinds,
            title,
            chip.device(),
            amacrine::compile::EventReadout::most_slots(chip.device()),
        )
    }
}
