//! Registers for values.

use super::plan::{Plan, Store, Value, Word};
use crate::isa::{Analog, Primitive, Source, Target};

/// The registers that a filter may use.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Room {
    pub(super) news: Analog,
    /// Where the input begins.
    pub(super) input: Analog,
    /// Where each goal ends.
    pub(super) into: Vec<Analog>,
    /// All that may be used, those above included.
    pub(super) all: Vec<Analog>,
}

/// The words of a plan with registers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Allocated {
    pub(super) words: Vec<Primitive>,
    /// For every word, what each register that is live then holds.
    pub(super) live: Vec<Vec<(Analog, Value)>>,
}

/// Tries at most, before it is given up.
const TRIES: u32 = 20_000;

/// Finds registers; `None` when there are too few.
pub(super) fn allocate(plan: &Plan, room: &Room) -> Option<Allocated> {
    let pinned: Vec<Option<Analog>> = room.into.iter().copied().map(Some).collect();
    place(plan, room, &pinned).or_else(|| {
        // The goal over the input elsewhere, and brought there last.
        let over = room.into.iter().position(|r| *r == room.input)?;
        let mut pinned = pinned;
        pinned[over] = None;
        place(plan, room, &pinned)
    })
}

#[derive(Clone, Copy, Debug)]
struct Span {
    /// The word that stores it; the input is there before all.
    born: isize,
    /// The last word that reads it.
    read: isize,
    pinned: Option<Analog>,
}

#[expect(
    clippy::too_many_lines,
    reason = "spans, registers and words, in this order"
)]
fn place(plan: &Plan, room: &Room, pinned: &[Option<Analog>]) -> Option<Allocated> {
    let end = plan.words.len() as isize;
    let mut spans = vec![Span {
        born: -1,
        read: -1,
        pinned: Some(room.input),
    }];
    // Values that nobody reads: the other half, where NEWS cannot take it.
    let mut spare: Vec<Option<usize>> = Vec::new();
    let mut of_value = vec![0];
    for (i, word) in plan.words.iter().enumerate() {
        let now = i as isize;
        for value in &word.values {
            let span = *of_value.get(*value)?;
            spans[span].read = now;
        }
        if let Store::Register | Store::Both(_) = word.store {
            of_value.push(spans.len());
            spans.push(Span {
                born: now,
                read: now,
                pinned: None,
            });
        }
        let needs = word.halved && !takes_half(plan, i);
        spare.push(needs.then_some(spans.len()));
        if needs {
            spans.push(Span {
                born: now,
                read: now,
                pinned: None,
            });
        }
    }
    let mut last = Vec::new();
    for (goal, (value, pin)) in plan.goals.iter().zip(pinned).enumerate() {
        let span = *of_value.get(*value)?;
        let taken = plan.goals[..goal].contains(value);
        spans[span].read = end;
        let own = spans[span].pinned;
        if own.is_some() && own != *pin || pin.is_none() || taken {
            last.push((span, *room.into.get(goal)?));
        } else {
            spans[span].pinned = *pin;
        }
    }
    let mut tries = TRIES;
    let mut registers = vec![None; spans.len()];
    assign(&spans, &mut registers, 0, room, &mut tries)?.then_some(())?;
    let registers: Vec<Analog> = registers.into_iter().collect::<Option<_>>()?;
    let mut out = Allocated {
        words: Vec::new(),
        live: Vec::new(),
    };
    let mut stored = 0;
    for (i, word) in plan.words.iter().enumerate() {
        let mut targets = Vec::new();
        if let Store::Register | Store::Both(_) = word.store {
            stored += 1;
            targets.push(Target::Register(registers[*of_value.get(stored)?]));
        }
        if let Store::News(to) | Store::Both(to) = word.store {
            targets.push(to.map_or(Target::Register(room.news), Target::Neighbour));
        }
        if word.halved {
            let other = spare[i].map_or(room.news, |span| registers[span]);
            targets.push(Target::Register(other));
        }
        let views = word
            .views
            .iter()
            .map(|view| view.map_or(Source::Register(room.news), Source::Neighbour));
        let values = word
            .values
            .iter()
            .map(|value| Source::Register(registers[of_value[*value]]));
        out.words.push(Primitive::Bus {
            targets,
            sources: views.chain(values).collect(),
        });
        out.live
            .push(live(&spans, &registers, &of_value, i as isize));
    }
    // A goal that is elsewhere: none of these targets is needed as a source any more.
    for (span, to) in &last {
        if registers[*span] == *to {
            continue;
        }
        let conflict = last
            .iter()
            .any(|(other, _)| registers[*other] == *to && other != span);
        if conflict {
            return None;
        }
        let bus = |target, source| Primitive::Bus {
            targets: vec![Target::Register(target)],
            sources: vec![Source::Register(source)],
        };
        out.words.push(bus(room.news, registers[*span]));
        out.words.push(bus(*to, room.news));
        let held = live(&spans, &registers, &of_value, end);
        out.live.extend([held.clone(), held]);
    }
    Some(out)
}

/// Whether NEWS can take the half that nobody reads: it is neither read now nor later.
fn takes_half(plan: &Plan, at: usize) -> bool {
    let word = &plan.words[at];
    let writes = |word: &Word| matches!(word.store, Store::News(_) | Store::Both(_));
    if writes(word) || !word.views.is_empty() {
        return false;
    }
    for later in &plan.words[at + 1..] {
        if !later.views.is_empty() {
            return false;
        }
        if writes(later) {
            break;
        }
    }
    true
}

fn live(
    spans: &[Span],
    registers: &[Analog],
    of_value: &[usize],
    now: isize,
) -> Vec<(Analog, Value)> {
    let held = of_value.iter().enumerate().filter(|(_, span)| {
        let span = spans[**span];
        span.born <= now && (now < span.read || span.born == now)
    });
    let mut held: Vec<_> = held
        .map(|(value, span)| (registers[*span], value))
        .collect();
    held.sort_unstable();
    held
}

/// Whether two values cannot share a register: a word must not store where it reads.
fn meet(a: Span, b: Span) -> bool {
    a.born <= b.read && b.born <= a.read
}

/// One span after the other; `None` when tried too often.
fn assign(
    spans: &[Span],
    registers: &mut Vec<Option<Analog>>,
    at: usize,
    room: &Room,
    tries: &mut u32,
) -> Option<bool> {
    let Some(span) = spans.get(at) else {
        return Some(true);
    };
    *tries = tries.checked_sub(1)?;
    let taken = |register: Analog, registers: &[Option<Analog>]| {
        spans
            .iter()
            .zip(registers)
            .enumerate()
            .any(|(i, (other, own))| {
                let held = own.or(other.pinned);
                i != at && held == Some(register) && meet(*span, *other)
            })
    };
    let choices: Vec<Analog> = match span.pinned {
        Some(register) => vec![register],
        None => room.all.clone(),
    };
    for register in choices {
        if taken(register, registers) {
            continue;
        }
        registers[at] = Some(register);
        if assign(spans, registers, at + 1, room, tries)? {
            return Some(true);
        }
        registers[at] = None;
    }
    Some(false)
}
