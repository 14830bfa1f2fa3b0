//! What the program has held so far.

/// The most bytes that it has held at once, where the system says so.
pub(super) fn peak() -> Option<usize> {
    of_status(&std::fs::read_to_string("/proc/self/status").ok()?)
}

/// `VmHWM` of `/proc/self/status`.
fn of_status(status: &str) -> Option<usize> {
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: usize = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kibibytes.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::of_status;

    #[test]
    fn the_peak_is_read() {
        let status = "VmPeak:\t  9000 kB\nVmHWM:\t    5120 kB\nVmRSS:\t  4000 kB\n";
        assert_eq!(of_status(status), Some(5120 * 1024));
        assert_eq!(of_status("VmRSS:\t  4000 kB\n"), None);
    }
}
