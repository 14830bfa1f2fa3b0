//! The fewest words of every ternary 3x3 kernel, as far as an exhaustive search goes.
//!
//! All programs of some words are tried, with as many registers as they like: so what takes more
//! words here takes more on every chip. All states after n - 2 words are made, one of those that
//! differ by a turn or a mirror; the last two words are not made one by one, since the last must
//! read the one before it: with `v = -c·ΣX` stored by the first of them, the result is
//! `-c'·(ΣY + v·P)`, X, Y sets of sources and P the cells in which `v` is seen, and whether that is
//! one of the 19,683 ternary kernels is one look-up. Forms are numbers of a
//! [`field`](super::field).

use std::collections::{BTreeMap, HashMap, HashSet};

use rayon::prelude::*;

use super::{
    field::{HALF, STEPS, add, multiply, of_ternary, subtract},
    state::{CELLS, State, Subset},
};
use crate::compile::intermediate::plan::{SOURCES, SOURCES_SPLIT};

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
    /// A shortest program of one of each class, where one was found.
    pub programs: BTreeMap<u16, String>,
}

/// Kernels that were found, each with a program.
type Codes = HashMap<u16, String>;

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
    /// Where it was stored, and the cells in which it is seen, as a bit mask.
    to: usize,
    mask: u8,
}

impl Pattern {
    fn written(&self) -> String {
        let seen = (0..5).filter(|i| self.mask >> i & 1 == 1);
        seen.map(|i| CELLS[i]).collect()
    }
}

/// Every way in which one form in NEWS can be read, each once: the store may put it a step away.
fn patterns() -> Vec<Pattern> {
    let mut known = HashSet::new();
    let mut all = Vec::new();
    for (to, by) in STEPS[0].into_iter().enumerate() {
        for mask in 1u8..32 {
            let cells = mask.count_ones() as usize;
            if cells > SOURCES {
                continue;
            }
            let seen = (0..5).filter(|i| mask >> i & 1 == 1);
            let sum = seen.fold(0, |sum, i| add(sum, multiply(STEPS[0][i], by)));
            if known.insert((cells, sum)) {
                all.push(Pattern {
                    cells,
                    factor: sum,
                    to,
                    mask,
                });
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
            ..pattern
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
    let mut programs = BTreeMap::new();
    let mut found = |code: u16, words: u8, program: String| {
        let old = &mut fewest[usize::from(code)];
        if old.is_none_or(|old| words < old) {
            *old = Some(words);
            programs.entry(super::canonical(code)).or_insert(program);
        }
    };
    // The input itself, and minus the input.
    for (number, words, program) in [(1, 0, ""), (subtract(0, 1), 1, "r0;")] {
        if let Some(code) = last.goals.find(number) {
            found(code, words, program.to_owned());
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
                        let mut codes = Codes::new();
                        let (mut at, mut next) = (0, new.iter().peekable());
                        parent.expand(&mut |state| {
                            if next.next_if(|own| **own == at).is_some() {
                                last.two(&state, &mut codes);
                            }
                            at += 1;
                        });
                        codes
                    })
                    .reduce(Codes::new, joined);
                sorted(codes).for_each(|(code, program)| found(code, before + 2, program));
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
            let mut codes = Codes::new();
            last.two(state, &mut codes);
            codes
        };
        let codes = level.par_iter().map(of_state);
        let codes = codes.reduce(Codes::new, joined);
        sorted(codes).for_each(|(code, program)| found(code, before + 2, program));
    }
    Exhausted {
        words,
        states,
        fewest: super::symmetric(&fewest),
        programs,
    }
}

fn joined(mut a: Codes, b: Codes) -> Codes {
    for (code, program) in b {
        insert(&mut a, code, program);
    }
    a
}

fn insert(codes: &mut Codes, code: u16, program: String) {
    let better = |old: &String| rank(&program) < rank(old);
    if codes.get(&code).is_none_or(better) {
        codes.insert(code, program);
    }
}

/// Programs that the compiler can write down first, those of few registers first among them.
fn rank(program: &str) -> (bool, usize, &str) {
    let twice = |word: &str| {
        let bytes = word.as_bytes();
        bytes
            .windows(2)
            .any(|pair| pair[0] == pair[1] && pair[0].is_ascii_digit())
    };
    let stores = program.chars().filter(|c| "rhb".contains(*c)).count();
    (program.split(';').any(twice), stores, program)
}

/// Of kernels of one class the one with the better program first.
fn sorted(codes: Codes) -> impl Iterator<Item = (u16, String)> {
    let mut all: Vec<_> = codes.into_iter().collect();
    all.sort_by(|a, b| rank(&a.1).cmp(&rank(&b.1)).then(a.0.cmp(&b.0)));
    all.into_iter()
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
    fn two(&self, state: &State, codes: &mut Codes) {
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
        let mut see = |number: u64, words: &dyn Fn() -> [String; 2]| {
            if let Some(code) = self.goals.find(number) {
                let [first, second] = words();
                insert(codes, code, format!("{}{first};{second};", state.program));
            }
        };
        let next = state.next_value();
        for first in any.iter().filter(|part| part.size > 0) {
            let need = state.unread & !first.reads;
            let sum = first.sum[0];
            let half = multiply(sum, HALF);
            let splits = usize::from(first.size) <= SOURCES_SPLIT;
            // The first word stored in a register, whole or halved. What both read cancels.
            for &(other, size, members) in anywhere.that_read(need) {
                let words = |from: &str, to: &str| {
                    let read = state.written(first.members);
                    let other = state.written(members);
                    [format!("{from}{read}"), format!("{to}{next}{other}")]
                };
                if members & first.members == 0 {
                    let whole = subtract(sum, other);
                    see(whole, &|| words("r", "r"));
                    if size < SOURCES_SPLIT {
                        see(multiply(whole, HALF), &|| words("r", "h"));
                    }
                }
                if splits {
                    let part = subtract(half, other);
                    see(part, &|| words("h", "r"));
                    if size < SOURCES_SPLIT {
                        see(multiply(part, HALF), &|| words("h", "h"));
                    }
                }
            }
            // In NEWS; halved also in a register beside it.
            let others = kept.that_read(need);
            if others.is_empty() || !state.is_of_registers(first) {
                continue;
            }
            let mut each = |patterns: &[Pattern], stored: u64, kind: &str, own: &str| {
                for pattern in patterns {
                    let seen = multiply(stored, pattern.factor);
                    for &(other, size, members) in others {
                        let words = |to: &str| {
                            let read = state.written(first.members);
                            let cells = pattern.written();
                            let other = state.written(members);
                            let at = CELLS[pattern.to];
                            [
                                format!("{kind}{at}{read}"),
                                format!("{to}{own}{other}{cells}"),
                            ]
                        };
                        if size + pattern.cells > SOURCES {
                            continue;
                        }
                        let result = subtract(seen, other);
                        see(result, &|| words("r"));
                        if size + pattern.cells <= SOURCES_SPLIT {
                            see(multiply(result, HALF), &|| words("h"));
                        }
                    }
                }
            };
            each(&self.patterns, sum, "n", "");
            if splits {
                let own = next.to_string();
                each(&self.patterns, half, "b", "");
                each(&self.with_register, half, "b", &own);
            }
        }
    }
}
