//! Threads. Everything is computed in a pool of our own: a worker of a data loader is a fork of the
//! process, in which the threads of any pool that was there before are gone.

use std::{
    mem,
    panic::resume_unwind,
    process,
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicBool, Ordering},
        mpsc::{RecvTimeoutError, channel},
    },
    thread,
    time::Duration,
};

use amacrine::limit::THREADS;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::error::refused;

struct Own {
    process: u32,
    /// As many threads as were asked for; 0 for as many as there are cores.
    threads: usize,
    pool: Arc<ThreadPool>,
}

static POOL: Mutex<Option<Own>> = Mutex::new(None);

/// A pool of so many threads; 0 for as many as there are cores, or `RAYON_NUM_THREADS` says.
fn build(threads: usize) -> PyResult<Arc<ThreadPool>> {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|cause| {
        refused(
            format!("cannot start {threads} threads: {cause}"),
            "ask for fewer",
        )
    })?;
    Ok(Arc::new(pool))
}

/// The threads of this process.
pub fn pool() -> PyResult<Arc<ThreadPool>> {
    let mut own = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    let process = process::id();
    if let Some(there) = own.as_ref().filter(|there| there.process == process) {
        return Ok(Arc::clone(&there.pool));
    }
    // Of the parent, in a fork: a worker of a data loader takes no more than that was told.
    let threads = own.as_ref().map_or(0, |there| there.threads);
    let pool = build(threads)?;
    let new = Own {
        process,
        threads,
        pool: Arc::clone(&pool),
    };
    // The threads of the parent's pool are not here: nobody must wait for them.
    mem::forget(own.replace(new));
    Ok(pool)
}

/// Does it on the pool, with the interpreter released.
pub fn work<T: Send>(py: Python<'_>, what: impl FnOnce() -> T + Send) -> PyResult<T> {
    let pool = pool()?;
    Ok(py.detach(|| pool.install(what)))
}

/// How often it is looked whether the person wants to stop.
pub const LOOK: Duration = Duration::from_millis(50);

/// Does it on a thread of its own, with the interpreter released. Meanwhile this thread looks for
/// signals, such as that of Ctrl-C: on one that raises, `stop` is set, for the work to end by, and
/// what it made is dropped.
pub fn watched<T: Send>(
    py: Python<'_>,
    stop: &AtomicBool,
    what: impl FnOnce() -> T + Send,
) -> PyResult<T> {
    py.detach(|| {
        thread::scope(|scope| {
            // Closed when the work has ended, by a panic too.
            let (open, ended) = channel::<()>();
            let work = scope.spawn(move || {
                let _open = open;
                what()
            });
            let mut asked = Ok(());
            while ended.recv_timeout(LOOK) == Err(RecvTimeoutError::Timeout) {
                if asked.is_ok() {
                    #[expect(
                        clippy::redundant_closure_for_method_calls,
                        reason = "the method is of one lifetime alone"
                    )]
                    let signals = Python::attach(|py| py.check_signals());
                    asked = signals;
                    stop.store(asked.is_err(), Ordering::Relaxed);
                }
            }
            let made = work.join().unwrap_or_else(|panic| resume_unwind(panic));
            asked.map(|()| made)
        })
    })
}

/// Sets the number of threads from now on; 0 for as many as there are cores.
#[pyfunction]
pub fn set_threads(threads: usize) -> PyResult<()> {
    if threads > THREADS {
        let message = format!("{threads} threads, and {THREADS} at most");
        return Err(refused(message, "ask for fewer"));
    }
    let own = Own {
        process: process::id(),
        threads,
        pool: build(threads)?,
    };
    let before = POOL
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
        .replace(own);
    if before
        .as_ref()
        .is_some_and(|it| it.process != process::id())
    {
        mem::forget(before);
    }
    Ok(())
}

/// The number of threads.
#[pyfunction]
pub fn threads() -> PyResult<usize> {
    Ok(pool()?.current_num_threads())
}
