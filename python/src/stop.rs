//! Flags by which work is told that nobody waits for it any longer.

use std::sync::{
    Mutex, PoisonError,
    atomic::{AtomicBool, Ordering},
};

use amacrine::stop::Stop;

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
