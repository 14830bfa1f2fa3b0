//! Whose turn it is.

use std::sync::atomic::{AtomicBool, Ordering};

use pyo3::{prelude::*, types::PyTuple};

use crate::error::refused;

/// The turn of a thread to show a stream frames, `with` it: a second one is refused, for which of the
/// frames come first, nobody has said. Ctrl-C finds no moment at which it is taken by nobody.
#[pyclass(frozen, module = "amacrine._amacrine")]
#[derive(Default)]
pub struct Turn(AtomicBool);

#[pymethods]
impl Turn {
    #[new]
    fn new() -> Self {
        Self::default()
    }

    fn __enter__(&self) -> PyResult<()> {
        if self.0.swap(true, Ordering::Acquire) {
            return Err(refused(
                "another thread is in this stream: frames come one after the other",
                "call it from one thread at a time, or give each thread a stream of its own",
            ));
        }
        Ok(())
    }

    #[pyo3(signature = (*_raised))]
    fn __exit__(&self, _raised: &Bound<'_, PyTuple>) {
        self.0.store(false, Ordering::Release);
    }
}
