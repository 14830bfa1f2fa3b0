//! What comes with the package, by name.

use amacrine::{
    bundled::{self, Kind},
    isa::Device,
};
use pyo3::prelude::*;

use crate::error::refused;

fn kind(name: &str) -> PyResult<Kind> {
    let found = Kind::ALL.into_iter().find(|kind| kind.folder() == name);
    let known = Kind::ALL.map(Kind::folder).join(", ");
    found.ok_or_else(|| {
        refused(
            format!("there are no {name}"),
            format!("give one of {known}, chips"),
        )
    })
}

/// The names of all files of a kind, or of the chips.
#[pyfunction]
pub fn names(of: &str) -> PyResult<Vec<&'static str>> {
    if of == "chips" {
        return Ok(Device::shipped().collect());
    }
    Ok(bundled::all(kind(of)?).map(|file| file.name).collect())
}

/// The path of a file in the sources, and its text; none where there is no such file.
#[pyfunction]
pub fn text(of: &str, name: &str) -> PyResult<Option<(String, &'static str)>> {
    let file = bundled::find(kind(of)?, name);
    Ok(file.map(|file| (file.path(), file.text)))
}
