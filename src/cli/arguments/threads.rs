//! On how many threads a verb works (`--threads`).

use std::sync::OnceLock;

use crate::limit::THREADS;

static ASKED: OnceLock<usize> = OnceLock::new();

/// A number of threads, for the command line.
pub fn number(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(0) => Err("a verb works on one thread at least".to_owned()),
        Ok(number) if number <= THREADS => Ok(number),
        Ok(_) => Err(format!("{THREADS} threads at most")),
        Err(_) => Err("give a whole number".to_owned()),
    }
}

/// Starts so many threads for all that follows; without a number as many as the machine has.
pub fn start(number: Option<usize>) -> miette::Result<()> {
    let Some(number) = number else { return Ok(()) };
    let _ = ASKED.set(number);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(number);
    pool.build_global().map_err(|error| {
        miette::miette!(
            help = "ask for fewer with --threads",
            "cannot start {}: {error}",
            crate::unit::counted(number, "thread")
        )
    })
}

/// The number that was asked for.
pub fn asked() -> Option<usize> {
    ASKED.get().copied()
}
