//! What cells lose with time.

use super::{super::RowOps, Chip};
use crate::isa::Digital;

impl<D: RowOps> Chip<D> {
    /// Analogue registers some seconds later.
    pub(super) fn age(&mut self, seconds: f64) {
        for plane in &mut self.state.analog {
            for cell in plane.iter_mut() {
                match self.domain.aged(cell, seconds) {
                    Some(aged) => *cell = aged,
                    None => return,
                }
            }
        }
    }

    /// One-bit registers some seconds later: what was not written for too long reads 0.
    pub(super) fn fade(&mut self, seconds: f64) {
        let Some(retention) = self.domain.retention() else {
            return;
        };
        for (register, idle) in (0..).map(Digital).zip(&mut self.idle) {
            *idle += seconds;
            if *idle > retention {
                let held = |pixel| self.domain.holds(register, pixel, *idle);
                self.state.fade(register, held);
            }
        }
    }

    /// These registers are as new.
    pub(super) fn refresh(&mut self, registers: &[Digital]) {
        for register in registers {
            if let Some(idle) = self.idle.get_mut(usize::from(register.0)) {
                *idle = 0.0;
            }
        }
    }
}
