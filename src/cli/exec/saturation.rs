//! Registers at the end of their range after any frame.

use crate::array::{Array, AtBorder};

/// What was seen so far.
pub struct Saturation {
    ends: [f64; 2],
    /// Whether registers hold what lies beyond these ends.
    held: bool,
    frame: u64,
    worst: Vec<Saturated>,
}

/// A register, and the frame after which it was worst.
pub struct Saturated {
    pub worst: AtBorder,
    pub frame: u64,
    /// Whether what lies beyond is held, and would be cut off on the chip.
    pub held: bool,
}

impl Saturation {
    pub const fn new(ends: [f64; 2], held: bool) -> Self {
        Self {
            ends,
            held,
            frame: 0,
            worst: Vec::new(),
        }
    }

    /// Looks at the registers after a frame.
    pub fn frame(&mut self, chip: &dyn Array) {
        let found = if self.held {
            AtBorder::beyond(chip, self.ends)
        } else {
            AtBorder::registers(chip, self.ends)
        };
        for worst in found {
            let (frame, held) = (self.frame, self.held);
            let known = self
                .worst
                .iter_mut()
                .find(|it| it.worst.register == worst.register);
            match known {
                // Of equal ones the last.
                Some(it) if it.worst.pixels > worst.pixels => {}
                Some(it) => *it = Saturated { worst, frame, held },
                None => self.worst.push(Saturated { worst, frame, held }),
            }
        }
        self.frame += 1;
    }

    pub fn end(self) -> Vec<Saturated> {
        self.worst
    }
}
