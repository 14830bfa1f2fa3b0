//! The halo of a program: how far the pixels lie that a cell's registers can depend on, however many
//! frames it runs.

use std::collections::BTreeMap;

use crate::{
    isa::{
        Cell, Device, Primitive,
        operands::{Access, FlagEffect, Terminal, Unit, Use},
    },
    program::{Action, Code, Host, Step},
};

/// From where, in rows and columns, what each cell holds may come.
type Reach = BTreeMap<Cell, Around>;

/// The pixels from the first to the last row and column, seen from the pixel itself: there and back
/// is no way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Around {
    rows: (isize, isize),
    columns: (isize, isize),
}

impl Around {
    /// What another pixel sees, so many rows and columns away.
    const fn seen_from(self, (down, right): (isize, isize)) -> Self {
        Self {
            rows: (self.rows.0 + down, self.rows.1 + down),
            columns: (self.columns.0 + right, self.columns.1 + right),
        }
    }

    /// All of both.
    fn and(self, other: Self) -> Self {
        let hull = |a: (isize, isize), b: (isize, isize)| (a.0.min(b.0), a.1.max(b.1));
        Self {
            rows: hull(self.rows, other.rows),
            columns: hull(self.columns, other.columns),
        }
    }

    /// The furthest row or column.
    fn far(self) -> usize {
        let ends = [self.rows.0, self.rows.1, self.columns.0, self.columns.1];
        ends.map(isize::unsigned_abs).into_iter().max().unwrap_or(0)
    }
}

/// Further than any program of a tile: no need to go on.
const FAR: usize = 64;

/// The halo of a program on a chip.
///
/// Word by word, what is written comes from where what is read comes from, the way between the two
/// added; what a mask may keep stays where it was from. After each frame the registers hold what
/// they will be read for in the next, so `frame` is gone through until nothing comes from further
/// than before.
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
        let far = body.reach.values().map(|at| at.far()).max().unwrap_or(0);
        if far > FAR {
            break;
        }
        let grown = { body.reach.iter() }.any(|(cell, reach)| {
            before
                .get(cell)
                .is_none_or(|before| reach.and(*before) != *before)
        });
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
                    | Host::ScanEvents { .. } => {}
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
            Terminal::Cell(cell) => self.reach.get(&cell).copied().unwrap_or_default(),
            Terminal::Pix | Terminal::In | Terminal::Select => Around::default(),
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
        let replaces = operands.replaces(self.whole);
        let mut written: Vec<(Cell, Around)> = Vec::new();
        for write in operands.accesses.iter().filter(|a| a.how == Use::Write) {
            let Some(cell) = write.cell() else { continue };
            let read = operands.accesses.iter().filter(|a| match a.how {
                Use::Write => false,
                // Where FLAG is 1 everywhere it says nothing.
                Use::Mask => !replaces,
                Use::Read | Use::Gate => true,
            });
            let seen = read.map(|read| {
                let down = read.offset.0 - write.offset.0;
                let right = read.offset.1 - write.offset.1;
                from(read).seen_from((down, right))
            });
            let mut seen = seen.reduce(Around::and).unwrap_or_default();
            // What is written to a neighbour replaces what it holds at the border too: off the array
            // everything is driven by its edge.
            if !replaces {
                seen = seen.and(self.reach.get(&cell).copied().unwrap_or_default());
            }
            // Several pixels may drive one.
            match written.iter_mut().find(|(known, _)| *known == cell) {
                Some((_, known)) => *known = known.and(seen),
                None => written.push((cell, seen)),
            }
        }
        for (cell, seen) in written {
            self.reach.insert(cell, seen);
        }
        match operands.flag {
            FlagEffect::Keeps => {}
            FlagEffect::Sets => {
                self.whole = true;
                self.reach.insert(Cell::Flag, Around::default());
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
        // There and back is no way: only the end counts.
        assert_eq!(
            frame("get_image(A); movx(B, A, east); movx(B, B, west); movx(B, B, west);"),
            Ok(1)
        );
        assert_eq!(
            frame(
                "get_image(A); movx(B, A, east); movx(C, B, west); movx(C, C, west); add(B, B, C); movx(B, B, north); movx(B, B, south);"
            ),
            Ok(1)
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
