//! What frames do with the photodiodes: each is one exposure here, whether they are reset or not.

use super::{Action, Step};
use crate::isa::{Device, operands::Unit};

/// Whether frames read the photodiodes, and whether they reset them.
#[derive(Clone, Copy, Debug, Default)]
#[expect(clippy::struct_excessive_bools, reason = "each is a flag of its own")]
pub struct Exposure {
    reads: bool,
    resets: bool,
    /// Whether this frame has reset them so far, and whether the one before left them.
    now: bool,
    left: bool,
    /// Whether a frame read what the one before had left.
    adds: bool,
}

impl Exposure {
    /// As these steps are run in a frame.
    pub fn see(&mut self, steps: &[Step], device: &Device) {
        for step in steps {
            match &step.action {
                Action::Word(word) => {
                    let operands = device.operands(word);
                    let reads = operands.reads_light();
                    self.adds |= reads && self.left && !self.now;
                    self.reads |= reads;
                    let resets = operands.unit == Unit::Photodiode;
                    self.resets |= resets;
                    self.now |= resets;
                }
                Action::Repeat { body, .. } => self.see(body, device),
                Action::Host(_) => {}
            }
        }
    }

    /// The next frame begins.
    pub const fn next_frame(&mut self) {
        self.left = !self.now;
        self.now = false;
    }

    /// Whether any step so far has read them.
    #[must_use]
    pub const fn reads(self) -> bool {
        self.reads
    }

    /// Whether light would add up on the chip, from frame to frame.
    #[must_use]
    pub const fn adds_up(self) -> bool {
        self.adds || self.reads && !self.resets
    }
}
