//! Whose turn it is.

use std::sync::atomic::{AtomicBool, Ordering};

use pyo3::prelude::*;

use crate::error::refused;

/// The turn of a thread to show a stream frames: a second one is refused, for which of the frames come
/// first, nobody has said. It is taken and given back in one call, so that Ctrl-C cannot leave it taken.
#[pyclass(frozen, module = "amacrine._amacrine")]
#[derive(Default)]
pub struct Turn(AtomicBool);

/// Gives a turn back.
struct Back<'a>(&'a AtomicBool);

impl Drop for Back<'_> {
    fn drop(&mut self) {
        self.0.store(false, Ordering::Release);
    }
}

#[pymethods]
impl Turn {
    #[new]
    fn new() -> Self {
        Self::default()
    }

    /// Calls `what`, unless somebody is in it already.
    fn take<'py>(&self, what: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        if self.0.swap(true, Ordering::Acquire) {
            return Err(refused(
                "another thread is in this stream: frames come one after the other",
                "call it from one thread at a time, or give each thread a stream of its own",
            ));
        }
        let _back = Back(&self.0);
        what.call0()
    }
}
