//! Separable kernels: a column times a row, compiled as one filter after the other.

use crate::{
    compile::intermediate::{
        linear_form::{LinearForm, Tap},
        plan::{Plan, values_made},
        signed_digit::Place,
    },
    number::greatest_common_divisor,
};

/// A one-dimensional goal, and its unit.
pub(in crate::compile) type Factor = (LinearForm, i64);

/// The row and the column whose outer product a goal is, if there are more than one of both.
pub(in crate::compile) fn factors(goal: &LinearForm, unit: i64) -> Option<[Factor; 2]> {
    let first = goal.taps().first()?;
    let of_row = |y: i16| goal.taps().iter().filter(move |tap| tap.y == y);
    let common = of_row(first.y).fold(0, |common, tap| greatest_common_divisor(common, tap.weight));
    let row: Vec<(i16, i64)> = of_row(first.y).map(|t| (t.x, t.weight / common)).collect();
    let (x, one) = *row.first()?;
    let mut column: Vec<(i16, i64)> = Vec::new();
    for tap in goal.taps().iter().filter(|tap| tap.x == x) {
        column.push((tap.y, tap.weight / one));
    }
    let taps = |list: &[(i16, i64)], place: &dyn Fn(i16) -> Place| {
        let tap = |(at, weight): &(i16, i64)| {
            let (y, x) = place(*at);
            Tap {
                y,
                x,
                weight: *weight,
            }
        };
        LinearForm::new(list.iter().map(tap).collect())
    };
    let mut product = Vec::new();
    for (y, a) in &column {
        product.extend(taps(&row, &|x| (*y, x)).times(*a).taps());
    }
    if row.len() < 2 || column.len() < 2 || LinearForm::new(product) != *goal {
        return None;
    }
    // The row is scaled to be as small as the input again, as far as the kernel is.
    let sum: i64 = row.iter().map(|(_, weight)| weight.abs()).sum();
    let share = unit.trailing_zeros().min(sum.ilog2());
    Some([
        (taps(&row, &|x| (0, x)), 1 << share),
        (taps(&column, &|y| (y, 0)), unit >> share),
    ])
}

/// Composition: the second plan on the result of the first.
pub(in crate::compile) fn compose(first: &Plan, second: &Plan) -> Option<Plan> {
    let result = *first.goals.first()?;
    let stores = values_made(&first.words);
    let renamed = |value: usize| if value == 0 { result } else { value + stores };
    let mut words = first.words.clone();
    for word in &second.words {
        let mut word = word.clone();
        for value in &mut word.values {
            *value = renamed(*value);
        }
        words.push(word);
    }
    let goals = second.goals.iter().map(|goal| renamed(*goal)).collect();
    Some(Plan { words, goals })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compile::{construction::walk::walks, intermediate::random_form::forms};
    use proptest::prelude::*;

    fn product(column: &[i64], row: &[i64]) -> LinearForm {
        let mut taps = Vec::new();
        for (y, a) in column.iter().enumerate() {
            for (x, b) in row.iter().enumerate() {
                taps.push(Tap {
                    y: y as i16,
                    x: x as i16,
                    weight: a * b,
                });
            }
        }
        LinearForm::new(taps)
    }

    proptest! {
        #[test]
        fn a_product_is_found_and_made(
            column in proptest::collection::vec(-9i64..10, 2..6),
            row in proptest::collection::vec(-9i64..10, 2..6),
            exponent in 0u32..9,
        ) {
            let several = |list: &[i64]| list.iter().filter(|w| **w != 0).count() > 1;
            prop_assume!(several(&column) && several(&row));
            let (goal, unit) = (product(&column, &row), 1i64 << exponent);
            let [(row, row_unit), (column, column_unit)] = factors(&goal, unit).unwrap();
            prop_assert_eq!(row_unit * column_unit, unit);
            let (row, column) = (walks(&row, row_unit), walks(&column, column_unit));
            let plan = compose(&row[0], &column[0]).unwrap();
            let fine = 1 << 20;
            let trace = plan.trace(unit * fine).unwrap();
            prop_assert_eq!(&trace.values[plan.goals[0]], &goal.times(fine));
        }

        #[test]
        fn nothing_else_is_a_product(goal in forms(2, 9)) {
            if let Some([(row, _), (column, _)]) = factors(&goal, 1) {
                let mut sum = LinearForm::default();
                for tap in column.taps() {
                    sum = sum.plus(&row.times(tap.weight).shifted((tap.y, tap.x)), 1);
                }
                prop_assert_eq!(sum, goal);
            }
        }
    }
}
