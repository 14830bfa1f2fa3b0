//! Flags by which work is told that nobody waits for it any longer.

use std::sync::{
    Arc, Mutex, PoisonError,
    atomic::{AtomicBool, Ordering},
};

use amacrine::stop::Stop;
use pyo3::prelude::*;

/// Flags of calls that are over, for those that come.
static FREE: Mutex<Vec<&'static AtomicBool>> = Mutex::new(Vec::new());

/// The flag of one call.
pub struct Flag(&'static AtomicBool);

impl Flag {
    pub fn new() -> Self {
        let free = FREE.lock().unwrap_or_else(PoisonError::into_inner).pop();
        Self(free.unwrap_or_else(|| Box::leak(Box::default())))
    }

    /// What sets it.
    pub const fn flag(&self) -> &'static AtomicBool {
        self.0
    }

    /// What looks at it.
    pub const fn stop(&self) -> Stop {
        Stop::when(self.0)
    }
}

impl Drop for Flag {
    fn drop(&mut self) {
        self.0.store(false, Ordering::Relaxed);
        let mut free = FREE.lock().unwrap_or_else(PoisonError::into_inner);
        free.push(self.0);
    }
}

/// The flag of several runs at once, on threads of Python: signals reach its main thread alone.
#[pyclass(frozen, module = "amacrine._amacrine")]
#[derive(Clone, Default)]
pub struct Halt(Arc<AtomicBool>);

impl Halt {
    pub fn is_asked(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

#[pymethods]
impl Halt {
    #[new]
    fn new() -> Self {
        Self::default()
    }

    /// Ends all of them at their next frame.
    fn ask(&self) {
        self.0.store(true, Ordering::Relaxed);
    }
}
