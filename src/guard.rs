//! Work of crates that answer some damaged files with a panic.

use std::{
    cell::Cell,
    panic::{AssertUnwindSafe, catch_unwind},
};

thread_local! {
    static GUARDED: Cell<bool> = const { Cell::new(false) };
}

/// Does the work; `None` where it panics, on this thread.
pub fn guarded<T>(work: impl FnOnce() -> T) -> Option<T> {
    let before = GUARDED.replace(true);
    let done = catch_unwind(AssertUnwindSafe(work));
    GUARDED.set(before);
    done.ok()
}

/// Whether a panic of this thread has an answer: a panic hook then need not tell of it.
#[must_use]
pub fn is_guarded() -> bool {
    GUARDED.get()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_nothing_and_the_guard_ends() {
        assert_eq!(guarded(|| 7), Some(7));
        assert_eq!(guarded(is_guarded), Some(true));
        let nested = guarded(|| {
            assert_eq!(guarded(|| panic!("inside")), None::<()>);
            is_guarded()
        });
        assert_eq!(nested, Some(true));
        assert!(!is_guarded());
    }
}
