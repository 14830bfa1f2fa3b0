//! What comes with the package, by name.

use amacrine::{
    bundled::{self, Kind},
    isa::Device,
    reference::Description,
    scene::pattern::{PATTERNS, told},
};
use pyo3::prelude::*;

use crate::error::refused;

/// Kinds of what is no file of one text.
const CHIPS: &str = "chips";
const DRAWN: &str = "patterns";

fn kind(name: &str) -> PyResult<Kind> {
    let found = Kind::ALL.into_iter().find(|kind| kind.folder() == name);
    let known = Kind::ALL.map(Kind::folder).join(", ");
    found.ok_or_else(|| {
        refused(
            format!("there are no {name}"),
            format!("give one of {known}, {CHIPS}, {DRAWN}"),
        )
    })
}

/// The names of all files of a kind, of the chips, or of the patterns.
#[pyfunction]
pub fn names(of: &str) -> PyResult<Vec<&'static str>> {
    Ok(match of {
        CHIPS => Device::shipped().collect(),
        DRAWN => PATTERNS.iter().map(|(name, _)| *name).collect(),
        _ => bundled::all(kind(of)?).map(|file| file.name).collect(),
    })
}

/// What to give instead of a name that is not there: one of this kind that is near, if any, and
/// `otherwise`.
#[pyfunction]
pub fn meant(of: &str, name: &str, otherwise: &str) -> PyResult<String> {
    Ok(bundled::meant(kind(of)?, name, otherwise))
}

/// Whether a text is that of a sensor file.
#[pyfunction]
pub fn is_sensor(text: &str) -> bool {
    Description::is_meant(text)
}

/// The path of a file in the sources, and its text; none where there is no such file. Of a chip, which
/// is a folder, the text of its numbers, of a pattern what it takes.
#[pyfunction]
pub fn text(of: &str, name: &str) -> PyResult<Option<(String, String)>> {
    let text = match of {
        CHIPS => Device::shipped_text(name).map(str::to_owned),
        DRAWN => told::one(name).ok(),
        _ => {
            let file = bundled::find(kind(of)?, name);
            return Ok(file.map(|file| (file.path(), file.text.to_owned())));
        }
    };
    Ok(text.map(|text| (name.to_owned(), text)))
}
