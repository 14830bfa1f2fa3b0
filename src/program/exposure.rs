//! What frames do with the photodiodes: each is one exposure here, whether they are reset or not.

use super::{Action, Step};
use crate::isa::{
    Device,
    operands::{Terminal, Unit},
};

/// Whether frames read the photodiodes, and whether they reset them.
#[derive(Clone, Copy, Debug, Default)]
pub struct Exposure {
    reads: bool,
    resets: bool,
}

impl Exposure {
    /// As these steps are run in a frame.
    pub fn see(&mut self, steps: &[Step], device: &Device) {
        for step in steps {
            match &step.action {
                Action::Word(word) => {
                    let operands = device.operands(word);
                    self.resets |= operands.unit == Unit::Photodiode;
                    self.reads |= operands.reads().any(|it| it.terminal == Terminal::Pix);
                }
                Action::Repeat { body, .. } => self.see(body, device),
                Action::Host(_) => {}
            }
        }
    }

    /// Whether light would add up on the chip, from frame to frame.
    #[must_use]
    pub const fn adds_up(self) -> bool {
        self.reads && !self.resets
    }
}
