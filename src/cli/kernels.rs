//! Kernels by name or from files: the one door of all verbs.

use std::path::Path;

use miette::miette;

use crate::{
    kernel::{Kernel, KernelFileError, NUMPY},
    limit::KERNELS,
    source,
};

/// The kernels of a file or of a name, and how many axes they came with.
///
/// # Errors
/// When there is no such file, or it holds no kernel.
pub(super) fn read(name: &str) -> miette::Result<(Vec<Kernel>, usize)> {
    if let Some(kernel) = Kernel::builtin(name) {
        return Ok((vec![kernel], 2));
    }
    let known: Vec<_> = Kernel::builtin_names().collect();
    let help = format!(
        "give a kernel file (.toml, .npy) or one of {}",
        known.join(", ")
    );
    let bytes = source::bytes(Path::new(name), &help).map_err(|error| {
        miette!(
            help = error.help,
            "cannot read the kernel {name}: {}",
            error.cause
        )
    })?;
    if !bytes.starts_with(NUMPY) {
        let kernel = Kernel::from_bytes(name, &bytes).map_err(|e| match e {
            KernelFileError::Wrong(faults) => faults.into(),
            other => miette!("{name}: {other}"),
        })?;
        return Ok((vec![workable(kernel, name)?], 2));
    }
    let flat = match Kernel::from_npy(&bytes) {
        Ok(kernel) => return Ok((vec![workable(kernel, name)?], 2)),
        Err(error) => error,
    };
    let Some(planes) = Kernel::planes_from_npy(&bytes) else {
        return Err(miette!(
            help = "give an array of shape (k,k) or (K,k,k), k odd, of floats or integers",
            "{name}: {flat}"
        ));
    };
    if planes.is_empty() || planes.len() > KERNELS {
        return Err(miette!(
            help = "give an array of shape (k,k) or (K,k,k), k odd",
            "{name}: {} kernels; 1 to {KERNELS} kernels at most",
            planes.len()
        ));
    }
    let kernels = (0..).zip(planes).map(|(i, plane)| {
        let kernel = Kernel::new(plane).map_err(|e| miette!("{name}, kernel {i}: {e}"))?;
        workable(kernel, &format!("{name}, kernel {i}"))
    });
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
