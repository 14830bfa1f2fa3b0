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
    cell_kind::{CellKind, DriveMemory},
    one_bit_registers::OneBit,
    program::SensorProgram,
    shared_memory::at_a_time,
};
use crate::{
    compile::{
        codegen::register_allocation::ordinary_registers,
        construction::walk,
        error::{CompileError, times_that_fit},
        request::{Effort, Objective, Request},
    },
    isa::{Device, Figure},
    limit::KERNELS,
    unit::counted,
};

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

    /// The most kinds for which a chip has the registers, no more than one program has ([`KERNELS`]).
    #[must_use]
    pub fn most_kinds(memory: DriveMemory, device: &Device) -> usize {
        let fits = |kinds: &usize| Self::new(memory, *kinds, device).fits(device);
        (1..=KERNELS).take_while(fits).count()
    }
}

/// Stored words of a program with a memory of the pixel that are there once, whatever the number of
/// kinds: of kinds that need no filter, one takes 22 words of SCAMP-5's store and sixteen take 171.
const SHARED_WORDS: f64 = 12.0;

/// How many kinds like those of a program the chip carries: its registers, its store and the most
/// kinds of one program ([`KERNELS`]) limit them. The program has so many `kinds` in so many stored
/// `words`.
#[must_use]
pub fn carried(memory: DriveMemory, device: &Device, (kinds, words): (usize, u64)) -> usize {
    let once = match memory {
        DriveMemory::Shared => SHARED_WORDS,
        DriveMemory::Analogue | DriveMemory::Bits(_) => 0.0,
    };
    let each = (words as f64 - once).max(1.0) / kinds.max(1) as f64;
    let by_words = ((device.value(Figure::Store) - once) / each) as usize;
    by_words.min(Need::most_kinds(memory, device))
}

/// So many kinds "like these", in words, and whether it is the most that one program has.
#[must_use]
pub fn like_these(kinds: usize, these: &str) -> String {
    let most = if kinds == KERNELS {
        ", the most of one program"
    } else {
        ""
    };
    format!("{} like {these}{most}", counted(kinds, "kind"))
}

/// What to do about a program that this chip does not take: each way was compiled.
pub(super) fn advice(
    error: CompileError,
    kinds: &[CellKind],
    memory: DriveMemory,
    request: &Request<'_>,
) -> CompileError {
    let is_short_of_bits = matches!(error, CompileError::Levels { .. });
    let own = match &error {
        CompileError::Levels { needed, times, .. } => {
            // Its filter is known, and the same for any number of bits.
            let works = |bits: &DriveMemory| {
                let built = SensorProgram::build(kinds, *bits, "", request);
                built.is_ok_and(|it| !it.is_restless())
            };
            let bits = needed.map(DriveMemory::Bits).filter(works);
            let bits = bits.map(|bits| format!("take more bits (--memory {bits})"));
            let times = times.map(|times| {
                let times = times_that_fit(times);
                format!("take higher thresholds: {times} times these, or more")
            });
            { bits.into_iter().chain(times) }
                .collect::<Vec<_>>()
                .join("; or ")
        }
        CompileError::Store { .. } => {
            "search longer (--effort), or use fewer digits (--to)".to_owned()
        }
        _ => String::new(),
    };
    let is_slow = matches!(error, CompileError::Store { .. }) && weights(kinds) > QUICK;
    error.with_advice(|| {
        if is_slow {
            own
        } else {
            ways(kinds, (memory, is_short_of_bits), request, &own)
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

/// Ways out that were compiled, as a sentence; `own` has those that are known already: where it is
/// bits that are too few, how many would do.
fn ways(
    kinds: &[CellKind],
    (memory, is_short_of_bits): (DriveMemory, bool),
    request: &Request<'_>,
    own: &str,
) -> String {
    let works = |kinds: &[CellKind], memory, device: &Device| {
        // The plans that need no search are there in no time; more effort makes them shorter.
        let quick = Request {
            device,
            effort: Effort::states(0),
            objective: Objective::Words,
            ..request.clone()
        };
        let built = SensorProgram::build(kinds, memory, "", &quick);
        // What fires for ever on the chip is no way out.
        built.is_ok_and(|it| !it.is_restless())
    };
    let mut all = Vec::new();
    if memory != DriveMemory::Shared && works(kinds, DriveMemory::Shared, request.device) {
        all.push(
            "give all kinds one memory of the pixel (--memory shared, which is `raw-snap` with `shared = true`)".to_owned(),
        );
    }
    let most = OneBit::memories(request.device) / kinds.len().max(1);
    let bits = (1..=most as u8).map(DriveMemory::Bits);
    let mut bits = bits.filter(|_| !kinds.is_empty() && !is_short_of_bits);
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
    let larger: Vec<Device> = others
        .filter(|it| room(it) > room(request.device))
        .collect();
    if let Some(other) = larger.iter().find(|other| works(kinds, memory, other)) {
        all.push(format!("try --chip {}", other.name()));
    }
    let shared = |other: &&Device| works(kinds, DriveMemory::Shared, other);
    if all.is_empty()
        && memory != DriveMemory::Shared
        && let Some(other) = larger.iter().find(shared)
    {
        all.push(format!(
            "try --chip {} --memory shared, one memory of the pixel for all kinds",
            other.name()
        ));
    }
    if !own.is_empty() {
        all.push(own.to_owned());
    }
    match all.len() {
        0 => "no program was found without a search for fewer of these kinds, for a larger shipped chip, or with one memory of the pixel (--memory shared): take smaller kernels".to_owned(),
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
        assert_eq!(most(DriveMemory::Analogue), 2);
        assert_eq!(most(DriveMemory::Bits(2)), 3);
        assert_eq!(most(DriveMemory::Bits(5)), 1);
        assert_eq!(most(DriveMemory::Shared), KERNELS);
    }
}
