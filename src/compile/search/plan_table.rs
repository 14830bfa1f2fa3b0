//! Plans from the table of the [exhaustive search](super::bound): a ternary 3x3 kernel that is in it
//! needs no search.

use super::bound;
use crate::{
    compile::intermediate::{
        linear_form::{LinearForm, Tap},
        plan::{Plan, Store, Value, Word},
    },
    isa::Direction,
};

/// A plan of the fewest words for a goal that is in the table, whatever its registers; `None` for
/// other goals, and where the program has a word that plans do not have.
pub(super) fn listed(goal: &LinearForm, unit: i64) -> Option<Plan> {
    let code = code(goal, unit)?;
    let program = bound::program(code)?;
    // The program is of some turned or mirrored kernel: one of eight turns makes it this one.
    (0..8).find_map(|turn| {
        let plan = parsed(program, turn)?;
        // Halves on the way are whole in finer units.
        let trace = plan.trace(FINE)?;
        let result = trace.values.get(*plan.goals.first()?)?;
        (result.times(unit) == goal.times(FINE)).then_some(plan)
    })
}

/// Finer units than any half of a listed program needs.
const FINE: i64 = 1 << 12;

/// The number of a ternary goal within 3x3 pixels.
fn code(goal: &LinearForm, unit: i64) -> Option<u16> {
    let mut code = (bound::TERNARY / 2) as u16;
    for &Tap { y, x, weight } in goal.taps() {
        if y.abs() > 1 || x.abs() > 1 || weight.abs() != unit {
            return None;
        }
        let one = 3u16.pow((3 * (y + 1) + x + 1) as u32);
        code = if weight < 0 { code - one } else { code + one };
    }
    Some(code)
}

/// A program of the table, turned.
fn parsed(program: &str, turn: usize) -> Option<Plan> {
    let mut plan = Plan::default();
    let mut values: Value = 1;
    for text in program.split_terminator(';') {
        let mut letters = text.chars();
        let (stores, halved, news) = match letters.next()? {
            'r' => (true, false, false),
            'h' => (true, true, false),
            'n' => (false, false, true),
            'b' => (true, false, true),
            _ => return None,
        };
        // Where NEWS is seen from: it was stored the other way.
        let to = if news {
            cell(letters.next()?, turn)?.map(Direction::opposite)
        } else {
            None
        };
        let store = match (stores, news) {
            (true, true) => Store::Both(to),
            (_, true) => Store::News(to),
            (_, false) => Store::Register,
        };
        let mut word = Word {
            store,
            views: Vec::new(),
            values: Vec::new(),
            halved,
        };
        for letter in letters {
            match letter.to_digit(10) {
                Some(value) => word.values.push(value as Value),
                None => word.views.push(cell(letter, turn)?),
            }
        }
        let mut sorted = word.values.clone();
        sorted.dedup();
        // Both halves of one word: a plan has one value of it.
        if sorted.len() < word.values.len() {
            return None;
        }
        values += usize::from(stores);
        plan.words.push(word);
    }
    plan.goals = vec![values - 1];
    Some(plan)
}

/// A NEWS cell, turned: the pixel's own as `None` within.
#[expect(
    clippy::option_option,
    reason = "none of the neighbours is the pixel itself"
)]
fn cell(letter: char, turn: usize) -> Option<Option<Direction>> {
    let [mut north, mut east] = [Direction::North, Direction::East];
    if turn & 4 == 4 {
        (north, east) = (Direction::West, Direction::South);
    }
    if turn & 1 == 1 {
        east = east.opposite();
    }
    if turn & 2 == 2 {
        north = north.opposite();
    }
    Some(match letter {
        '.' => None,
        'n' => Some(north),
        'e' => Some(east),
        's' => Some(north.opposite()),
        'w' => Some(east.opposite()),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every program of the table makes its kernel, and all seven turned ones, in the words that
    /// the table says.
    #[test]
    fn every_listed_program_makes_its_kernel() {
        let mut without = 0;
        let unit = 4;
        for (code, words) in bound::listed_classes() {
            for own in bound::orbit(code) {
                let weights = bound::weights(own);
                let taps = (0..9).map(|at: usize| Tap {
                    y: (at / 3) as i16 - 1,
                    x: (at % 3) as i16 - 1,
                    weight: i64::from(weights[at / 3][at % 3]) * unit,
                });
                let goal = LinearForm::new(taps.collect());
                match listed(&goal, unit) {
                    Some(plan) => assert_eq!(plan.words.len(), usize::from(words), "{own}"),
                    None => without += 1,
                }
            }
        }
        // Few need both halves of one word.
        assert!(without < 100, "{without}");
        assert!(listed(&LinearForm::unit(2), 1).is_none());
    }
}
