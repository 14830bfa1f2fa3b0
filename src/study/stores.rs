//! Looks at what words store in the middle of a frame, where no register at its end tells of it: a sum
//! beyond the range of a register that is halved afterwards.
//!
//! A frame that is looked at runs word by word aside, and then as any other: what a run gives does not
//! depend on who looks. Only stores that can be larger than what they are made of are looked at, and of
//! those only the ones that are calculated with further on: a comparison asks for the sign alone.

use crate::{
    array::{Array, AtEnd},
    event::Packet,
    isa::{
        Analog, Cell, Device,
        operands::{Access, FlagEffect, Operands, Unit},
    },
    program::{Action, CellEffect, Step},
    unit::{Micros, counted},
};

/// The most words and operations of a frame that are looked at.
const WORDS: usize = 2048;

/// The first frames, and then one of eight times as many: a small part of a long run.
const fn is_due(frame: u64) -> bool {
    frame == 0 || frame.is_power_of_two() && frame.ilog2().is_multiple_of(3)
}

/// What was seen between words.
#[derive(Clone, Debug, Default)]
pub(super) struct Stores {
    /// Frames that were looked at.
    frames: u64,
    found: Option<Found>,
}

/// The first word whose stores lie at the end of the range.
#[derive(Clone, Debug)]
struct Found {
    at: AtEnd,
    frame: u64,
    line: u32,
    /// The word.
    text: String,
}

impl Stores {
    /// The next frame, if it is to be looked at: registers end at `ends`, and hold what lies `beyond`
    /// or not.
    pub fn frame(
        &mut self,
        index: u64,
        chip: &mut dyn Array,
        steps: &[Step],
        (ends, beyond): ([f64; 2], bool),
    ) {
        if self.found.is_some() || !is_due(index) {
            return;
        }
        let device = chip.device().clone();
        let (steps, looked) = looked(steps, &device);
        if looked.is_empty() {
            return;
        }
        self.frames += 1;
        let mut packet = Packet::new(chip.size(), chip.channels());
        let mut found = None;
        chip.aside(&mut |chip| {
            let mut from = 0;
            for (to, registers) in &looked {
                let body: Vec<Step> = steps[from..=*to].iter().map(|it| (*it).clone()).collect();
                from = to + 1;
                // What stops here stops the run too, which says so.
                if chip.run_steps(&body, Micros(0), &mut packet).is_err() {
                    return;
                }
                let each = { registers.iter() }
                    .filter_map(|register| AtEnd::of(chip, *register, ends, beyond));
                // What every pixel holds alike is a constant.
                let first = { each }.find(|at| !at.alike);
                if let (Some(at), Action::Word(word)) = (first, &steps[*to].action) {
                    found = Some(Found {
                        at,
                        frame: index,
                        line: steps[*to].line,
                        text: word.text(&device),
                    });
                    return;
                }
            }
        });
        self.found = found;
    }

    /// What was found, and where.
    pub fn found(self) -> Option<(AtEnd, String)> {
        let frames = self.frames;
        let looked = counted(frames, "frame") + if frames == 1 { " was" } else { " were" };
        self.found.map(|it| {
            let Found {
                at,
                frame,
                line,
                text,
            } = it;
            let register = &at.register;
            let place = format!(
                "{register} after line {line}, `{text}`, of frame {frame} ({looked} looked at word by word)"
            );
            (at, place)
        })
    }
}

/// Whether steps have words whose stores are looked at.
pub(super) fn looks(steps: &[Step], device: &Device) -> bool {
    !looked(steps, device).1.is_empty()
}

/// Steps without loops, as many as are looked at, and which of them are, with the registers that they
/// write.
fn looked<'a>(steps: &'a [Step], device: &Device) -> (Vec<&'a Step>, Vec<(usize, Vec<Analog>)>) {
    let mut all = Vec::new();
    unroll(steps, &mut all);
    let mut whole = true;
    let flows = all.iter().map(|step| Flow::of(step, device, &mut whole));
    let flows: Vec<Flow> = flows.collect();
    let looked = flows.iter().enumerate().filter(|(at, flow)| {
        flow.grows && !flow.writes.is_empty() && is_used(&flow.writes, &flows[at + 1..])
    });
    let looked = looked.map(|(at, flow)| (at, flow.writes.clone())).collect();
    (all, looked)
}

fn unroll<'a>(steps: &'a [Step], all: &mut Vec<&'a Step>) {
    for step in steps {
        match &step.action {
            Action::Repeat { times, body } => {
                // A body without a word never fills the list.
                let before = all.len();
                for _ in 0..*times {
                    unroll(body, all);
                    if all.len() == before || all.len() >= WORDS {
                        break;
                    }
                }
            }
            Action::Word(_) | Action::Host(_) => all.push(step),
        }
        if all.len() >= WORDS {
            return all.truncate(WORDS);
        }
    }
}

/// How analogue values go through a word, or an operation of the host.
struct Flow {
    reads: Vec<Analog>,
    writes: Vec<Analog>,
    /// What becomes of what it reads.
    does: Does,
    /// Whether nothing is left of what it writes to.
    replaces: bool,
    /// Whether it stores what may be larger than all that it reads.
    grows: bool,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Does {
    /// It is stored as it is, or with the other sign.
    Copies,
    /// Its sign is looked at.
    Compares,
    /// It is summed, divided, diffused, or read out.
    Uses,
}

impl Flow {
    /// Of a step; `whole`: FLAG is 1 in all pixels, as far as is known.
    fn of(step: &Step, device: &Device, whole: &mut bool) -> Self {
        if let Action::Word(word) = &step.action {
            let operands = device.operands(word);
            let flow = Self::of_word(&operands, *whole);
            match operands.flag {
                FlagEffect::Keeps => {}
                FlagEffect::Sets => *whole = true,
                FlagEffect::May => *whole = false,
            }
            return flow;
        }
        let effect = CellEffect::of(std::slice::from_ref(step), device);
        let analog = |cell: Cell| match cell {
            Cell::Analog(register) => Some(register),
            Cell::Digital(_) | Cell::Flag => None,
        };
        Self {
            reads: effect.reads.into_iter().filter_map(analog).collect(),
            writes: effect.writes.into_iter().filter_map(analog).collect(),
            does: Does::Uses,
            replaces: true,
            grows: false,
        }
    }

    fn of_word(operands: &Operands, whole: bool) -> Self {
        let (sources, targets) = (operands.reads().count(), operands.writes().count());
        let writes: Vec<Analog> = operands.writes().filter_map(Access::analog).collect();
        let (does, grows) = match operands.unit {
            Unit::Bus if writes.is_empty() => (Does::Compares, false),
            Unit::Bus if sources <= 1 && targets <= 1 => (Does::Copies, false),
            // The sum is divided by the number of its targets.
            Unit::Bus => (Does::Uses, sources > targets),
            Unit::Squarer => (Does::Uses, true),
            Unit::Idle
            | Unit::Photodiode
            | Unit::Diffusion
            | Unit::Logic
            | Unit::Neighbours
            | Unit::Propagation => (Does::Uses, false),
        };
        Self {
            reads: operands.reads().filter_map(Access::analog).collect(),
            replaces: operands.replaces(whole),
            writes,
            does,
            grows,
        }
    }
}

/// Whether what these registers hold is calculated with in what follows, or a copy of it; what is still
/// held at the end is looked at there.
fn is_used(stored: &[Analog], follows: &[Flow]) -> bool {
    let mut held = stored.to_vec();
    for flow in follows {
        let reads = flow.reads.iter().any(|register| held.contains(register));
        match flow.does {
            Does::Uses if reads => return true,
            Does::Copies if reads => held.extend(&flow.writes),
            _ if flow.replaces => held.retain(|register| !flow.writes.contains(register)),
            Does::Uses | Does::Copies | Does::Compares => {}
        }
        if held.is_empty() {
            return false;
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_that_are_looked_at_become_rare() {
        let due: Vec<u64> = (0..1000).filter(|frame| is_due(*frame)).collect();
        assert_eq!(due, [0, 1, 8, 64, 512]);
    }
}
