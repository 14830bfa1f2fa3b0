//! The time of a thread.

/// Seconds that the calling thread has had a processor: what others do on the machine does not count.
/// Where the system does not tell, seconds of the wall clock.
pub fn thread_seconds() -> f64 {
    #[cfg(unix)]
    {
        use rustix::time::{ClockId, clock_gettime};
        let had = clock_gettime(ClockId::ThreadCPUTime);
        had.tv_sec as f64 + had.tv_nsec as f64 * 1e-9
    }
    #[cfg(not(unix))]
    {
        use std::{sync::OnceLock, time::Instant};
        static BEGIN: OnceLock<Instant> = OnceLock::new();
        BEGIN.get_or_init(Instant::now).elapsed().as_secs_f64()
    }
}
