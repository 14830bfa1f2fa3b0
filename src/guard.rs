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
    caught(work).ok()
}

/// Does the work; what it says where it panics, on this thread.
///
/// # Errors
/// The panic's own words.
pub fn caught<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    let before = GUARDED.replace(true);
    let done = catch_unwind(AssertUnwindSafe(work));
    GUARDED.set(before);
    done.map_err(|payload| {
        let text = payload.downcast_ref::<&str>().map(ToString::to_string);
        let text = text.or_else(|| payload.downcast_ref::<String>().cloned());
        text.unwrap_or_else(|| "without a word".to_owned())
    })
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
        assert_eq!(
            caught(|| panic!("{} of 9", 7)),
            Err::<(), _>("7 of 9".to_owned())
        );
        assert_eq!(caught(|| panic!("one")), Err::<(), _>("one".to_owned()));
        assert!(!is_guarded());
    }
}
