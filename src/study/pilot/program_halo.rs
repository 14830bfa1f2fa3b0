//! The halo of a program: how far the pixels lie that a cell's registers can depend on, however many
//! frames it runs.

use std::collections::BTreeMap;

use crate::{
    isa::{
        Cell, Device, Primitive,
        operands::{Access, FlagEffect, Mode, Terminal, Unit},
    },
    program::{Action, Code, Host, Step},
};

/// How far, in rows or columns, what each cell holds may come from.
type Reach = BTreeMap<Cell, usize>;

/// Further than any program of a tile: no need to go on.
const FAR: usize = 64;

/// The halo of a program on a chip.
///
/// Word by word, what is written comes from as far as what is read, and the way between the two; what
/// a mask may keep stays as far as it was. After each frame the registers hold what they will be
/// read for in the next, so `frame` is gone through until nothing comes from further than before.
///
/// # Errors
/// Why there is no such distance.
pub fn halo(code: &Code, device: &Device) -> Result<usize, &'static str> {
    let mut body = Body {
        device,
        reach: Reach::new(),
        whole: true,
    };
    body.steps(&code.init)?;
    let started = body.whole;
    let cells = 2 + body.reach.len().max(64);
    for _ in 0..cells {
        let before = body.reach.clone();
        body.whole &= started;
        body.steps(&code.frame)?;
        let far = body.reach.values().copied().max().unwrap_or(0);
        if far > FAR {
            break;
        }
        let grown = { body.reach.iter() }
            .any(|(cell, reach)| before.get(cell).is_none_or(|before| reach > before));
        if !grown && !before.is_empty() {
            return Ok(far);
        }
    }
    Err("what a cell of this program holds comes from further away with every frame")
}

struct Body<'a> {
    device: &'a Device,
    reach: Reach,
    /// Whether FLAG is 1 in all pixels.
    whole: bool,
}

impl Body<'_> {
    fn steps(&mut self, steps: &[Step]) -> Result<(), &'static str> {
        for step in steps {
            match &step.action {
                Action::Word(word) => self.word(word)?,
                Action::Host(host) => match host {
                    Host::LoadIn { .. }
                    | Host::LoadInRaw { .. }
                    | Host::LoadDac { .. }
                    | Host::ScanEvents { .. }
                    | Host::ScanEventsFrom { .. } => {}
                    _ => {
                        return Err(
                            "the host of this program looks at places of the array, or at all of it, and a tile is neither",
                        );
                    }
                },
                Action::Repeat { times, body } => {
                    for _ in 0..(*times).min(2 * FAR as u32) {
                        self.steps(body)?;
                    }
                }
            }
        }
        Ok(())
    }

    fn word(&mut self, word: &Primitive) -> Result<(), &'static str> {
        let operands = self.device.operands(word);
        if operands.unit == Unit::Propagation {
            return Err("a bit that propagates may cross the whole array in one word");
        }
        let from = |access: &Access| match access.terminal {
            Terminal::Cell(cell) => self.reach.get(&cell).copied().unwrap_or(0),
            Terminal::Pix | Terminal::In | Terminal::Select => 0,
        };
        if operands
            .accesses
            .iter()
            .any(|a| a.terminal == Terminal::Select)
        {
            return Err(
                "the program selects pixels by their address, and a tile has other addresses",
            );
        }
        let mut written = Vec::new();
        for write in operands.accesses.iter().filter(|a| a.mode == Mode::Write) {
            let Some(cell) = write.cell() else { continue };
            let read = operands.accesses.iter().filter(|a| a.mode != Mode::Write);
            let far = read.map(|read| {
                let way = |a: isize, b: isize| (a - b).unsigned_abs();
                let down = way(read.offset.0, write.offset.0);
                from(read) + down.max(way(read.offset.1, write.offset.1))
            });
            let mut far = far.max().unwrap_or(0);
            // A pixel at the border may have no neighbour that writes it.
            if write.offset != (0, 0) || !operands.replaces(self.whole) {
                far = far.max(self.reach.get(&cell).copied().unwrap_or(0));
            }
            written.push((cell, far));
        }
        for (cell, far) in written {
            self.reach.insert(cell, far);
        }
        match operands.flag {
            FlagEffect::Keeps => {}
            FlagEffect::Sets => {
                self.whole = true;
                self.reach.insert(Cell::Flag, 0);
            }
            FlagEffect::May => self.whole = false,
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::{Overrides, Program};

    fn of(text: &str) -> Result<usize, &'static str> {
        let device = Device::scamp5();
        let program = Program::parse("halo", text).unwrap();
        let code = program.expand(&device, &Overrides::default()).unwrap().code;
        halo(&code, &device)
    }

    #[test]
    fn halos_are_as_far_as_light_comes_from() {
        let frame = |body: &str| of(&format!("init {{ get_image(A); }}\nframe {{ {body} }}"));
        assert_eq!(frame("get_image(A);"), Ok(0));
        assert_eq!(frame("get_image(A); movx(B, A, east);"), Ok(1));
        assert_eq!(
            frame("get_image(A); movx(B, A, east); movx(B, B, east); add(B, B, A);"),
            Ok(2)
        );
        // What is remembered comes from where it came from.
        assert_eq!(
            frame("get_image(A); sub(C, A, B); movx(B, A, east);"),
            Ok(1)
        );
        // A picture that is moved on with every frame.
        assert!(frame("movx(A, A, east);").is_err());
        // Where the mask keeps it, it stays.
        assert_eq!(
            frame("get_image(A); where(A); mov(B, A); all(); movx(C, B, north);"),
            Ok(1)
        );
    }
}
