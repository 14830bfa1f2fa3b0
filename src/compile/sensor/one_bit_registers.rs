//! The one-bit registers of a chip that whole programs use.

use crate::isa::{Device, Digital};

/// The one-bit registers of a chip that whole programs use: those without a role of the hardware
/// first, and those that enable neighbours, which no program reads from, last. The register that
/// propagation spreads is left alone.
#[derive(Clone, Debug)]
pub(super) struct OneBit {
    /// The ON and the OFF events of one kind.
    pub(super) events: [String; 2],
    /// What a program works with besides.
    pub(super) spare: String,
    /// The mask of propagation: what macros change, too.
    pub(super) scratch: String,
    /// Those that memories may take.
    pub(super) memory: Vec<String>,
}

/// Registers that every program takes: of its events, and the spare one.
const TAKEN: usize = 3;

impl OneBit {
    /// Of a chip, which has six registers with a role at least, four of them others than those of
    /// propagation.
    pub(super) fn of(device: &Device) -> Self {
        let registers = device.registers();
        let roles = registers.roles;
        let all = (0..registers.digital.len() as u8).map(Digital);
        let others = all.filter(|it| *it != roles.mask && *it != roles.propagated);
        let (enabling, free): (Vec<_>, Vec<_>) = others.partition(|it| roles.enable.contains(it));
        let mut names: Vec<String> = { free.iter().chain(&enabling) }
            .map(|it| device.digital_name(*it))
            .collect();
        // The last without a role, so that the others are in the order of their kinds.
        let spare = names.remove(free.len().max(TAKEN) - 1);
        let memory = names.split_off(TAKEN - 1);
        Self {
            events: [names.remove(0), names.remove(0)],
            spare,
            scratch: device.digital_name(roles.mask),
            memory,
        }
    }

    /// How many registers memories may take on a chip.
    pub(super) fn memories(device: &Device) -> usize {
        Self::of(device).memory.len()
    }

    /// So many of the pairs of a kind each that waits for its readout, ON and OFF.
    pub(super) fn pairs(&self, most: usize) -> Vec<[&str; 2]> {
        let [on, off] = &self.events;
        let rest = self.memory.chunks_exact(2).map(|it| [&*it[0], &*it[1]]);
        std::iter::once([&**on, &**off])
            .chain(rest)
            .take(most)
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scamp5_keeps_its_registers() {
        let own = OneBit::of(&Device::scamp5());
        assert_eq!(own.events, ["R5", "R6"]);
        assert_eq!([&*own.spare, &*own.scratch], ["R11", "R0"]);
        let memory = ["R7", "R8", "R9", "R10", "R1", "R2", "R3", "R4"];
        assert_eq!(own.memory, memory);
        assert_eq!(own.pairs(2), [["R5", "R6"], ["R7", "R8"]]);
        assert_eq!(own.pairs(9).len(), 5);
    }
}
