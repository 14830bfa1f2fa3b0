//! Kernels as the goals of the search: weights in whole numbers of one unit.

use super::linear_form::{LinearForm, Tap};
use crate::{compile::error::CompileError, kernel::Kernel};

/// Weights are whole numbers of 2^-FRACTION.
const FRACTION: i32 = 12;

/// The largest weight.
const LARGEST: f64 = 4096.0;

/// The longest side of a kernel.
const SIDE: usize = 15;

/// The kernels in whole numbers of one unit, and the input in that unit.
pub(in crate::compile) fn goals(
    kernels: &[Kernel],
) -> Result<(Vec<LinearForm>, i64), CompileError> {
    let mut fraction = 0;
    for (kernel, own) in kernels.iter().enumerate() {
        let (height, width) = own.weights().dim();
        if height.max(width) > SIDE {
            return Err(CompileError::Size {
                kernel: format!("kernel {kernel}"),
                height,
                width,
            });
        }
        for ((row, column), &weight) in own.weights().indexed_iter() {
            let whole = |bits: &i32| (weight * 2f64.powi(*bits)).fract() == 0.0;
            let bits = (0..=FRACTION).find(whole);
            let Some(bits) = bits.filter(|_| weight.abs() <= LARGEST) else {
                return Err(CompileError::NotDyadic {
                    kernel: format!("kernel {kernel}"),
                    row,
                    column,
                    weight,
                });
            };
            fraction = fraction.max(bits);
        }
    }
    let form = |kernel: &Kernel| {
        let (rows, columns) = kernel.reach();
        let tap = |((y, x), weight): ((usize, usize), &f64)| Tap {
            y: y as i16 - rows as i16,
            x: x as i16 - columns as i16,
            weight: (weight * 2f64.powi(fraction)) as i64,
        };
        LinearForm::new(kernel.weights().indexed_iter().map(tap).collect())
    };
    Ok((kernels.iter().map(form).collect(), 1 << fraction))
}
