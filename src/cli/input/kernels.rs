//! Kernels by name or from files: the one door of all verbs.

use std::path::Path;

use miette::miette;

use crate::{
    bundled::Kind,
    cli::{
        list::{bundled, meant},
        output::files::Named,
    },
    compile::DriveMemory,
    kernel::{FEWER, Kernel, KernelFileError, SHAPES, wrong_number},
    limit::KERNELS,
    npy,
    reference::Description,
    source,
    study::{
        cells::{self, Studied},
        design::DesignError,
    },
    unit::counted,
};

/// The kinds of cells that a kernel file, an array of kernels or a sensor file states.
pub(in crate::cli) struct Kinds {
    /// What each is called.
    pub names: Vec<String>,
    /// The kernel of each.
    pub kernels: Vec<Kernel>,
    /// The threshold of each, in kernel times light (0 to 255); only of a sensor file.
    pub thresholds: Option<Vec<f64>>,
    /// What a program of several must remember to follow the sensor; only of one sensor file.
    pub memory: Option<DriveMemory>,
    /// In what programs cannot follow sensor files, a sentence each.
    pub notes: Vec<String>,
}

impl Kinds {
    /// Reads them.
    ///
    /// # Errors
    /// When there is no such file, it holds no kernel, or a sensor's kinds are no kernels.
    pub fn read(name: &str) -> miette::Result<Self> {
        if Kernel::builtin(name).is_none() && is_sensor(name) {
            let description = crate::cli::run::read_sensor(Path::new(name))?;
            return Self::of_sensor(name, &description);
        }
        let (kernels, _) = read(name)?;
        Ok(Self {
            names: names(name, kernels.len()),
            kernels,
            thresholds: None,
            memory: None,
            notes: Vec::new(),
        })
    }

    /// Reads several, one after the other; with thresholds where all of them have some.
    ///
    /// # Errors
    /// As [`Kinds::read`].
    pub fn of_all(names: &[Named]) -> miette::Result<Self> {
        let mut all = Self {
            names: Vec::new(),
            kernels: Vec::new(),
            thresholds: Some(Vec::new()),
            memory: None,
            notes: Vec::new(),
        };
        for name in names {
            let own = Self::read(name)?;
            all.names.extend(own.names);
            all.kernels.extend(own.kernels);
            all.notes.extend(own.notes);
            all.memory = own.memory.filter(|_| names.len() == 1);
            all.thresholds =
                { all.thresholds.take().zip(own.thresholds) }.map(|(all, own)| [all, own].concat());
        }
        check_number(all.kernels.len())?;
        Ok(all)
    }

    /// Refuses a kernel of zeros, by its name.
    ///
    /// # Errors
    /// When there is one.
    pub fn check_weights(&self) -> miette::Result<()> {
        let mut all = self.names.iter().zip(&self.kernels);
        match all.find(|(_, kernel)| kernel.is_zero()) {
            Some((name, _)) => Err(miette!(
                help = "give a kernel that sees something: no threshold makes events of this one",
                "{name}: all weights are 0"
            )),
            None => Ok(()),
        }
    }

    /// The threshold of each: those that were given, else those of sensor files.
    ///
    /// # Errors
    /// As [`thresholds`].
    pub fn thresholds(&self, given: &[f64]) -> miette::Result<Option<Vec<f64>>> {
        let given = thresholds(given, self.kernels.len())?;
        Ok(given.or_else(|| self.thresholds.clone()))
    }

    /// The same, for a verb that can find them for a rate of events instead.
    ///
    /// # Errors
    /// As [`thresholds`], and when there are none; `who` needs them.
    pub fn thresholds_or_rate(&self, who: &str, given: &[f64]) -> miette::Result<Vec<f64>> {
        self.thresholds(given)?.ok_or_else(|| {
            miette!(
                help = "give --rate EVENTS, per pixel and second, --threshold T, in kernel times light (0 to 255), or sensor files, which have their own",
                "{who} needs a rate of events, or thresholds"
            )
        })
    }

    fn of_sensor(name: &str, description: &Description) -> miette::Result<Self> {
        let Studied {
            names,
            kernels,
            thresholds,
            memory,
            notes,
        } = cells::studied(name, description)?;
        Ok(Self {
            names,
            kernels,
            thresholds: Some(thresholds),
            memory,
            notes,
        })
    }
}

/// What so many kernels of one file are called.
pub(in crate::cli) fn names(file: &str, kernels: usize) -> Vec<String> {
    match kernels {
        1 => vec![file.to_owned()],
        several => (0..several).map(|i| format!("{file}[{i}]")).collect(),
    }
}

/// A threshold for each of so many kernels, where any were given: one stands for all.
///
/// # Errors
/// When there are neither one nor as many as kernels, or one is no positive number.
pub(in crate::cli) fn thresholds(
    given: &[f64],
    kernels: usize,
) -> miette::Result<Option<Vec<f64>>> {
    let refused = |threshold: &&f64| !(**threshold > 0.0 && threshold.is_finite());
    if let Some(threshold) = given.iter().find(refused) {
        return Err(DesignError::Threshold(*threshold).into());
    }
    match given {
        [] => Ok(None),
        [all] => Ok(Some(vec![*all; kernels])),
        each if each.len() == kernels => Ok(Some(each.to_vec())),
        other => Err(miette!(
            help = "give one --threshold for all kernels, or one for each, in their order",
            "{} for {}",
            counted(other.len(), "threshold"),
            counted(kernels, "kernel")
        )),
    }
}

/// Refuses more kernels, of all files together, than a sensor has kinds of cells.
pub(in crate::cli) fn check_number(kernels: usize) -> miette::Result<()> {
    if kernels <= KERNELS {
        return Ok(());
    }
    Err(miette!(help = FEWER, "{}", wrong_number(kernels)))
}

/// Whether a file is a sensor; or there is none, and a sensor of this name comes with the program.
fn is_sensor(name: &str) -> bool {
    bundled(Kind::Sensor, Path::new(name)).is_some() || is_sensor_file(name)
}

/// Whether a file is a sensor, by what stands in it.
pub(in crate::cli) fn is_sensor_file(name: &str) -> bool {
    let path = Path::new(name);
    // A pipe can be read once.
    if path.extension().is_none_or(|ending| ending != "toml") || !path.is_file() {
        return false;
    }
    source::text(path, "").is_ok_and(|text| Description::is_meant(&text))
}

/// The kernels of a file or of a name, and how many axes they came with.
///
/// # Errors
/// When there is no such file, or it holds no kernel.
pub(in crate::cli) fn read(name: &str) -> miette::Result<(Vec<Kernel>, usize)> {
    if let Some(kernel) = Kernel::builtin(name) {
        return Ok((vec![kernel], 2));
    }
    let known: Vec<_> = Kernel::builtin_names().collect();
    let help = format!(
        "give a kernel file (.toml, .npy) or one of {}",
        known.join(", ")
    );
    let help = meant(Kind::Kernel, Path::new(name), &help);
    let bytes = source::bytes(Path::new(name), &help).map_err(|error| {
        miette!(
            help = error.help,
            "cannot read the kernel {name}: {}",
            error.cause
        )
    })?;
    let says_array = Path::new(name).extension().is_some_and(|it| it == "npy");
    if says_array && !bytes.starts_with(npy::MAGIC) {
        return Err(miette!(
            help = "give a file that numpy.save has written, or a kernel file in TOML",
            "{name}: the name says a numpy array, but the content is something else"
        ));
    }
    if !bytes.starts_with(npy::MAGIC) {
        let kernel = Kernel::from_bytes(name, &bytes).map_err(|e| match e {
            KernelFileError::Wrong(faults) => faults.into(),
            other => miette!(
                help = "a kernel is a file in TOML, or a .npy as numpy.save writes it; a scene goes after --scene",
                "{name}: {other}"
            ),
        })?;
        return Ok((vec![workable(kernel, name)?], 2));
    }
    let Some(several) = Kernel::several_from_npy(name, &bytes) else {
        let kernel = Kernel::from_npy(&bytes);
        let kernel = kernel.map_err(|flat| miette!(help = SHAPES, "{name}: {flat}"))?;
        return Ok((vec![workable(kernel, name)?], 2));
    };
    let several = several.map_err(|(what, help)| miette!(help = help, "{what}"))?;
    let kernels =
        { (0..).zip(several) }.map(|(i, kernel)| workable(kernel, &format!("{name}, kernel {i}")));
    Ok((kernels.collect::<miette::Result<_>>()?, 3))
}

/// A kernel that can be quantised, compiled and fitted, as all verbs that take one do.
fn workable(kernel: Kernel, name: &str) -> miette::Result<Kernel> {
    match kernel.workable() {
        Ok(()) => Ok(kernel),
        Err(error) => Err(miette!(
            help = "multiply the kernel by a number, and the threshold with it",
            "{name}: {error}"
        )),
    }
}
