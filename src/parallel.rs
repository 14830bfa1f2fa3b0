//! Jobs on all threads, for code that is compiled for many types.
//!
//! A loop of `rayon` is compiled anew for each closure, in some ten functions. This one is compiled
//! once for each type of error: for loops over bands, of each number format and domain.

use rayon::prelude::*;

/// What some thread does.
pub(crate) type Job<'a, E> = Box<dyn FnMut() -> Result<(), E> + Send + 'a>;

/// Does all jobs.
///
/// # Errors
/// One of theirs. Jobs that have not begun by then are left out.
pub(crate) fn all<'a, E: Send>(jobs: impl Iterator<Item = Job<'a, E>>) -> Result<(), E> {
    among_threads(jobs.collect())
}

fn among_threads<E: Send>(mut jobs: Vec<Job<'_, E>>) -> Result<(), E> {
    jobs.par_iter_mut().try_for_each(|job| job())
}
