//! The naive cost of a kernel: the words of the plainest program, as a yardstick.

use crate::{
    compile::{
        error::CompileError,
        intermediate::{goals::goals, linear_form::LinearForm},
    },
    kernel::Kernel,
    number::signed_digits,
};

/// The words of the naive program, which moves a shifted copy of the input over each kernel row by
/// row, to and fro: two for every step to the next place, two for every signed digit that is added,
/// and two for every halving or doubling of the copy from digit to digit; and two to bring the
/// result of a single weight back to the pixel.
///
/// # Errors
/// When a weight is not dyadic or a kernel is too large.
pub fn naive_cost(kernels: &[Kernel]) -> Result<u64, CompileError> {
    let (forms, unit) = goals(kernels)?;
    let one = i64::from(unit.trailing_zeros());
    let steps = kernels
        .iter()
        .map(|k| (k.weights().len() as u64 - 1).max(1));
    let taps = forms.iter().flat_map(LinearForm::taps);
    let weights = taps.map(|tap| {
        let first = i64::from(tap.weight.trailing_zeros()) - one;
        let last = i64::from(64 - tap.weight.unsigned_abs().leading_zeros()) - 1 - one;
        let shifts = (first.min(0).abs() + last.max(0)) as u64;
        2 * (u64::from(signed_digits(tap.weight)) + shifts)
    });
    Ok(2 * steps.sum::<u64>() + weights.sum::<u64>())
}
