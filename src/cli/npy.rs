//! Planes in `.npy` files.

use std::{io, path::Path};

use miette::miette;
use ndarray::ArrayView2;
use ndarray_npy::{
    ReadNpyError, ReadNpyExt, ReadableElement, ViewElement, ViewNpyError, ViewNpyExt,
    WritableElement, WriteNpyExt, npy::header::Header,
};

use crate::{
    plane::{Plane, Size},
    save::save,
    source,
};

/// Reads a plane of any numbers.
pub(super) fn read(path: &Path) -> miette::Result<Plane<f64>> {
    fn parsed<T: ReadableElement + ViewElement + Copy>(
        bytes: &[u8],
        number: impl Fn(T) -> f64,
    ) -> Result<Plane<f64>, ReadNpyError> {
        // A view allocates nothing, so that a header can claim what it likes.
        match ArrayView2::<T>::view_npy(bytes) {
            Err(ViewNpyError::LengthOverflow) => return Err(ReadNpyError::LengthOverflow),
            Err(ViewNpyError::MissingBytes(_)) => return Err(ReadNpyError::MissingData),
            _ => {}
        }
        let plane = Plane::<T>::read_npy(bytes)?;
        Ok(plane.map(|value| number(*value)))
    }
    let shown = path.display();
    let help = "give a .npy of shape (H,W), as numpy.save writes it";
    let bytes = source::numbers(path, help)?;
    let bytes = bytes.as_slice();
    source::npy_header(bytes).map_err(|what| miette!(help = help, "{shown}: {what}"))?;
    // The header must agree with the file, before room is made for what it says.
    check_shape(bytes).map_err(|why| {
        miette!(
            help = "give a .npy of shape (H,W) with real numbers, as numpy.save writes it",
            "{shown}: {why}"
        )
    })?;
    let mut result = parsed::<f64>(bytes, |v| v);
    // Every kind of number that numpy saves; which one it is stands in the header.
    macro_rules! or_else {
        ($($kind:ty),*) => {$(
            if let Err(ReadNpyError::WrongDescriptor(_)) = result {
                result = parsed::<$kind>(bytes, |v| v as f64);
            }
        )*};
    }
    or_else!(f32, i64, i32, i16, i8, u64, u32, u16, u8);
    if let Err(ReadNpyError::WrongDescriptor(_)) = result {
        result = parsed::<bool>(bytes, |v| if v { 1.0 } else { 0.0 });
    }
    let plane = result.map_err(|e| {
        miette!(
            help = "give a .npy of shape (H,W) with real numbers, as numpy.save writes it",
            "{shown}: {e}"
        )
    })?;
    if plane.is_empty() {
        return Err(miette!(
            help = "a plane has at least one pixel",
            "{shown}: a plane of {}",
            Size::of(&plane)
        ));
    }
    Ok(plane)
}

/// Whether a header promises no more numbers than there are bytes. What else is wrong with it,
/// its reader says.
fn check_shape(bytes: &[u8]) -> Result<(), String> {
    let Ok(header) = Header::from_reader(&mut &*bytes) else {
        return Ok(());
    };
    let all = header
        .shape
        .iter()
        .try_fold(1_usize, |all, n| all.checked_mul(*n));
    match all {
        Some(all) if all <= bytes.len() => Ok(()),
        _ => Err(format!(
            "its header promises an array of shape {:?}, the file has {} bytes",
            header.shape,
            bytes.len()
        )),
    }
}

/// Writes a plane.
pub(super) fn write<T: WritableElement>(path: &Path, plane: &Plane<T>) -> miette::Result<()> {
    save(path, |out| {
        plane
            .write_npy(out)
            .map_err(|e| io::Error::other(e.to_string()))
    })?;
    Ok(())
}
