//! Register allocation: values whose live ranges interfere get different registers. The allocator
//! is a backtracking search, since the input and some goals are pinned to registers from the start.

use crate::{
    compile::intermediate::plan::{Plan, Store, Value},
    isa::{Analog, Device, Primitive, Source, Target},
};

/// The analogue registers but NEWS.
pub(in crate::compile) fn ordinary_registers(device: &Device) -> Vec<Analog> {
    let count = device.registers().analog.len() as u8;
    let all = (0..count).map(Analog);
    all.filter(|register| *register != device.news()).collect()
}

/// The register file of a filter: the registers that it may use.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::compile) struct RegisterFile {
    /// The register that neighbours can read.
    pub(in crate::compile) news: Analog,
    /// Where the input begins.
    pub(in crate::compile) input: Analog,
    /// Where each goal ends.
    pub(in crate::compile) into: Vec<Analog>,
    /// All that may be used, those above included.
    pub(in crate::compile) all: Vec<Analog>,
}

/// The words of a plan with registers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::compile) struct Allocated {
    pub(in crate::compile) words: Vec<Primitive>,
    /// For every word, the live registers before it, and the value that each holds.
    pub(in crate::compile) live: Vec<Vec<(Analog, Value)>>,
}

/// Steps of the search before it gives up.
const TRIES: u32 = 20_000;

/// Finds registers; `None` when there are too few.
pub(in crate::compile) fn allocate(plan: &Plan, file: &RegisterFile) -> Option<Allocated> {
    let pinned: Vec<Option<Analog>> = file.into.iter().copied().map(Some).collect();
    assign_all(plan, file, &pinned).or_else(|| {
        // The goal over the input elsewhere, and brought there last.
        let over = file.into.iter().position(|r| *r == file.input)?;
        let mut pinned = pinned;
        pinned[over] = None;
        assign_all(plan, file, &pinned)
    })
}

/// The words over which a value is live.
#[derive(Clone, Copy, Debug)]
struct LiveRange {
    /// The word that stores it (its definition); -1 for the input, which is there before all words.
    born: isize,
    /// The last word that reads it (its last use).
    read: isize,
    pinned: Option<Analog>,
}

/// The live ranges of a plan.
struct LiveRanges {
    ranges: Vec<LiveRange>,
    /// The live range of each value.
    of_value: Vec<usize>,
    /// For each halving word whose unread half NEWS cannot take: the live range of the register
    /// that takes it.
    spare: Vec<Option<usize>>,
}

impl LiveRanges {
    /// The live ranges of all values; the input is live from before the first word.
    fn new(plan: &Plan, input: Analog) -> Option<Self> {
        let mut ranges = vec![LiveRange {
            born: -1,
            read: -1,
            pinned: Some(input),
        }];
        let mut spare: Vec<Option<usize>> = Vec::new();
        let mut of_value = vec![0];
        for (i, word) in plan.words.iter().enumerate() {
            let now = i as isize;
            for value in &word.values {
                let range = *of_value.get(*value)?;
                ranges[range].read = now;
            }
            let stored = LiveRange {
                born: now,
                read: now,
                pinned: None,
            };
            if word.makes_value() {
                of_value.push(ranges.len());
                ranges.push(stored);
            }
            let needs = word.halved && !takes_half(plan, i);
            spare.push(needs.then_some(ranges.len()));
            if needs {
                ranges.push(stored);
            }
        }
        Some(Self {
            ranges,
            of_value,
            spare,
        })
    }
}

/// Registers for all values, the goals in those of `pinned`; a goal without one is copied to its
/// place last.
fn assign_all(plan: &Plan, file: &RegisterFile, pinned: &[Option<Analog>]) -> Option<Allocated> {
    let mut live = LiveRanges::new(plan, file.input)?;
    let copies = live.pin_goals(plan, file, pinned)?;
    let mut tries = TRIES;
    let mut registers = vec![None; live.ranges.len()];
    assign(&live.ranges, &mut registers, 0, file, &mut tries)?.then_some(())?;
    let registers: Vec<Analog> = registers.into_iter().collect::<Option<_>>()?;
    let mut out = live.words(plan, file, &registers)?;
    let goals = plan
        .goals
        .iter()
        .map(|goal| registers[live.of_value[*goal]]);
    let goals: Vec<_> = goals.collect();
    let moved = copies.iter().map(|(range, to)| (registers[*range], *to));
    let hops = moves(
        moved.filter(|(from, to)| from != to).collect(),
        file,
        &goals,
    )?;
    let before = live.held(&registers, plan.words.len() as isize);
    let mut held = before.clone();
    for hop in hops {
        out.words.push(hop.word);
        out.live.push(held.clone());
        if let Some((from, to)) = hop.moved {
            held.retain(|(register, _)| *register != to);
            let value = before.iter().find(|(register, _)| *register == from);
            held.extend(value.map(|(_, value)| (to, *value)));
            held.sort_unstable();
        }
    }
    Some(out)
}

impl LiveRanges {
    /// Makes the goals live to the end, in the registers of `pinned`. Returns the ranges of those
    /// that cannot be there all the time, and where they are to be copied.
    fn pin_goals(
        &mut self,
        plan: &Plan,
        file: &RegisterFile,
        pinned: &[Option<Analog>],
    ) -> Option<Vec<(usize, Analog)>> {
        let mut copies = Vec::new();
        for (goal, (value, pin)) in plan.goals.iter().zip(pinned).enumerate() {
            let range = *self.of_value.get(*value)?;
            let taken = plan.goals[..goal].contains(value);
            self.ranges[range].read = plan.words.len() as isize;
            let own = self.ranges[range].pinned;
            if own.is_some() && own != *pin || pin.is_none() || taken {
                copies.push((range, *file.into.get(goal)?));
            } else {
                self.ranges[range].pinned = *pin;
            }
        }
        Some(copies)
    }

    /// The words of a plan, with registers in place of values.
    fn words(&self, plan: &Plan, file: &RegisterFile, registers: &[Analog]) -> Option<Allocated> {
        let mut out = Allocated {
            words: Vec::new(),
            live: Vec::new(),
        };
        let mut stored = 0;
        for (i, word) in plan.words.iter().enumerate() {
            let mut targets = Vec::new();
            if word.makes_value() {
                stored += 1;
                targets.push(Target::Register(registers[*self.of_value.get(stored)?]));
            }
            if let Store::News(to) | Store::Both(to) = word.store {
                targets.push(to.map_or(Target::Register(file.news), Target::Neighbour));
            }
            if word.halved {
                let other = self.spare[i].map_or(file.news, |range| registers[range]);
                targets.push(Target::Register(other));
            }
            let views = word
                .views
                .iter()
                .map(|view| view.map_or(Source::Register(file.news), Source::Neighbour));
            let values = word
                .values
                .iter()
                .map(|value| Source::Register(registers[self.of_value[*value]]));
            out.words.push(Primitive::Bus {
                targets,
                sources: views.chain(values).collect(),
            });
            let now = i as isize;
            out.live.push(self.held(registers, now));
        }
        Some(out)
    }

    /// The registers that are live while word `now` runs, and the value in each.
    fn held(&self, registers: &[Analog], now: isize) -> Vec<(Analog, Value)> {
        let held = self.of_value.iter().enumerate().filter(|(_, range)| {
            let range = self.ranges[**range];
            range.born <= now && (now < range.read || range.born == now)
        });
        let mut held: Vec<_> = held
            .map(|(value, range)| (registers[*range], value))
            .collect();
        held.sort_unstable();
        held
    }
}

/// A word of a move, which takes two, since a store negates.
struct Hop {
    word: Primitive,
    /// What moved from where to where, once it is there.
    moved: Option<(Analog, Analog)>,
}

impl Hop {
    fn new(target: Analog, source: Analog, moved: Option<(Analog, Analog)>) -> Self {
        let word = Primitive::Bus {
            targets: vec![Target::Register(target)],
            sources: vec![Source::Register(source)],
        };
        Self { word, moved }
    }
}

/// Brings goals to their registers by way of NEWS: those first whose destination no other one still
/// has to leave. Where they stand in a ring, one of them waits in a free register; `None` where
/// there is none.
fn moves(
    mut left: Vec<(Analog, Analog)>,
    file: &RegisterFile,
    goals: &[Analog],
) -> Option<Vec<Hop>> {
    let (mut hops, mut waiting) = (Vec::new(), Vec::new());
    while !left.is_empty() {
        let leaves = |to: &Analog| left.iter().any(|(from, _)| from == to);
        if let Some(next) = left.iter().position(|(_, to)| !leaves(to)) {
            let (from, to) = left.remove(next);
            hops.push(Hop::new(file.news, from, None));
            hops.push(Hop::new(to, file.news, Some((from, to))));
            continue;
        }
        let (from, to) = left.remove(0);
        let is_free =
            |register: &&Analog| !goals.contains(register) && !file.into.contains(register);
        let spare = *file.all.iter().find(is_free)?;
        hops.push(Hop::new(spare, from, None));
        waiting.push(Hop::new(to, spare, Some((from, to))));
    }
    hops.extend(waiting);
    Some(hops)
}

/// Whether NEWS is dead at word `at`, so that it can take the unread half of a halving store.
fn takes_half(plan: &Plan, at: usize) -> bool {
    let word = &plan.words[at];
    if word.writes_news() || !word.views.is_empty() {
        return false;
    }
    for later in &plan.words[at + 1..] {
        if !later.views.is_empty() {
            return false;
        }
        if later.writes_news() {
            break;
        }
    }
    true
}

/// Whether two live ranges interfere, so that their values cannot share a register: a word must not
/// store where it reads.
fn interfere(a: LiveRange, b: LiveRange) -> bool {
    a.born <= b.read && b.born <= a.read
}

/// Assigns registers to one live range after the other; `None` after [`TRIES`] steps.
fn assign(
    ranges: &[LiveRange],
    registers: &mut Vec<Option<Analog>>,
    at: usize,
    file: &RegisterFile,
    tries: &mut u32,
) -> Option<bool> {
    let Some(range) = ranges.get(at) else {
        return Some(true);
    };
    *tries = tries.checked_sub(1)?;
    let taken = |register: Analog, registers: &[Option<Analog>]| {
        ranges
            .iter()
            .zip(registers)
            .enumerate()
            .any(|(i, (other, own))| {
                let held = own.or(other.pinned);
                i != at && held == Some(register) && interfere(*range, *other)
            })
    };
    let choices: Vec<Analog> = match range.pinned {
        Some(register) => vec![register],
        None => file.all.clone(),
    };
    for register in choices {
        if taken(register, registers) {
            continue;
        }
        registers[at] = Some(register);
        if assign(ranges, registers, at + 1, file, tries)? {
            return Some(true);
        }
        registers[at] = None;
    }
    Some(false)
}
