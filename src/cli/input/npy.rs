//! Planes in `.npy` files.

use std::path::Path;

use miette::miette;

use crate::{
    npy::{self, Array, Element},
    plane::{Plane, Size},
    save::save,
    source,
};

/// Reads a plane of any numbers.
pub(in crate::cli) fn read(path: &Path) -> miette::Result<Plane<f64>> {
    let shown = path.display();
    let bytes = source::numbers(path, "give a .npy of shape (H,W), as numpy.save writes it")?;
    let wrong = |what: String| {
        miette!(
            help = "give a .npy of shape (H,W) with real numbers, as numpy.save writes it",
            "{shown}: {what}"
        )
    };
    let array = Array::read(&bytes).map_err(|error| wrong(error.to_string()))?;
    let &[height, width] = array.shape.as_slice() else {
        return Err(wrong(format!(
            "it has shape {:?}; expected two axes, rows and columns",
            array.shape
        )));
    };
    let plane = Plane::from_shape_vec((height, width), array.values);
    let plane = plane.map_err(|error| wrong(error.to_string()))?;
    if plane.is_empty() {
        return Err(miette!(
            help = "a plane has at least one pixel",
            "{shown}: a plane of {}",
            Size::of(&plane)
        ));
    }
    Ok(plane)
}

/// Writes a plane.
pub(in crate::cli) fn write<T: Element>(path: &Path, plane: &Plane<T>) -> miette::Result<()> {
    let (height, width) = plane.dim();
    save(path, |out| {
        npy::write(out, &[height, width], plane.iter().copied())
    })?;
    Ok(())
}
