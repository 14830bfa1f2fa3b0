//! The intermediate representation: what is asked for, and programs before they have registers.
//!
//! - [`linear_form`]: what a register holds; [`goals`]: kernels as such forms; [`signed_digit`]: their
//!   weights, digit by digit.
//! - [`plan`]: bus words over values.
//! - `random_form`: forms for property tests.

pub(super) mod goals;
pub(super) mod linear_form;
pub(super) mod plan;
#[cfg(test)]
pub(super) mod random_form;
pub(super) mod signed_digit;
