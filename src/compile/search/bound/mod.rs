//! Lower bounds: how many words a kernel takes at least, on any chip with the words of this one.
//!
//! A program here is one of the words that the compiler uses: a bus of up to four sources that
//! stores in a register or in NEWS of the pixel or of a neighbour, or one of up to two that stores
//! halves of the sum in two registers, or in a register and in NEWS. None stores in NEWS where it
//! reads NEWS. Registers are as many as it likes, so that a bound holds for every chip.
//!
//! Two bounds are taken together. Any kernel: two words move a value by at most two pixels (one
//! stores in a neighbour's NEWS, one reads a neighbour's), and n words sum at most 4^n inputs.
//! Ternary 3x3 kernels: an exhaustive search of all programs of up to
//! [`PROVED`] words, whose result is a table, `ternary.csv`; whatever is not in it takes more.
//!
//! Halves of a kernel, of an input that is halved: a few words more double them back, so they take at
//! most those few words less than the kernel and its negative do ([`LowerBound::halved`]).

mod exhaustive;
mod field;
mod state;

pub use exhaustive::{Exhausted, TERNARY, fewest_words};

use crate::{compile::codegen::instruction_set::has_wider_bus, isa::Device, kernel::Kernel};

/// The exhaustive search has tried all programs of up to so many words.
pub const PROVED: u8 = 5;

/// The kernels that it has found, one of those that differ by a turn or a mirror: the fewest words
/// and a program of so many.
///
/// A program is its words, each ended by a semicolon: `r` stores in a register, `h` half of the sum
/// in one, `n` in NEWS and `b` halves in both, after these two the cell in which it is seen; then
/// what is read, a digit for the value of a register (0 the input, the others in the order of their
/// stores), `.nesw` for the pixel's own NEWS cell and its neighbours'. It makes the kernel turned or
/// mirrored.
const TABLE: &str = include_str!("ternary.csv");

/// Why no program is shorter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Proof {
    /// Every program of fewer words was tried.
    Exhaustive,
    /// Every program of the kernel itself with fewer words was tried, and one of its halves, doubled
    /// back, would be one.
    Doubled,
    /// How far the weights lie from the pixel, and how large they are.
    Reach,
}

/// The fewest words that a program of a kernel can have, as far as it is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct LowerBound {
    /// No program has fewer.
    pub words: u8,
    /// Why.
    pub proof: Proof,
}

impl LowerBound {
    /// Of a filter of these kernels: no fewer than any of them takes alone.
    #[must_use]
    pub fn new(kernels: &[Kernel]) -> Self {
        Self::halved(kernels, 0)
    }

    /// Of a filter of `2^-halvings` times these kernels: no fewer than any of them takes alone.
    #[must_use]
    pub fn halved(kernels: &[Kernel], halvings: u32) -> Self {
        let none = Self {
            words: 0,
            proof: Proof::Reach,
        };
        let each = kernels.iter().map(|kernel| Self::of_one(kernel, halvings));
        each.fold(none, |a, b| if b.words > a.words { b } else { a })
    }

    /// Of such a filter on a chip: none where a bus of it takes more sources than those of the words
    /// above.
    #[must_use]
    pub fn on(kernels: &[Kernel], halvings: u32, device: &Device) -> Self {
        let kernels = if has_wider_bus(device) { &[] } else { kernels };
        Self::halved(kernels, halvings)
    }

    fn of_one(kernel: &Kernel, halvings: u32) -> Self {
        let reach = Self {
            words: reach(kernel, halvings),
            proof: Proof::Reach,
        };
        let Some(code) = code(kernel) else {
            return reach;
        };
        let tried = Self {
            words: doubled(code, halvings),
            proof: if halvings == 0 {
                Proof::Exhaustive
            } else {
                Proof::Doubled
            },
        };
        if reach.words > tried.words {
            reach
        } else {
            tried
        }
    }
}

/// The fewest words of a kernel: those of the table, or more than it has.
fn fewest(code: u16) -> u8 {
    // No word for nothing; a bus without sources makes a kernel of zeros.
    if code == ZERO {
        return 1;
    }
    listed(canonical(code)).unwrap_or(PROVED + 1)
}

/// The fewest words of `2^-halvings` times a kernel, by those of the kernel and of its negative.
///
/// The last word of a program for the half, done once more, stores it in a second register, and one
/// that sums the two stores the whole with the other sign. So the negative of the kernel takes at
/// most 2 words more than the half, and the kernel, as each store negates, 3. Twice that is 4 words
/// for either sign: two sums, or four copies and one sum; then 2 words for each further halving.
fn doubled(code: u16, halvings: u32) -> u8 {
    let less = |code, words: u32| u32::from(fewest(code)).saturating_sub(words);
    let negative = TERNARY as u16 - 1 - code;
    let twice = halvings.saturating_mul(2);
    let words = match halvings {
        0 => less(code, 0),
        1 => less(code, 3).max(less(negative, 2)),
        _ => less(code, twice).max(less(negative, twice)),
    };
    words as u8
}

/// The words that places and weights ask for.
fn reach(kernel: &Kernel, halvings: u32) -> u8 {
    let (rows, columns) = kernel.reach();
    let weights = kernel.weights();
    let taps = weights.indexed_iter().filter(|(_, weight)| **weight != 0.0);
    let far = taps.map(|((y, x), _)| y.abs_diff(rows) + x.abs_diff(columns));
    let far = 2 * far.max().unwrap_or(0).div_ceil(2);
    let size = kernel.magnitude() * 0.5f64.powi(halvings.min(1000) as i32);
    let many = (0..64).find(|words| size <= 4f64.powi(*words));
    // Kernels have at most some hundred weights.
    far.max(many.unwrap_or(64) as usize).min(255) as u8
}

/// The code of the kernel without a weight.
const ZERO: u16 = (TERNARY / 2) as u16;

/// The number of a ternary kernel whose weights lie within 3x3 pixels: its weights plus one as the
/// digits of a number to the base three, row by row, the north west the lowest. None for other
/// kernels.
#[must_use]
pub fn code(kernel: &Kernel) -> Option<u16> {
    let (rows, columns) = kernel.reach();
    let mut code = ZERO;
    for ((y, x), &weight) in kernel.weights().indexed_iter() {
        let digit = [-1.0, 0.0, 1.0].iter().position(|w| *w == weight)?;
        if digit == 1 {
            continue;
        }
        let place = |at: usize, middle: usize| (at + 1).checked_sub(middle).filter(|it| *it < 3);
        let at = 3 * place(y, rows)? + place(x, columns)?;
        let one = 3u16.pow(at as u32);
        code = if digit == 0 { code - one } else { code + one };
    }
    Some(code)
}

/// The weights of a kernel of this number, row by row.
#[must_use]
pub fn weights(code: u16) -> [[i8; 3]; 3] {
    let digit = |at: u32| (code / 3u16.pow(at) % 3) as i8 - 1;
    std::array::from_fn(|y| std::array::from_fn(|x| digit((3 * y + x) as u32)))
}

/// The kernels that differ from this one by a turn or a mirror, itself among them.
pub(super) fn orbit(code: u16) -> [u16; 8] {
    let own = weights(code);
    std::array::from_fn(|g| {
        let mut code = 0;
        for at in (0..9).rev() {
            let (mut y, mut x) = (at / 3, at % 3);
            if g & 1 == 1 {
                x = 2 - x;
            }
            if g & 2 == 2 {
                y = 2 - y;
            }
            if g & 4 == 4 {
                (y, x) = (x, y);
            }
            code = 3 * code + (own[y][x] + 1) as u16;
        }
        code
    })
}

/// The one of a kernel and those that differ from it by a turn or a mirror that stands for all.
#[must_use]
pub fn canonical(code: u16) -> u16 {
    orbit(code).into_iter().min().unwrap_or(code)
}

/// The numbers that stand for their classes: 2,862.
pub fn classes() -> impl Iterator<Item = u16> {
    (0..TERNARY as u16).filter(|code| canonical(*code) == *code)
}

/// The same for all of a class: the fewest words of any of them.
fn symmetric(fewest: &[Option<u8>]) -> Vec<Option<u8>> {
    let of = |code: u16| {
        let own = orbit(code);
        own.iter()
            .filter_map(|code| fewest[usize::from(*code)])
            .min()
    };
    (0..TERNARY as u16).map(of).collect()
}

/// The rows of the table: the class, its fewest words, and a program.
fn rows() -> impl Iterator<Item = (u16, u8, &'static str)> {
    TABLE.lines().skip(1).filter_map(|line| {
        let (code, rest) = line.split_once(',')?;
        let (words, program) = rest.split_once(',')?;
        Some((code.parse().ok()?, words.parse().ok()?, program))
    })
}

/// The fewest words of a class, where it is in the table.
fn listed(canonical: u16) -> Option<u8> {
    let mut rows = rows();
    rows.find(|row| row.0 == canonical).map(|row| row.1)
}

/// A shortest program of a kernel, turned or mirrored, where it is in the table.
pub(super) fn program(code: u16) -> Option<&'static str> {
    let canonical = canonical(code);
    let mut rows = rows();
    rows.find(|row| row.0 == canonical).map(|row| row.2)
}

/// The classes in the table, with their fewest words.
#[cfg(test)]
pub(super) fn listed_classes() -> impl Iterator<Item = (u16, u8)> {
    rows().map(|row| (row.0, row.1))
}

/// The table of a search, as `ternary.csv` has it; a kernel of zeros is in none.
#[must_use]
pub fn table(found: &Exhausted) -> String {
    let rows = classes().filter(|code| *code != ZERO).filter_map(|code| {
        let words = found.fewest[usize::from(code)]?;
        let program = found.programs.get(&code)?;
        Some(format!("{code},{words},{program}\n"))
    });
    let mut text = "class,words,program\n".to_owned();
    text.extend(rows);
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kernel(code: u16) -> Kernel {
        let rows = weights(code).map(|row| row.map(f64::from).to_vec());
        Kernel::from_rows(&rows).unwrap()
    }

    #[test]
    fn codes_and_classes() {
        assert_eq!(classes().count(), 2862);
        let signed = classes().filter(|code| canonical(TERNARY as u16 - 1 - code) >= *code);
        assert_eq!(signed.count(), 1444);
        for own in [0, 1, 9841, 12345, 19682] {
            assert_eq!(code(&kernel(own)), Some(own));
        }
        assert!((0..19683).all(|code| orbit(code).contains(&code)));
    }

    /// The table against the search, as far as that is quick.
    #[test]
    fn the_table_is_what_the_search_finds() {
        let found = fewest_words(3);
        for code in classes().filter(|code| *code != ZERO) {
            let table = listed(code).filter(|words| *words <= 3);
            assert_eq!(found.fewest[usize::from(code)], table, "{code}");
        }
    }

    /// Every program of two and of three words, one by one, its forms as they are.
    mod one_by_one {
        use super::super::*;
        use crate::compile::intermediate::linear_form::LinearForm;
        use crate::compile::intermediate::linear_form::NEWS_CELLS;

        /// Values in registers, and what NEWS holds.
        pub type Held = (Vec<LinearForm>, Option<LinearForm>);

        pub fn expand((registers, news): &Held, see: &mut dyn FnMut(Held, bool)) {
            let seen = |cell| news.iter().map(move |news: &LinearForm| news.shifted(cell));
            let cells = NEWS_CELLS.into_iter().flat_map(seen);
            let sources: Vec<LinearForm> = registers.iter().cloned().chain(cells).collect();
            for mask in 1u32..1 << sources.len() {
                if mask.count_ones() > 4 {
                    continue;
                }
                let own = { 0..sources.len() }.filter(|i| mask >> i & 1 == 1);
                let none = LinearForm::default();
                let sum = own.fold(none, |sum, i| sum.plus(&sources[i], 1));
                let may_store = mask >> registers.len() == 0;
                let with = |more: &[&LinearForm]| {
                    let more = more.iter().map(|form| (*form).clone());
                    registers.iter().cloned().chain(more).collect::<Vec<_>>()
                };
                let whole = sum.times(-1);
                see((with(&[&whole]), news.clone()), true);
                for cell in NEWS_CELLS.into_iter().filter(|_| may_store) {
                    see((with(&[]), Some(whole.shifted(cell))), false);
                }
                let Some(half) = whole.half().filter(|_| mask.count_ones() <= 2) else {
                    continue;
                };
                see((with(&[&half, &half]), news.clone()), true);
                for cell in NEWS_CELLS.into_iter().filter(|_| may_store) {
                    see((with(&[&half]), Some(half.shifted(cell))), true);
                }
            }
        }

        pub fn code(form: &LinearForm, unit: i64) -> Option<u16> {
            let mut code = ZERO;
            for tap in form.taps() {
                let is_near = tap.y.abs() < 2 && tap.x.abs() < 2;
                let at = (3 * (tap.y + 1) + tap.x + 1) as u32;
                match tap.weight {
                    weight if is_near && weight == unit => code += 3u16.pow(at),
                    weight if is_near && weight == -unit => code -= 3u16.pow(at),
                    _ => return None,
                }
            }
            Some(code)
        }
    }

    /// The search, which looks at no program alone, against one that looks at each.
    #[test]
    fn the_search_finds_what_all_programs_of_three_words_make() {
        use crate::compile::intermediate::linear_form::LinearForm;
        let unit = 8;
        let mut made = std::collections::BTreeSet::new();
        let start = (vec![LinearForm::unit(unit)], None);
        one_by_one::expand(&start, &mut |first, _| {
            one_by_one::expand(&first, &mut |second, _| {
                one_by_one::expand(&second, &mut |(registers, _), in_register| {
                    let last = registers.last().filter(|_| in_register);
                    made.extend(last.and_then(|form| one_by_one::code(form, unit)));
                });
            });
        });
        let made: std::collections::BTreeSet<u16> = made.into_iter().map(canonical).collect();
        let found = fewest_words(3);
        for code in classes().filter(|code| *code != ZERO) {
            // Of 0, 1 and 2 words there are programs of 3 as well, or none that matters.
            match found.fewest[usize::from(code)] {
                Some(3) => assert!(made.contains(&code), "{code} is not made"),
                Some(_) => {}
                None => assert!(!made.contains(&code), "{code} is made"),
            }
        }
    }

    /// Against all programs of up to three words: those that make a half, or a quarter, of a kernel
    /// have no fewer words than is said, and the bound is reached.
    #[test]
    fn halves_take_no_fewer_words_than_is_said() {
        use field::{HALF, multiply, of_ternary};
        use state::State;
        use std::collections::HashMap;

        for halvings in 1..=2 {
            let scaled = |code| (0..halvings).fold(of_ternary(code), |n, _| multiply(n, HALF));
            let codes: HashMap<u64, u16> = (0..TERNARY as u16)
                .filter(|code| *code != ZERO)
                .map(|code| (scaled(code), code))
                .collect();
            let (mut made, mut tight) = (0, 0);
            let mut look = |state: &State| {
                let last = state
                    .registers
                    .last()
                    .filter(|held| held.word == state.words);
                let Some(code) = last.and_then(|held| codes.get(&held.form[0])) else {
                    return;
                };
                let bound = LowerBound::halved(&[kernel(*code)], halvings).words;
                assert!(
                    bound <= state.words,
                    "{code}: {bound}, and {}",
                    state.program
                );
                made += 1;
                tight += u32::from(bound == state.words);
            };
            State::start().expand(&mut |first| {
                look(&first);
                first.expand(&mut |second| {
                    look(&second);
                    second.expand(&mut |third| look(&third));
                });
            });
            assert!(made > 1000 && tight > 0, "{halvings}: {made}, {tight}");
        }
    }

    #[test]
    fn halves_are_bounded() {
        // In the table neither it nor its negative is.
        let hard = classes()
            .find(|code| fewest(*code) > PROVED && fewest(TERNARY as u16 - 1 - code) > PROVED);
        let hard = [kernel(hard.unwrap())];
        let of = |halvings| LowerBound::halved(&hard, halvings);
        assert_eq!((of(0).words, of(0).proof), (6, Proof::Exhaustive));
        assert_eq!((of(1).words, of(1).proof), (4, Proof::Doubled));
        assert_eq!((of(2).words, of(2).proof), (2, Proof::Doubled));
        assert_eq!((of(7).words, of(7).proof), (2, Proof::Reach));
        let heavy = [Kernel::from_rows(&[vec![65.0]]).unwrap()];
        assert_eq!(LowerBound::halved(&heavy, 1).words, 3);
    }

    #[test]
    fn what_is_far_or_heavy_takes_words() {
        let wide = Kernel::from_rows(&[vec![1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]]).unwrap();
        let bound = LowerBound::new(&[wide]);
        assert_eq!((bound.words, bound.proof), (4, Proof::Reach));
        let heavy = Kernel::from_rows(&[vec![65.0]]).unwrap();
        assert_eq!(LowerBound::new(&[heavy]).words, 4);
        let identity = Kernel::from_rows(&[vec![1.0]]).unwrap();
        assert_eq!(LowerBound::new(&[identity]).words, 0);
    }
}
