//! Who computed a point: the build, the version of its numerics, the processor.

use serde::{Deserialize, Serialize};

/// The version of the results: of what is measured and how. It is part of every identity.
pub const SCHEMA: u32 = 6;

/// The version of the numerics: two builds of one version compute the same bits from the same
/// point, on any processor that `docs/limits.md` names. It is raised whenever a result may change.
pub const NUMERICS: u32 = 11;

/// Who computed a point.
// In the order of the alphabet: the order in which a checksum takes keys.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// The version of the program.
    pub amacrine: String,
    /// A hash of its sources.
    pub build: String,
    /// The compiler.
    pub compiler: String,
    /// The processor, with the vector instructions that are used of it.
    pub cpu: String,
    /// The version of its numerics.
    pub numerics: u32,
    /// The version of its results.
    pub schema: u32,
    /// What it was compiled for.
    pub target: String,
}

impl Provenance {
    /// This build on this machine.
    #[must_use]
    pub fn here() -> Self {
        Self {
            amacrine: env!("CARGO_PKG_VERSION").to_owned(),
            build: env!("AMACRINE_SOURCES").to_owned(),
            compiler: env!("AMACRINE_COMPILER").to_owned(),
            cpu: cpu(),
            numerics: NUMERICS,
            schema: SCHEMA,
            target: env!("AMACRINE_TARGET").to_owned(),
        }
    }

    /// Whether its numbers are those of this build, by its word.
    #[must_use]
    pub fn same_numbers(&self) -> bool {
        self.amacrine == env!("CARGO_PKG_VERSION")
            && self.numerics == NUMERICS
            && self.schema == SCHEMA
    }
}

/// The processor's name as the system knows it, and its vector instructions.
fn cpu() -> String {
    #[cfg_attr(not(target_arch = "x86_64"), expect(unused_mut))]
    let mut words = vec![model().unwrap_or_else(|| std::env::consts::ARCH.to_owned())];
    #[cfg(target_arch = "x86_64")]
    for (name, has) in [
        ("avx", is_x86_feature_detected!("avx")),
        ("avx2", is_x86_feature_detected!("avx2")),
        ("fma", is_x86_feature_detected!("fma")),
        ("avx512f", is_x86_feature_detected!("avx512f")),
    ] {
        if has {
            words.push(name.to_owned());
        }
    }
    words.join(" ")
}

/// The first processor's name in `/proc/cpuinfo`.
#[cfg(target_os = "linux")]
fn model() -> Option<String> {
    use std::{
        fs::File,
        io::{BufRead, BufReader, Read},
    };
    /// The first processor stands within it.
    const HEAD: u64 = 1 << 16;
    let file = File::open("/proc/cpuinfo").ok()?.take(HEAD);
    let lines = BufReader::new(file).lines().map_while(Result::ok);
    model_of(&lines.collect::<Vec<_>>().join("\n"))
}

#[cfg(not(target_os = "linux"))]
fn model() -> Option<String> {
    let mut system = sysinfo::System::new().ok()?;
    system.refresh_cpu_list(sysinfo::CpuRefreshKind::nothing());
    let name = system.cpus().first()?.brand().trim().to_owned();
    (!name.is_empty()).then_some(name)
}

/// The name in the text of `/proc/cpuinfo`: ARM's have no `model name`, but the numbers of the
/// implementer and the part.
#[cfg(any(target_os = "linux", test))]
fn model_of(text: &str) -> Option<String> {
    let value = |key: &str| {
        let line = text.lines().find(|line| line.starts_with(key))?;
        let (_, value) = line.split_once(':')?;
        Some(value.trim().to_owned())
    };
    value("model name").or_else(|| {
        let (maker, part) = (value("CPU implementer")?, value("CPU part")?);
        Some(format!("{} {maker} {part}", std::env::consts::ARCH))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_processor_has_a_name() {
        let x86 = "processor\t: 0\nmodel\t\t: 17\nmodel name\t: AMD EPYC\nmodel name\t: other\n";
        assert_eq!(model_of(x86).as_deref(), Some("AMD EPYC"));
        let arm = "processor\t: 0\nCPU implementer\t: 0x41\nCPU part\t: 0xd0b\n";
        let wanted = format!("{} 0x41 0xd0b", std::env::consts::ARCH);
        assert_eq!(model_of(arm), Some(wanted));
        assert_eq!(model_of("processor\t: 0\n"), None);
    }
}
