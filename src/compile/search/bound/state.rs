//! What a program holds after some words, whatever its registers: the states of the exhaustive
//! search.

use super::field::{HALF, STEPS, add, multiply, negate};
use crate::{
    compile::intermediate::plan::{SOURCES, SOURCES_SPLIT},
    rng::GOLDEN,
};

/// A linear form under each of the eight symmetries of the square.
pub(super) type Form = [u64; 8];

/// A value, and the word that stored it: 0 is the input.
#[derive(Clone, Copy, Debug)]
pub(super) struct Held {
    pub(super) form: Form,
    pub(super) word: u8,
}

/// What is held after some words.
#[derive(Clone, Debug)]
pub(super) struct State {
    /// Everything that was ever stored in a register.
    pub(super) registers: Vec<Held>,
    /// What NEWS holds.
    pub(super) news: Option<Held>,
    /// The words of which nothing was read yet, as a bit mask.
    pub(super) unread: u8,
    /// Words so far.
    pub(super) words: u8,
    /// The words, as the [table](super) has them.
    pub(super) program: String,
}

/// The five NEWS cells as they are written: the pixel's own, then its neighbours'.
pub(super) const CELLS: [char; 5] = ['.', 'n', 'e', 's', 'w'];

/// Some of the sources, at most [`SOURCES`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Subset {
    pub(super) sum: Form,
    /// The words whose values are read, as a bit mask.
    pub(super) reads: u8,
    pub(super) size: u8,
    /// Which of the sources, as a bit mask.
    pub(super) members: u32,
}

impl Subset {
    const EMPTY: Self = Self {
        sum: [0; 8],
        reads: 0,
        size: 0,
        members: 0,
    };
}

fn map(form: &Form, by: impl Fn(usize, u64) -> u64) -> Form {
    std::array::from_fn(|g| by(g, form[g]))
}

/// The form one step away.
pub(super) fn shifted(form: &Form, step: usize) -> Form {
    map(form, |g, value| multiply(value, STEPS[g][step]))
}

impl State {
    /// The input in one register.
    pub(super) fn start() -> Self {
        Self {
            registers: vec![Held {
                form: [1; 8],
                word: 0,
            }],
            news: None,
            unread: 0,
            words: 0,
            program: String::new(),
        }
    }

    /// A set of the sources as it is written: the number of each value, counted over the words that
    /// stored in a register, and a letter for each NEWS cell.
    pub(super) fn written(&self, members: u32) -> String {
        let mut text = String::new();
        let mut number = 0;
        for (i, held) in self.registers.iter().enumerate() {
            number += usize::from(i > 0 && self.registers[i - 1].word != held.word);
            if members >> i & 1 == 1 {
                text += &number.to_string();
            }
        }
        let cells = members >> self.registers.len();
        text.extend((0..5).filter(|i| cells >> i & 1 == 1).map(|i| CELLS[i]));
        text
    }

    /// The number that the next value in a register will have.
    pub(super) fn next_value(&self) -> usize {
        let mut words: Vec<u8> = self.registers.iter().map(|held| held.word).collect();
        words.dedup();
        words.len()
    }

    /// Everything that a word can read: the registers, then the five NEWS cells.
    pub(super) fn sources(&self) -> Vec<Held> {
        let mut all = self.registers.clone();
        if let Some(news) = self.news {
            all.extend((0..5).map(|step| Held {
                form: shifted(&news.form, step),
                ..news
            }));
        }
        all
    }

    /// All sets of at most `most` of some sources, the empty one first.
    pub(super) fn subsets(sources: &[Held], most: usize) -> Vec<Subset> {
        let mut all = vec![Subset::EMPTY];
        for (i, held) in sources.iter().enumerate() {
            for at in 0..all.len() {
                let part = all[at];
                if usize::from(part.size) < most {
                    all.push(Subset {
                        sum: map(&part.sum, |g, value| add(value, held.form[g])),
                        reads: part.reads | 1 << held.word,
                        size: part.size + 1,
                        members: part.members | 1 << i,
                    });
                }
            }
        }
        all
    }

    /// Whether a set of the sources has no NEWS cell, so that the word may store in NEWS: none stores
    /// where it reads.
    pub(super) fn is_of_registers(&self, part: &Subset) -> bool {
        part.members >> self.registers.len() == 0
    }

    /// Gives every state that one more word leads to.
    pub(super) fn expand(&self, see: &mut dyn FnMut(Self)) {
        for read in Self::subsets(&self.sources(), SOURCES) {
            if read.size == 0 || read.sum[0] == 0 {
                continue;
            }
            let whole = map(&read.sum, |_, value| negate(value));
            let from_registers = self.is_of_registers(&read);
            self.store(&read, (Some(whole), None), "r", see);
            for step in (0..5).filter(|_| from_registers) {
                let to = format!("n{}", CELLS[step]);
                self.store(&read, (None, Some(shifted(&whole, step))), &to, see);
            }
            if usize::from(read.size) > SOURCES_SPLIT {
                continue;
            }
            let half = map(&whole, |_, value| multiply(value, HALF));
            self.store(&read, (Some(half), None), "h", see);
            for step in (0..5).filter(|_| from_registers) {
                let to = format!("b{}", CELLS[step]);
                self.store(&read, (Some(half), Some(shifted(&half, step))), &to, see);
            }
        }
    }

    /// The state after a word that has read these sources and stored this in a register (twice if
    /// it is a half without NEWS) and in NEWS.
    fn store(
        &self,
        read: &Subset,
        (register, news): (Option<Form>, Option<Form>),
        to: &str,
        see: &mut dyn FnMut(Self),
    ) {
        let word = self.words + 1;
        let mut next = Self {
            words: word,
            program: format!("{}{to}{};", self.program, self.written(read.members)),
            unread: (self.unread & !read.reads) | 1 << word,
            ..self.clone()
        };
        if let Some(form) = register {
            let held = Held { form, word };
            let copies = if to == "h" { 2 } else { 1 };
            next.registers.extend(std::iter::repeat_n(held, copies));
        }
        if let Some(form) = news {
            // A word whose only value is gone before it was read could be left out.
            let gone = self.news.is_some_and(|old| {
                let kept = self.registers.iter().any(|held| held.word == old.word);
                next.unread & 1 << old.word != 0 && !kept
            });
            if gone {
                return;
            }
            next.news = Some(Held { form, word });
        }
        see(next);
    }

    /// A key that is the same for states which differ by a symmetry or by the order of their
    /// words.
    pub(super) fn key(&self) -> u128 {
        let marks = |held: &Held| {
            let unread = self.unread >> held.word & 1;
            let of_word = |other: &&Held| other.word == held.word;
            let twins = self.registers.iter().chain(&self.news).filter(of_word);
            // Who shares a word matters only while that word is unread.
            u64::from(unread) * (1 + (twins.count() as u64 - 1))
        };
        let key = |g: usize| {
            let mut all: Vec<(u64, u64)> = { self.registers.iter() }
                .map(|held| (held.form[g], marks(held)))
                .collect();
            all.sort_unstable();
            let news = self.news.as_ref();
            all.push(news.map_or((u64::MAX, 0), |held| (held.form[g], marks(held))));
            let (mut a, mut b) = (0x243F_6A88_85A3_08D3u64, 0x1319_8A2E_0370_7344u64);
            for (value, marks) in all {
                for part in [value, marks] {
                    a = (a ^ part).wrapping_mul(GOLDEN);
                    a ^= a >> 29;
                    b = (b.rotate_left(23) ^ part).wrapping_mul(0xC2B2_AE3D_27D4_EB4F);
                    b ^= b >> 31;
                }
            }
            u128::from(a) << 64 | u128::from(b)
        };
        (0..8).map(key).min().unwrap_or_default()
    }
}
