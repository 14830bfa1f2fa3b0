//! Random linear forms, for property tests.

use super::linear_form::{LinearForm, Tap};
use proptest::prelude::*;

/// Forms of 1 to 11 places up to `reach` away, with weights up to `most` in magnitude.
pub(in crate::compile) fn forms(reach: i16, most: i64) -> impl Strategy<Value = LinearForm> {
    let tap = (-reach..=reach, -reach..=reach, -most..=most);
    proptest::collection::btree_map(tap.prop_map(|(y, x, _)| (y, x)), -most..=most, 1..12).prop_map(
        |taps| {
            let taps = taps.into_iter();
            LinearForm::new(taps.map(|((y, x), weight)| Tap { y, x, weight }).collect())
        },
    )
}
