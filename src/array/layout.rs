//! How many registers a pixel has, and which of them have a special part.

use crate::{
    isa::{Analog, Device, Operands, Primitive, Roles},
    plane::Size,
};

/// The registers of every pixel, and the size of the array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Size of the array.
    pub size: Size,
    /// Number of analogue registers, NEWS included.
    pub analog: u8,
    /// The one that neighbours can reach.
    pub news: Analog,
    /// Number of one-bit registers.
    pub digital: u8,
    /// Those that the hardware itself reads or writes.
    pub roles: Roles,
}

impl Layout {
    /// The registers of a chip, on an array of this size.
    #[must_use]
    pub fn new(device: &Device, size: Size) -> Self {
        let registers = device.registers();
        Self {
            size,
            analog: registers.analog.len() as u8,
            news: registers.news,
            digital: registers.digital.len() as u8,
            roles: registers.roles,
        }
    }

    /// What a word reads, writes and does to FLAG on this array.
    #[must_use]
    pub fn operands(&self, word: &Primitive) -> Operands {
        word.operands(self.news, self.roles)
    }
}
