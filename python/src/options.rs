//! The options of the command line in the words of Python.

pub use amacrine::advice::in_python;
use amacrine::rig::guard::Warning;
use pyo3::prelude::*;

/// The same for texts that come as JSON.
#[pyfunction]
#[pyo3(name = "in_python")]
pub fn in_words(text: &str) -> String {
    in_python(text)
}

/// Warns whoever called the function of Python that called.
pub fn caution(py: Python<'_>, warning: &Warning) -> PyResult<()> {
    note(py, &warning.to_string())
}

/// The same of what the command line notes.
pub fn note(py: Python<'_>, text: &str) -> PyResult<()> {
    let words = in_python(text);
    py.import("amacrine.caution")?
        .call_method1("caution", (words,))?;
    Ok(())
}
