//! Whole numbers as signed powers of two.

/// How many powers of two, added or subtracted, a number needs at least: the nonzero digits of
/// its canonical signed-digit form.
#[must_use]
pub const fn signed_digits(value: i64) -> u32 {
    let value = value.unsigned_abs();
    (value ^ (3 * value)).count_ones()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The slow twin: the shortest of all sums, by trying.
    fn fewest(value: i64, most: u32) -> u32 {
        if value == 0 {
            return 0;
        }
        if most == 0 {
            return u32::MAX;
        }
        if value % 2 == 0 {
            return fewest(value / 2, most);
        }
        let next = [value - 1, value + 1].map(|rest| fewest(rest, most - 1));
        next.into_iter().min().unwrap_or(u32::MAX).saturating_add(1)
    }

    #[test]
    fn canonical_numbers_have_the_fewest_digits() {
        for value in -700..=700 {
            assert_eq!(signed_digits(value), fewest(value, 12), "{value}");
        }
    }
}
