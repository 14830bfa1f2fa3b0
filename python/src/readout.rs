//! A readout, as it is asked for.

use amacrine::event::readout::{Readout, settings::Description};
use pyo3::prelude::*;

use crate::error::raised;

/// Its name, or the path of its file with its text; and settings.
pub type Asked = (String, Option<String>, Vec<(String, String)>);

/// The readout that is asked for.
pub fn open((name, text, settings): Asked) -> PyResult<Readout> {
    let mut description = match text {
        Some(text) => Description::parse(&name, &text),
        None => Description::shipped(&name),
    }
    .map_err(raised)?;
    for (key, value) in settings {
        description.set(&key, &value).map_err(raised)?;
    }
    description.readout().map_err(raised)
}
