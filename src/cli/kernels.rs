//! Kernels by name or from files: the one door of all verbs.

use std::fs;

use miette::miette;
use ndarray::Array3;
use ndarray_npy::{ReadNpyError, ReadNpyExt, ReadableElement};

use crate::kernel::Kernel;

/// The kernels of a file or of a name, and how many axes they came with.
///
/// # Errors
/// When there is no such file, or it holds no kernel.
pub(super) fn read(name: &str) -> miette::Result<(Vec<Kernel>, usize)> {
    if let Some(kernel) = Kernel::builtin(name) {
        return Ok((vec![kernel], 2));
    }
    let bytes = fs::read(name).map_err(|cause| {
        let known: Vec<_> = Kernel::builtin_names().collect();
        miette!(
            help = format!(
                "give a kernel file (.toml, .npy) or one of {}",
                known.join(", ")
            ),
            "cannot read the kernel {name}: {cause}"
        )
    })?;
    if !bytes.starts_with(b"\x93NUMPY") {
        let kernel = Kernel::from_toml_bytes(&bytes).map_err(|e| miette!("{name}: {e}"))?;
        return Ok((vec![kernel], 2));
    }
    let flat = match Kernel::from_npy(&bytes) {
        Ok(kernel) => return Ok((vec![kernel], 2)),
        Err(error) => error,
    };
    let Some(stack) = stack(&bytes) else {
        return Err(miette!(
            help = "give an array of shape (k,k) or (K,k,k), k odd, of floats or integers",
            "{name}: {flat}"
        ));
    };
    let planes = stack.outer_iter().map(|plane| plane.to_owned());
    let kernels = planes
        .enumerate()
        .map(|(i, plane)| Kernel::new(plane).map_err(|e| miette!("{name}, kernel {i}: {e}")))
        .collect::<miette::Result<Vec<_>>>()?;
    if kernels.is_empty() {
        return Err(miette!("{name}: there is no kernel in it"));
    }
    Ok((kernels, 3))
}

fn stack(bytes: &[u8]) -> Option<Array3<f64>> {
    fn read<T: ReadableElement + Copy>(
        bytes: &[u8],
        weight: impl Fn(T) -> f64,
    ) -> Result<Array3<f64>, ReadNpyError> {
        Ok(Array3::<T>::read_npy(bytes)?.mapv(weight))
    }
    read::<f64>(bytes, |w| w)
        .or_else(|_| read::<f32>(bytes, f64::from))
        .or_else(|_| read::<i64>(bytes, |w| w as f64))
        .or_else(|_| read::<i32>(bytes, f64::from))
        .or_else(|_| read::<i16>(bytes, f64::from))
        .or_else(|_| read::<i8>(bytes, f64::from))
        .or_else(|_| read::<u8>(bytes, f64::from))
        .ok()
}
