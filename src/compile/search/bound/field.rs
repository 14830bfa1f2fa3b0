//! Linear forms as numbers of a finite field: the form `Σ weight · input(p + (y, x))` becomes
//! `Σ weight · Y^y · X^x` modulo the prime 2^61 - 1, at fixed X and Y.
//!
//! A sum of forms is a sum of numbers, a shift a product, a half the product with (p + 1) / 2, all
//! exact and of any reach. Two equal forms have equal numbers; two different ones have equal
//! numbers by an accident of 1 in 2^61. An accident makes a form look reachable that is not, so a
//! lower bound that rests on "no number is equal" holds all the same.

/// The prime.
pub(super) const P: u64 = (1 << 61) - 1;

/// Half of one.
pub(super) const HALF: u64 = P.div_ceil(2);

pub(super) const fn add(a: u64, b: u64) -> u64 {
    let sum = a + b;
    if sum >= P { sum - P } else { sum }
}

pub(super) const fn negate(a: u64) -> u64 {
    if a == 0 { 0 } else { P - a }
}

pub(super) const fn subtract(a: u64, b: u64) -> u64 {
    add(a, negate(b))
}

pub(super) const fn multiply(a: u64, b: u64) -> u64 {
    let product = a as u128 * b as u128;
    let sum = (product & P as u128) as u64 + (product >> 61) as u64;
    if sum >= P { sum - P } else { sum }
}

const fn power(base: u64, mut exponent: u64) -> u64 {
    let (mut base, mut result) = (base, 1);
    while exponent > 0 {
        if exponent & 1 == 1 {
            result = multiply(result, base);
        }
        base = multiply(base, base);
        exponent >>= 1;
    }
    result
}

/// Where the polynomials are evaluated.
const X: u64 = 0x0A3C_59AC_B17E_D94F % P;
const Y: u64 = 0x1F83_D9AB_FB41_BD6B % P;

/// The eight symmetries of the square, each as what one step to the north, east, south and west
/// multiplies by, after the pixel itself.
pub(super) const STEPS: [[u64; 5]; 8] = {
    let (x, y) = ([X, power(X, P - 2)], [Y, power(Y, P - 2)]);
    let mut all = [[1; 5]; 8];
    let mut g = 0;
    while g < 8 {
        let (across, down) = if g & 4 == 0 { (x, y) } else { (y, x) };
        let (east, west) = (across[g & 1], across[1 - (g & 1)]);
        let (south, north) = (down[g >> 1 & 1], down[1 - (g >> 1 & 1)]);
        all[g] = [1, north, east, south, west];
        g += 1;
    }
    all
};

/// The number of a ternary 3x3 kernel: its weights plus one as the digits of a number to the base
/// three, row by row, the north west the lowest.
pub(super) fn of_ternary(code: u16) -> u64 {
    let [_, north, east, south, west] = STEPS[0];
    let (rows, columns) = ([north, 1, south], [west, 1, east]);
    let mut rest = code;
    let mut sum = 0;
    for row in rows {
        for column in columns {
            let place = multiply(row, column);
            sum = match rest % 3 {
                0 => subtract(sum, place),
                1 => sum,
                _ => add(sum, place),
            };
            rest /= 3;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_a_field_and_steps_undo_each_other() {
        assert_eq!(add(HALF, HALF), 1);
        assert_eq!(add(5, negate(5)), 0);
        assert_eq!(multiply(P - 1, P - 1), 1);
        for [one, north, east, south, west] in STEPS {
            assert_eq!(one, 1);
            assert_eq!(multiply(north, south), 1);
            assert_eq!(multiply(east, west), 1);
        }
        let all: std::collections::BTreeSet<_> = (0..19683).map(of_ternary).collect();
        assert_eq!(all.len(), 19683);
        // All weights 0, and the middle alone.
        assert_eq!((of_ternary(9841), of_ternary(9841 + 81)), (0, 1));
    }
}
