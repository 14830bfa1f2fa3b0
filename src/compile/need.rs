//! What a whole program needs of a pixel's registers, by how it remembers, and what to try where
//! that is not there.
//!
//! For `K` kinds, NEWS left out:
//!
//! | memory | analogue registers | one-bit registers |
//! |---|---|---|
//! | a drive of each kind (`analogue`) | `2 K + 2`: drives, memories, a threshold, a scratch | 2 |
//! | the pixel, for all kinds (`shared`) | 4: the memory, three for filter and comparison; 5 from the sixth kind on, with the light | `2 min(K, 5)`, and 2 (of fewer, as many kinds at a time as there are pairs) |
//! | N bits for each kind (`bits:N`) | `K + 3`: drives, a memory being read, a threshold, a scratch | `N K` of 8, and 5 |
//!
//! A filter with more registers than it needs takes fewer words, so what is free beyond that is
//! used. [`CompileError`] suggests a way out only after it was compiled.

use super::{
    allocate::ordinary_registers,
    cell_kind::{CellKind, DriveMemory},
    error::{CompileError, times_that_fit},
    one_bit::OneBit,
    request::{Effort, Objective, Request},
    sensor::SensorProgram,
    shared_memory::at_a_time,
    walk,
};
use crate::isa::{Device, Figure};

/// One-bit registers of SCAMP-5 that memories may take.
pub const MEMORY_BITS: usize = 8;

/// Registers that a program needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Need {
    /// Analogue registers, NEWS left out.
    pub analogue: usize,
    /// One-bit registers for memories.
    pub bits: usize,
}

impl Need {
    /// Of so many kinds that remember in this way on a chip.
    #[must_use]
    pub fn new(memory: DriveMemory, kinds: usize, device: &Device) -> Self {
        match memory {
            DriveMemory::Analogue => Self {
                analogue: 2 * kinds + 2,
                bits: 0,
            },
            DriveMemory::Shared => Self {
                analogue: 1 + usize::from(kinds > at_a_time(device)) + walk::FEWEST_REGISTERS,
                bits: 0,
            },
            DriveMemory::Bits(bits) => Self {
                analogue: kinds + 3,
                bits: usize::from(bits) * kinds,
            },
        }
    }

    /// Whether a chip has them.
    #[must_use]
    pub fn fits(self, device: &Device) -> bool {
        self.analogue <= Self::free(device) && self.bits <= OneBit::memories(device)
    }

    /// The analogue registers of a chip's pixel, NEWS left out.
    #[must_use]
    pub fn free(device: &Device) -> usize {
        ordinary_registers(device).len()
    }

    /// The most kinds for which a chip has the registers; a shared memory sets no limit, and the
    /// words do (`None`).
    #[must_use]
    pub fn most_kinds(memory: DriveMemory, device: &Device) -> Option<usize> {
        if memory == DriveMemory::Shared {
            return (!Self::new(memory, 1, device).fits(device)).then_some(0);
        }
        let fits = |kinds: &usize| Self::new(memory, *kinds, device).fits(device);
        // Each takes a register at least.
        Some((1..=Self::free(device)).take_while(fits).count())
    }
}

/// How many kinds like those of a program the chip carries: its registers limit kinds with a
/// memory each, its store all. The program has so many `kinds` in so many stored `words`.
#[must_use]
pub fn carried(memory: DriveMemory, device: &Device, (kinds, words): (usize, u64)) -> usize {
    let each = words.max(1) as f64 / kinds.max(1) as f64;
    let by_words = (device.value(Figure::Store) / each) as usize;
    let by_registers = Need::most_kinds(memory, device);
    by_registers.map_or(by_words, |most| most.min(by_words))
}

/// What to do about a program that this chip does not take: each way was compiled.
pub(super) fn advice(
    error: CompileError,
    kinds: &[CellKind],
    memory: DriveMemory,
    request: &Request<'_>,
) -> CompileError {
    let own = match &error {
        CompileError::Levels { times, .. } => {
            let times = times_that_fit(*times);
            format!("take higher thresholds: {times} times these, or more")
        }
        CompileError::Store { .. } => {
            "search longer (--effort), or take fewer digits (--to)".to_owned()
        }
        _ => String::new(),
    };
    let is_slow = matches!(error, CompileError::Store { .. }) && weights(kinds) > QUICK;
    error.with_advice(|| {
        if is_slow {
            own
        } else {
            ways(kinds, memory, request, &own)
        }
    })
}

/// Programs of so many weights are compiled in no time, without a search.
const QUICK: usize = 128;

/// Weights of all kinds that are not 0.
fn weights(kinds: &[CellKind]) -> usize {
    let all = kinds.iter().flat_map(|kind| kind.kernel.weights());
    all.filter(|weight| **weight != 0.0).count()
}

/// Ways out that were compiled, as a sentence; `own` needs no trial.
fn ways(kinds: &[CellKind], memory: DriveMemory, request: &Request<'_>, own: &str) -> String {
    let works = |kinds: &[CellKind], memory, device: &Device| {
        // The plans that need no search are there in no time; more effort makes them shorter.
        let quick = Request {
            device,
            effort: Effort::states(0),
            objective: Objective::Words,
            ..request.clone()
        };
        SensorProgram::build(kinds, memory, "", &quick).is_ok()
    };
    let mut all = Vec::new();
    if memory != DriveMemory::Shared && works(kinds, DriveMemory::Shared, request.device) {
        all.push(
            "give all kinds one memory of the pixel (--memory shared, which is `raw-snap` with `shared = true`)".to_owned(),
        );
    }
    let most = OneBit::memories(request.device) / kinds.len().max(1);
    let bits = (1..=most as u8).map(DriveMemory::Bits);
    let mut bits = bits.filter(|_| !kinds.is_empty());
    if let Some(DriveMemory::Bits(bits)) =
        bits.find(|bits| *bits != memory && works(kinds, *bits, request.device))
    {
        all.push(format!(
            "hold the memories in one-bit registers (--memory bits:{bits})"
        ));
    }
    let fewer = (1..kinds.len()).rev();
    if let Some(count) = { fewer.clone() }.find(|n| works(&kinds[..*n], memory, request.device)) {
        all.push(match count {
            1 => "ask for one kind".to_owned(),
            count => format!("ask for {count} kinds: the first {count} have a program"),
        });
    }
    let others = Device::shipped().filter_map(|name| Device::find(name).ok());
    let room = |device: &Device| (Need::free(device), device.value(Figure::Store) as u64);
    let larger = |other: &Device| room(other) > room(request.device);
    if let Some(other) = { others }.find(|other| larger(other) && works(kinds, memory, other)) {
        all.push(format!("try --chip {}", other.name()));
    }
    if !own.is_empty() {
        all.push(own.to_owned());
    }
    match all.len() {
        0 => "no memory was found that holds these kinds on a shipped chip: take smaller kernels, or fewer of them".to_owned(),
        _ => all.join("; or "),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn registers_of_scamp5_hold_so_many_kinds() {
        let device = Device::scamp5();
        let most = |memory| Need::most_kinds(memory, &device);
        assert_eq!(most(DriveMemory::Analogue), Some(2));
        assert_eq!(most(DriveMemory::Bits(2)), Some(3));
        assert_eq!(most(DriveMemory::Bits(5)), Some(1));
        assert_eq!(most(DriveMemory::Shared), None);
    }
}
