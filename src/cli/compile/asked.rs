//! What is to be compiled.

use std::path::Path;

use miette::{WrapErr, miette};

use super::{Aim, Arguments, Asked, Total};
use crate::{
    cli::{
        complain,
        input::kernels::{self, check_number},
    },
    kernel::quantise::Quantiser,
    rig::guard::{Guard, Warning},
    study::cells,
};

impl Asked {
    pub(super) fn read(arguments: &Arguments) -> miette::Result<Self> {
        let asked = Self::as_given(arguments)?.prepared(arguments.to.0, arguments)?;
        Ok(Self {
            objective: arguments.objective,
            ..asked
        })
    }

    /// The kernels and thresholds as they are, before they are brought to few values.
    pub(super) fn as_given(arguments: &Arguments) -> miette::Result<Self> {
        if let Some(path) = &arguments.sensor {
            return Self::of_sensor(path, arguments.to.0.is_none());
        }
        let (mut kernels, mut sources) = (Vec::new(), Vec::new());
        let mut stacked = arguments.kernels.len() > 1;
        for name in &arguments.kernels {
            if kernels::is_sensor_file(name) {
                return Err(miette!(
                    help = format!(
                        "give --sensor {name}, without --threshold and --filter-only: it has thresholds of its own"
                    ),
                    "{name} is a sensor file, not a kernel file"
                ));
            }
            let (more, axes) = crate::cli::input::kernels::read(name)?;
            sources.extend(kernels::names(name, more.len()));
            kernels.extend(more);
            stacked |= axes == 3;
        }
        check_number(kernels.len())?;
        if !arguments.filter_only && arguments.threshold.is_empty() {
            return Err(miette!(
                help = "give --threshold T or --sensor FILE for a whole program, or --filter-only for the filter alone",
                "a program needs a threshold"
            ));
        }
        let thresholds = kernels::thresholds(&arguments.threshold, kernels.len())?
            .unwrap_or_else(|| vec![0.0; kernels.len()]);
        Ok(Self {
            input: arguments.input,
            thresholds: thresholds.into_iter().map(|both| (both, both)).collect(),
            scales: vec![1.0; kernels.len()],
            names: vec![None; kernels.len()],
            sources,
            kernels,
            warnings: Vec::new(),
            stacked,
            memory: None,
            objective: Aim::default(),
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

    /// The kinds of a sensor file; `exact`: with its weights as they are.
    fn of_sensor(path: &Path, exact: bool) -> miette::Result<Self> {
        let description = super::super::run::read_sensor(path)?;
        let shown = path.display().to_string();
        let (memory, cells) = cells::of_program(&shown, &description, exact)?;
        for note in &cells.notes {
            complain(&format!("note: {note}\n"));
        }
        let thresholds = { cells.kinds.iter() }.map(|kind| (kind.on, kind.off));
        Ok(Self {
            input: None,
            scales: vec![1.0; cells.kinds.len()],
            thresholds: thresholds.collect(),
            sources: kernels::names(&shown, cells.kinds.len()),
            names: { cells.kinds.iter() }
                .map(|kind| kind.name.clone())
                .collect(),
            kernels: cells.kinds.into_iter().map(|kind| kind.kernel).collect(),
            warnings: Vec::new(),
            stacked: true,
            memory: Some(memory),
            objective: Aim::default(),
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
            if matches!(arguments.sum, Total::Zero) {
                return Err(miette!(
                    help = "give a quantiser (--to int-5), or leave --sum out",
                    "--sum zero, and exact weights keep the sum that they have"
                ));
            }
            return Ok(self);
        };
        let mut guard = Guard::new();
        for (i, kernel) in self.kernels.iter_mut().enumerate() {
            let quantised = to.quantise(kernel, arguments.sum.into(), arguments.seed);
            let quantised =
                quantised.wrap_err_with(|| format!("{} cannot be {to}", self.sources[i]))?;
            for erasure in quantised.erasures(kernel) {
                let own = match &self.names[i] {
                    Some(name) => format!("{name} as {to}"),
                    None if self.scales.len() > 1 => format!("{} as {to}", self.sources[i]),
                    None => to.to_string(),
                };
                guard.warn(Warning::erased(&own, erasure));
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
