//! The fewest words of every ternary 3x3 kernel, as far as an exhaustive search goes.
//!
//! All programs of some words are tried, with as many registers as they like: so what takes more
//! words here takes more on every chip. All states after n - 2 words are made, one of those that
//! differ by a turn or a mirror; the last two words are not made one by one, since the last must
//! read the one before it: with `v = -c·ΣX` stored by the first of them, the result is
//! `-c'·(ΣY + v·P)`, X, Y sets of sources and P the cells in which `v` is seen, and whether that is
//! one of the 19,683 ternary kernels is one look-up. Forms are numbers of a
//! [`field`](super::field).

use std::collections::{HashMap, HashSet};

use rayon::prelude::*;

use super::{
    field::{HALF, STEPS, add, multiply, of_ternary, subtract},
    state::{SOURCES, SOURCES_SPLIT, State, Subset},
};

/// Ternary 3x3 kernels.
pub const TERNARY: usize = 19_683;

/// What an exhaustive search has found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Exhausted {
    /// All programs of up to so many words were tried.
    pub words: u8,
    /// States from which the last two words were tried.
    pub states: u64,
    /// The fewest words of each kernel, by its [code](super::code); none where no program of so
    /// many words makes it.
    pub fewest: Vec<Option<u8>>,
}

/// The kernels as numbers of the field.
struct Goals {
    codes: HashMap<u64, u16>,
    /// Which low bits any of them has: most numbers are none, and are told so quickly.
    filter: Vec<u64>,
}

/// Low bits that are looked at first.
const FILTER: u32 = 20;

impl Goals {
    fn new() -> Self {
        let codes: HashMap<u64, u16> = (0..TERNARY as u16)
            .map(|code| (of_ternary(code), code))
            .collect();
        let mut filter = vec![0; 1 << (FILTER - 6)];
        for number in codes.keys() {
            let low = number & ((1 << FILTER) - 1);
            filter[(low >> 6) as usize] |= 1u64 << (low & 63);
        }
        Self { codes, filter }
    }

    fn find(&self, number: u64) -> Option<u16> {
        let low = number & ((1 << FILTER) - 1);
        let may = self.filter[(low >> 6) as usize] >> (low & 63) & 1 == 1;
        may.then(|| self.codes.get(&number).copied()).flatten()
    }
}

/// Sums of NEWS cells: how often a form is seen, and the factor of the field.
struct Pattern {
    cells: usize,
    factor: u64,
}

/// Every way in which one form in NEWS can be read, each once: the store may put it a step away.
fn patterns() -> Vec<Pattern> {
    let mut known = HashSet::new();
    let mut all = Vec::new();
    for to in STEPS[0] {
        for mask in 1u8..32 {
            let cells = mask.count_ones() as usize;
            if cells > SOURCES {
                continue;
            }
            let seen = (0..5).filter(|i| mask >> i & 1 == 1);
            let sum = seen.fold(0, |sum, i| add(sum, multiply(STEPS[0][i], to)));
            if known.insert((cells, sum)) {
                all.push(Pattern { cells, factor: sum });
            }
        }
    }
    all
}

/// Every way in which the same form in NEWS and in a register can be read together.
fn patterns_and_register() -> Vec<Pattern> {
    { patterns().into_iter() }
        .filter(|pattern| pattern.cells < SOURCES)
        .map(|pattern| Pattern {
            cells: pattern.cells + 1,
            factor: add(pattern.factor, 1),
        })
        .collect()
}

/// What the last two words are tried with.
struct Last {
    goals: Goals,
    patterns: Vec<Pattern>,
    with_register: Vec<Pattern>,
}

/// Tries all programs of up to `words` words, at least two. Each word more takes some hundred
/// times as long: four take seconds, five some minutes of a core.
#[must_use]
pub fn fewest_words(words: u8) -> Exhausted {
    let last = Last {
        goals: Goals::new(),
        patterns: patterns(),
        with_register: patterns_and_register(),
    };
    let mut fewest: Vec<Option<u8>> = vec![None; TERNARY];
    let mut found = |code: u16, words: u8| {
        let old = &mut fewest[usize::from(code)];
        *old = Some(old.map_or(words, |old| old.min(words)));
    };
    // The input itself, and minus the input.
    for (number, words) in [(1, 0), (subtract(0, 1), 1)] {
        if let Some(code) = last.goals.find(number) {
            found(code, words);
        }
    }
    let mut states = 0;
    let mut level = vec![State::start()];
    for before in 0..=words.saturating_sub(2) {
        let is_last = before + 2 >= words;
        if before > 0 {
            if is_last {
                // Too many to be held at once: which of each parent's children are new is noted,
                // and they are made again.
                let new = new_children(&level);
                states += new.iter().map(|list| list.len() as u64).sum::<u64>();
                let codes = { level.par_iter().zip(&new) }
                    .map(|(parent, new)| {
                        let mut codes = HashSet::new();
                        let (mut at, mut next) = (0, new.iter().peekable());
                        parent.expand(&mut |state| {
                            if next.next_if(|own| **own == at).is_some() {
                                last.two(&state, &mut codes);
                            }
                            at += 1;
                        });
                        codes
                    })
                    .reduce(HashSet::new, joined);
                codes.into_iter().for_each(|code| found(code, before + 2));
                break;
            }
            let mut known = HashSet::new();
            let mut next = Vec::new();
            for parent in &level {
                parent.expand(&mut |state| {
                    if known.insert(state.key()) {
                        next.push(state);
                    }
                });
            }
            level = next;
        }
        states += level.len() as u64;
        let of_state = |state: &State| {
            let mut codes = HashSet::new();
            last.two(state, &mut codes);
            codes
        };
        let codes = level.par_iter().map(of_state);
        let codes = codes.reduce(HashSet::new, joined);
        codes.into_iter().for_each(|code| found(code, before + 2));
    }
    Exhausted {
        words,
        states,
        fewest: super::symmetric(&fewest),
    }
}

fn joined(mut a: HashSet<u16>, b: HashSet<u16>) -> HashSet<u16> {
    a.extend(b);
    a
}

/// For each state the children that no state before it has, by their place among its children.
fn new_children(level: &[State]) -> Vec<Vec<u32>> {
    let mut known = HashSet::new();
    let mut all = Vec::with_capacity(level.len());
    // Keys are made side by side, some parents at a time.
    for some in level.chunks(256) {
        let keys: Vec<Vec<u128>> = { some.par_iter() }
            .map(|parent| {
                let mut keys = Vec::new();
                parent.expand(&mut |state| keys.push(state.key()));
                keys
            })
            .collect();
        for keys in keys {
            let new = { (0u32..).zip(keys) }.filter(|(_, key)| known.insert(*key));
            all.push(new.map(|(at, _)| at).collect());
        }
    }
    all
}

/// Sets of sources by what they must read: for each mask of unread words those sets which read
/// all of them.
struct Reading {
    /// Sum, size and members of each.
    all: Vec<Vec<(u64, usize, u32)>>,
}

impl Reading {
    fn new(subsets: &[Subset], unread: u8) -> Self {
        let of = |need: u8| {
            let own = subsets.iter().filter(|part| part.reads & need == need);
            own.map(|part| (part.sum[0], usize::from(part.size), part.members))
                .collect()
        };
        let all = (0..=unread).map(|need| {
            if need & !unread == 0 {
                of(need)
            } else {
                Vec::new()
            }
        });
        Self { all: all.collect() }
    }

    fn that_read(&self, need: u8) -> &[(u64, usize, u32)] {
        self.all.get(usize::from(need)).map_or(&[], Vec::as_slice)
    }
}

impl Last {
    /// The kernels that two more words make.
    fn two(&self, state: &State, codes: &mut HashSet<u16>) {
        let sources = state.sources();
        let any = State::subsets(&sources, SOURCES);
        let registers = &sources[..state.registers.len()];
        let kept = State::subsets(registers, SOURCES - 1);
        let some: Vec<Subset> = { any.iter() }
            .filter(|part| usize::from(part.size) < SOURCES)
            .copied()
            .collect();
        let (anywhere, kept) = (
            Reading::new(&some, state.unread),
            Reading::new(&kept, state.unread),
        );
        let mut see = |number: u64| {
            if let Some(code) = self.goals.find(number) {
                codes.insert(code);
            }
        };
        for first in any.iter().filter(|part| part.size > 0) {
            let need = state.unread & !first.reads;
            let sum = first.sum[0];
            let half = multiply(sum, HALF);
            let splits = usize::from(first.size) <= SOURCES_SPLIT;
            // The first word stored in a register, whole or halved. What both read cancels.
            for &(other, size, members) in anywhere.that_read(need) {
                if members & first.members == 0 {
                    let whole = subtract(sum, other);
                    see(whole);
                    if size < SOURCES_SPLIT {
                        see(multiply(whole, HALF));
                    }
                }
                if splits {
                    let part = subtract(half, other);
                    see(part);
                    if size < SOURCES_SPLIT {
                        see(multiply(part, HALF));
                    }
                }
            }
            // In NEWS; halved also in a register beside it.
            let others = kept.that_read(need);
            if others.is_empty() || !state.is_of_registers(first) {
                continue;
            }
            let mut each = |patterns: &[Pattern], stored: u64| {
                for pattern in patterns {
                    let seen = multiply(stored, pattern.factor);
                    for &(other, size, _) in others {
                        if size + pattern.cells > SOURCES {
                            continue;
                        }
                        let result = subtract(seen, other);
                        see(result);
                        if size + pattern.cells <= SOURCES_SPLIT {
                            see(multiply(result, HALF));
                        }
                    }
                }
            };
            each(&self.patterns, sum);
            if splits {
                each(&self.patterns, half);
                each(&self.with_register, half);
            }
        }
    }
}
