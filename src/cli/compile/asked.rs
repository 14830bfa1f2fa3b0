//! What is to be compiled.

use std::path::Path;

use miette::miette;

use super::{super::complain, Arguments, Asked};
use crate::{
    compile::DriveMemory,
    kernel::quantise::Quantiser,
    photoreceptor::Curve,
    reference::{Border, MemoryRule, PolarityRule},
    rig::guard::{Guard, Warning},
};

impl Asked {
    pub(super) fn read(arguments: &Arguments) -> miette::Result<Self> {
        Self::as_given(arguments)?.prepared(arguments.to.0, arguments)
    }

    /// The kernels and thresholds as they are, before they are brought to few values.
    pub(super) fn as_given(arguments: &Arguments) -> miette::Result<Self> {
        if let Some(path) = &arguments.sensor {
            return Self::of_sensor(path);
        }
        let mut kernels = Vec::new();
        let mut stacked = arguments.kernels.len() > 1;
        for name in &arguments.kernels {
            let (more, axes) = super::super::kernels::read(name)?;
            kernels.extend(more);
            stacked |= axes == 3;
        }
        if !arguments.filter_only && arguments.threshold.is_none() {
            return Err(miette!(
                help = "give --threshold T or --sensor FILE for a whole program, or --filter-only for the filter alone",
                "a program needs a threshold"
            ));
        }
        let threshold = arguments.threshold.unwrap_or(0.0);
        if !(threshold >= 0.0 && threshold.is_finite()) {
            return Err(miette!(
                help = "give zero or a positive number",
                "the threshold is {threshold}"
            ));
        }
        Ok(Self {
            input: arguments.input,
            thresholds: vec![(threshold, threshold); kernels.len()],
            scales: vec![1.0; kernels.len()],
            kernels,
            warnings: Vec::new(),
            stacked,
            memory: None,
            title: format!(
                "events of {}",
                arguments
                    .kernels
                    .iter()
                    .map(|name| &**name)
                    .collect::<Vec<_>>()
                    .join(", ")
            ),
        })
    }

    pub(super) fn of_sensor(path: &Path) -> miette::Result<Self> {
        let description = super::super::run::read_sensor(path)?;
        let shown = path.display();
        let linear = match description.response.curve {
            Curve::Identity => 1.0,
            Curve::Linear { white } => white,
            Curve::Log { .. } | Curve::LinLog { .. } => {
                return Err(miette!(
                    help = "the chip's photodiode is linear: give a sensor with `response = { linear = 255 }`",
                    "{shown}: its response is not linear"
                ));
            }
        };
        let one = description.channels.len() == 1;
        let memory = match description.memory {
            MemoryRule::FilteredSnap => DriveMemory::Analogue,
            MemoryRule::RawSnap if description.shared || one => DriveMemory::Shared,
            MemoryRule::RawSnap => {
                return Err(miette!(
                    help = "add `shared = true`: one memory of the pixel for all kinds takes one register",
                    "{shown}: each kind has a memory of the pixel, and the pixel has not the registers"
                ));
            }
            MemoryRule::FilteredStep | MemoryRule::AuthorsPixelStep => {
                return Err(miette!(
                    help = "one decision a frame stores what was seen: give a sensor with `memory = \"filtered-snap\"`, or with `memory = \"raw-snap\"` and `shared = true`, which holds any number of kinds",
                    "{shown}: its memory steps"
                ));
            }
        };
        if description.polarity == PolarityRule::Pixel {
            return Err(miette!(
                help = "give a sensor with `polarity = \"filtered\"`",
                "{shown}: its events have the sign of the pixel, those of a compiled program that of the drive"
            ));
        }
        let mut kernels = Vec::new();
        let mut thresholds = Vec::new();
        for channel in &description.channels {
            let ([kernel], [threshold]) = (&channel.kernels[..], &channel.thresholds[..]) else {
                return Err(miette!(
                    help = "give every kind of cell one kernel; all pixels of the array run the same program",
                    "{shown}: a channel has a pattern of kernels"
                ));
            };
            if channel.surrounds.is_some() {
                return Err(miette!(
                    help = "give the channel a kernel; `amacrine mesh fit` tells which kernels a mesh carries",
                    "{shown}: a channel sees through a resistor mesh, which is no program"
                ));
            }
            kernels.push(kernel.clone());
            thresholds.push((threshold.on * linear, threshold.off * linear));
        }
        if description.border == Border::Replicate {
            let note = "replicates the border; off the array the chip sees 0";
            complain(&format!("note: {shown} {note}\n"));
        }
        if description.refractory.us > 0.0 {
            let note =
                "has a refractory period; the program has none, a cell fires once a frame at most";
            complain(&format!("note: {shown} {note}\n"));
        }
        Ok(Self {
            input: None,
            scales: vec![1.0; kernels.len()],
            kernels,
            warnings: Vec::new(),
            stacked: true,
            thresholds,
            memory: Some(memory),
            title: description.name,
        })
    }

    /// With the weights that the program will have; the scale of each kernel goes into its
    /// thresholds.
    pub(super) fn prepared(
        mut self,
        to: Option<Quantiser>,
        arguments: &Arguments,
    ) -> miette::Result<Self> {
        let Some(to) = to else {
            return Ok(self);
        };
        let mut guard = Guard::new();
        for (i, kernel) in self.kernels.iter_mut().enumerate() {
            let quantised = to.quantise(kernel, arguments.sum.into(), arguments.seed)?;
            for erasure in quantised.erasures(kernel) {
                guard.warn(Warning::erased(&to.to_string(), erasure));
            }
            let quantised = if arguments.filter_only {
                quantised
            } else {
                quantised.within_one()
            };
            let scale = quantised.scale;
            (*kernel, self.scales[i]) = (quantised.levels, scale);
            let (on, off) = self.thresholds[i];
            self.thresholds[i] = (on / scale, off / scale);
        }
        self.warnings = guard.warnings();
        Ok(self)
    }
}
