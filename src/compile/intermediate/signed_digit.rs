//! The signed digits (non-adjacent form) of a kernel's weights, in groups of exponents that one
//! walk adds.

use super::linear_form::LinearForm;

/// Rows and columns from the pixel.
pub(in crate::compile) type Place = (i16, i16);

/// A signed digit: the input, halved some times, to be added or subtracted at a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::compile) struct Digit {
    /// The number of halvings.
    pub(in crate::compile) halved: usize,
    /// Whether it is subtracted.
    pub(in crate::compile) negative: bool,
}

/// The digits to be added at each place.
pub(in crate::compile) type Visits = Vec<(Place, Vec<Digit>)>;

/// The digits of a goal in groups of `held` exponents, the lowest first; the whole of one group
/// counts 2^-held in the next. With them the exponent of the last group's input; `None` without
/// digits.
pub(in crate::compile) fn groups(goal: &LinearForm, held: usize) -> Option<(Vec<Visits>, usize)> {
    grouped(&planes(goal), held)
}

/// The same of digits in any form, by their exponents.
pub(in crate::compile) fn grouped(planes: &[Plane], held: usize) -> Option<(Vec<Visits>, usize)> {
    let last = planes.len().checked_sub(1)?;
    let group = |group: usize| {
        let top = last - group * held;
        let mut visits = Visits::new();
        for (exponent, plane) in planes[..=top].iter().enumerate().rev().take(held) {
            let halved = top - exponent;
            for &(place, negative) in plane {
                let digit = Digit { halved, negative };
                match visits.iter_mut().find(|(known, _)| *known == place) {
                    Some((_, digits)) => digits.push(digit),
                    None => visits.push((place, vec![digit])),
                }
            }
        }
        visits
    };
    Some(((0..=last / held).rev().map(group).collect(), last))
}

/// Digits of one exponent: their places, and whether they are subtracted.
pub(in crate::compile) type Plane = Vec<(Place, bool)>;

/// The digits of all weights by their exponents, in non-adjacent form: the fewest digits.
pub(in crate::compile) fn planes(goal: &LinearForm) -> Vec<Plane> {
    let mut planes: Vec<Plane> = Vec::new();
    for tap in goal.taps() {
        let (mut left, mut exponent) = (tap.weight, 0);
        while left != 0 {
            if left % 2 != 0 {
                // In non-adjacent form a digit is followed by a zero: it is chosen so that the rest
                // is divisible by 4.
                let digit = 2 - left.rem_euclid(4);
                left -= digit;
                if planes.len() <= exponent {
                    planes.resize(exponent + 1, Vec::new());
                }
                planes[exponent].push(((tap.y, tap.x), digit < 0));
            }
            left /= 2;
            exponent += 1;
        }
    }
    planes
}

/// The same as sign and magnitude: more digits, and at times one exponent less.
pub(in crate::compile) fn magnitudes(goal: &LinearForm) -> Vec<Plane> {
    let exponents = { goal.taps().iter() }
        .map(|tap| 64 - tap.weight.unsigned_abs().leading_zeros())
        .max();
    let plane = |exponent: u32| -> Plane {
        { goal.taps().iter() }
            .filter(|tap| tap.weight.unsigned_abs() >> exponent & 1 == 1)
            .map(|tap| ((tap.y, tap.x), tap.weight < 0))
            .collect()
    };
    (0..exponents.unwrap_or(0)).map(plane).collect()
}

/// How often a sum is doubled and halved whose last group's input has the exponent `last`, so that
/// it counts in units.
pub(in crate::compile) const fn scaling(unit: i64, last: usize) -> (usize, usize) {
    let one = unit.trailing_zeros() as usize;
    (last.saturating_sub(one), one.saturating_sub(last))
}

/// The most halvings of the input among these digits.
pub(in crate::compile) fn most_halved(visits: &Visits) -> usize {
    let all = visits.iter().flat_map(|(_, digits)| digits);
    all.map(|digit| digit.halved).max().unwrap_or(0)
}
