//! Catches panics of crates that answer some damaged files with one.

use std::{
    cell::Cell,
    panic::{AssertUnwindSafe, catch_unwind},
};

thread_local! {
    static CATCHING: Cell<bool> = const { Cell::new(false) };
}

/// Does the work on this thread; `None` where it panics.
pub fn catch_ok<T>(work: impl FnOnce() -> T) -> Option<T> {
    catch(work).ok()
}

/// Does the work on this thread; the message of the panic where it panics.
///
/// # Errors
/// When the work panics: its message.
pub fn catch<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    let before = CATCHING.replace(true);
    let done = catch_unwind(AssertUnwindSafe(work));
    CATCHING.set(before);
    done.map_err(|payload| {
        let text = payload.downcast_ref::<&str>().map(ToString::to_string);
        let text = text.or_else(|| payload.downcast_ref::<String>().cloned());
        text.unwrap_or_else(|| "without a word".to_owned())
    })
}

/// Whether a panic of this thread would be caught: a panic hook then need not report it.
#[must_use]
pub fn is_catching() -> bool {
    CATCHING.get()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_nothing_and_catching_ends() {
        assert_eq!(catch_ok(|| 7), Some(7));
        assert_eq!(catch_ok(is_catching), Some(true));
        let nested = catch_ok(|| {
            assert_eq!(catch_ok(|| panic!("inside")), None::<()>);
            is_catching()
        });
        assert_eq!(nested, Some(true));
        assert_eq!(
            catch(|| panic!("{} of 9", 7)),
            Err::<(), _>("7 of 9".to_owned())
        );
        assert_eq!(catch(|| panic!("one")), Err::<(), _>("one".to_owned()));
        assert!(!is_catching());
    }
}
