//! What a run will hold, worked out before it begins, and what the machine has.
//!
//! A [`Need`] is a sum of named parts, each bytes; a [`Budget`] says how many there may be. What
//! does not fit is refused with the sum, so that it is seen which part is too large.

use crate::order::Order;

use std::{fmt, fs, str::FromStr};

/// Bytes where the system does not say what it has: 4 GiB.
const ASSUMED: u64 = 4 << 30;

/// Bytes, shown in the largest unit (powers of 1024) in which they are at least 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Bytes(pub u128);

impl fmt::Display for Bytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let units = [("TiB", 40), ("GiB", 30), ("MiB", 20), ("KiB", 10)];
        match units.into_iter().find(|(_, power)| self.0 >> power > 0) {
            Some((unit, power)) => {
                let value = self.0 as f64 / (1_u64 << power) as f64;
                let digits = usize::from(value < 99.95);
                write!(f, "{value:.digits$} {unit}")
            }
            None => write!(f, "{} B", self.0),
        }
    }
}

/// How many bytes a run may hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Budget {
    /// The limit, in bytes.
    pub bytes: u64,
    /// Where the limit comes from.
    pub by: Origin,
}

/// Where the limit of a [`Budget`] comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// The user.
    Asked,
    /// Three quarters of what the machine has, or its group of processes may take.
    Machine,
    /// Nobody: three quarters of [4 GiB](Budget::from_machine).
    Assumed,
}

impl Budget {
    /// A limit that the user gave.
    #[must_use]
    pub const fn asked(bytes: u64) -> Self {
        Self {
            bytes,
            by: Origin::Asked,
        }
    }

    /// Three quarters of what the machine has, or of what this process's control group may take
    /// where that is less; of 4 GiB where the system says neither.
    #[must_use]
    pub fn from_machine() -> Self {
        let (bytes, by) = match of_machine() {
            Some(bytes) => (bytes, Origin::Machine),
            None => (ASSUMED, Origin::Assumed),
        };
        let bytes = bytes - bytes / 4;
        Self { bytes, by }
    }
}

/// What the machine has, or this process's control group may take where that is less.
#[cfg(target_os = "linux")]
fn of_machine() -> Option<u64> {
    let read = |path: &str| fs::read_to_string(path).ok();
    let machine = read("/proc/meminfo").and_then(|text| of_system(&text, "MemTotal:"));
    let groups = read("/proc/self/cgroup").unwrap_or_default();
    let group = limits(&groups)
        .iter()
        .filter_map(|path| read(path)?.trim().parse().ok())
        .min();
    machine.into_iter().chain(group).min()
}

/// What the machine has.
#[cfg(not(target_os = "linux"))]
fn of_machine() -> Option<u64> {
    let mut system = sysinfo::System::new().ok()?;
    system.refresh_memory();
    Some(system.total_memory()).filter(|&bytes| bytes > 0)
}

/// The most bytes that this process has held at once, where the system says so.
#[must_use]
pub fn peak() -> Option<u64> {
    of_system(&fs::read_to_string("/proc/self/status").ok()?, "VmHWM:")
}

/// A size in a text of `/proc`, in bytes.
fn of_system(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kibibytes.checked_mul(1024)
}

/// Where the limits of this process's control groups stand, by what `/proc/self/cgroup` says:
/// its own and those above it, of version 2, and what containers see of version 1.
#[cfg(any(target_os = "linux", test))]
fn limits(groups: &str) -> Vec<String> {
    let mut files = vec![
        "/sys/fs/cgroup/memory.max".to_owned(),
        "/sys/fs/cgroup/memory/memory.limit_in_bytes".to_owned(),
    ];
    for line in groups.lines() {
        let Some(own) = line.strip_prefix("0::/") else {
            continue;
        };
        let mut above = String::from("/sys/fs/cgroup");
        for name in own.split('/').filter(|n| !n.is_empty() && *n != "..") {
            above = format!("{above}/{name}");
            files.push(format!("{above}/memory.max"));
        }
    }
    files
}

/// A size that cannot be understood.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is not a size: give bytes, or 500M, 4G (powers of 1024; K M G T)")]
pub struct BadSize(String);

impl FromStr for Budget {
    type Err = BadSize;

    /// `4G`, `1.5G`, `500M`, `64K`, plain bytes; `GiB` and `GB` mean the same as `G`.
    fn from_str(text: &str) -> Result<Self, BadSize> {
        let bad = || BadSize(text.into());
        let upper = text.trim().to_ascii_uppercase();
        let start = upper
            .find(|c: char| c.is_ascii_alphabetic())
            .unwrap_or(upper.len());
        let (number, unit) = upper.split_at(start);
        let power = match unit {
            "" | "B" => 0,
            "K" | "KB" | "KIB" => 10,
            "M" | "MB" | "MIB" => 20,
            "G" | "GB" | "GIB" => 30,
            "T" | "TB" | "TIB" => 40,
            _ => return Err(bad()),
        };
        let number = number.trim();
        let bytes = match number.parse::<u64>() {
            Ok(whole) => whole.checked_mul(1 << power).ok_or_else(bad)?,
            Err(_) if power > 0 => {
                let real: f64 = number.parse().map_err(|_| bad())?;
                let bytes = real * (1_u64 << power) as f64;
                if !(real.is_finite() && (0.0..u64::MAX as f64).contains(&bytes)) {
                    return Err(bad());
                }
                bytes as u64
            }
            Err(_) => return Err(bad()),
        };
        if bytes == 0 {
            return Err(bad());
        }
        Ok(Self::asked(bytes))
    }
}

/// What something will hold, part by part.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Need {
    parts: Vec<(String, u128)>,
}

impl Need {
    /// What every process holds: its code, its stacks, buffers of files.
    pub const PROCESS: u128 = 24 << 20;

    /// The need of the process itself, to which parts are added.
    #[must_use]
    pub fn new() -> Self {
        Self::default().and("the program itself", Self::PROCESS)
    }

    /// Adds a part of `bytes`.
    #[must_use]
    pub fn and(mut self, part: impl Into<String>, bytes: u128) -> Self {
        if bytes > 0 {
            self.parts.push((part.into(), bytes));
        }
        self
    }

    /// All parts together.
    #[must_use]
    pub fn total(&self) -> u128 {
        let add = |sum: u128, (_, bytes): &(String, u128)| sum.saturating_add(*bytes);
        self.parts.iter().fold(0, add)
    }

    /// How much of a budget is left.
    #[must_use]
    pub fn left(&self, budget: Budget) -> u64 {
        let taken = u64::try_from(self.total()).unwrap_or(u64::MAX);
        budget.bytes.saturating_sub(taken)
    }

    /// Refuses what is beyond the budget.
    ///
    /// # Errors
    /// When all parts together are more than the budget; `what` is what was asked for, `help` what
    /// would make it less.
    pub fn within(&self, budget: Budget, what: &str, help: &str) -> Result<(), TooMuch> {
        if self.total() <= u128::from(budget.bytes) {
            return Ok(());
        }
        Err(TooMuch {
            what: what.into(),
            need: self.clone(),
            budget,
            help: help.into(),
        })
    }
}

impl fmt::Display for Need {
    /// The parts, the largest first.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut parts: Vec<_> = self.parts.iter().collect();
        parts.order_by_key(|(_, bytes)| std::cmp::Reverse(*bytes));
        for (n, (part, bytes)) in parts.into_iter().enumerate() {
            let comma = if n > 0 { ", " } else { "" };
            write!(f, "{comma}{part} {}", Bytes(*bytes))?;
        }
        Ok(())
    }
}

/// More memory than there may be.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("{what} would hold {}: {need}; {}", Bytes(need.total()), allowed(*budget))]
#[diagnostic(help(
    "{help}, or allow more with --max-memory SIZE, such as --max-memory {}",
    suggested(need)
))]
pub struct TooMuch {
    /// What was asked for.
    pub what: String,
    /// What it needs.
    pub need: Need,
    /// What there is.
    pub budget: Budget,
    /// What would make it less.
    pub help: String,
}

fn allowed(budget: Budget) -> String {
    let bytes = Bytes(budget.bytes.into());
    match budget.by {
        Origin::Asked => format!("--max-memory allows {bytes}"),
        Origin::Machine => format!("three quarters of this machine's memory are {bytes}"),
        Origin::Assumed => format!("{bytes} are allowed where the system does not say what it has"),
    }
}

/// The need, rounded up to what is easily typed.
fn suggested(need: &Need) -> String {
    let total = need.total();
    if total < 1 << 30 {
        format!("{}M", total.div_ceil(1 << 20))
    } else if total < 10 << 30 {
        let tenths = (10 * total).div_ceil(1 << 30);
        format!("{}.{}G", tenths / 10, tenths % 10)
    } else {
        format!("{}G", total.div_ceil(1 << 30))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_advised_is_enough_and_little_more() {
        for bytes in [
            1,
            5 << 20,
            (1 << 30) - 1,
            1 << 30,
            1_395_864_372,
            9_999_999_999,
            77 << 30,
        ] {
            let need = Need::new().and("it", bytes);
            let advised = suggested(&need).parse::<Budget>().unwrap().bytes;
            let program = need.total();
            assert!(u128::from(advised) >= program, "{bytes}");
            assert!(
                advised as f64 <= 1.1 * program as f64 + f64::from(1 << 20),
                "{bytes}"
            );
        }
    }

    #[test]
    fn sizes_are_read() {
        for (text, bytes) in [
            ("4G", 4 << 30),
            ("1.5G", 3 << 29),
            ("500m", 500 << 20),
            ("64 KiB", 64 << 10),
            ("1T", 1 << 40),
            ("123456", 123_456),
        ] {
            assert_eq!(text.parse(), Ok(Budget::asked(bytes)), "{text}");
        }
        for text in [
            "",
            "0",
            "G",
            "-1G",
            "1.5",
            "4X",
            "1e99G",
            "nanG",
            "infG",
            "99999999T",
            "0K",
        ] {
            assert!(text.parse::<Budget>().is_err(), "{text}");
        }
    }

    #[test]
    fn what_the_system_says_is_read() {
        let meminfo = "MemTotal:       24576000 kB\nMemFree:         1 kB\n";
        let total = |text: &str| of_system(text, "MemTotal:");
        assert_eq!(total(meminfo), Some(24_576_000 * 1024));
        assert_eq!(total("MemFree: 1 kB\n"), None);
        let status = "VmPeak:\t  9000 kB\nVmHWM:\t    5120 kB\nVmRSS:\t  4000 kB\n";
        assert_eq!(of_system(status, "VmHWM:"), Some(5120 * 1024));
        assert_eq!(of_system("VmRSS:\t  4000 kB\n", "VmHWM:"), None);
        let files = limits("0::/a.slice/b.scope\n");
        assert!(files.contains(&"/sys/fs/cgroup/a.slice/memory.max".to_owned()));
        assert!(files.contains(&"/sys/fs/cgroup/a.slice/b.scope/memory.max".to_owned()));
        assert!(Budget::from_machine().bytes > 1 << 26);
    }

    #[test]
    fn what_does_not_fit_is_refused_with_the_sum() {
        let need = Need::new()
            .and("frames", 3 << 30)
            .and("nothing", 0)
            .and("events", 1 << 30);
        let total = (4_u128 << 30) + Need::PROCESS;
        assert_eq!(need.total(), total);
        assert_eq!(need.within(Budget::asked(total as u64), "", ""), Ok(()));
        let error = need.within(
            Budget::asked(total as u64 - 1),
            "a clip of 9x9",
            "make it smaller",
        );
        let error = error.unwrap_err();
        let message = error.to_string();
        let help = miette::Diagnostic::help(&error).unwrap().to_string();
        assert_eq!(
            message,
            "a clip of 9x9 would hold 4.0 GiB: frames 3.0 GiB, events 1.0 GiB, the program itself 24.0 MiB; --max-memory allows 4.0 GiB"
        );
        assert_eq!(
            help,
            "make it smaller, or allow more with --max-memory SIZE, such as --max-memory 4.1G"
        );
        let endless = Need::new().and("a", u128::MAX);
        assert_eq!(endless.total(), u128::MAX);
    }

    #[test]
    fn bytes_are_shown_in_their_unit() {
        for (bytes, shown) in [
            (0, "0 B"),
            (1023, "1023 B"),
            (1024, "1.0 KiB"),
            (300 << 20, "300 MiB"),
        ] {
            assert_eq!(Bytes(bytes).to_string(), shown);
        }
    }
}
