//! Whether a pixel memory that is stepped by filtered thresholds is stable. Events move the pixels'
//! memory by the filtered difference, which moves that difference by the kernel's response to it:
//! in a frame, a pattern of spatial frequency f is multiplied by 1 - W(f). Above 1 in magnitude it
//! grows.

use crate::{elementary, kernel::Kernel};

/// How much a pixel memory stepped by filtered thresholds may grow in a frame. 1 would be
/// stable for ever; the kernels that the released simulator's reference outputs were made with
/// reach 1.13.
pub(super) const MOST_GROWTH: f64 = 1.25;

/// The largest |1 - W(f)| of a kernel, over a grid of spatial frequencies.
pub(super) fn growth(kernel: &Kernel) -> f64 {
    const GRID: usize = 32;
    let (reach_y, reach_x) = kernel.reach();
    let angle = |i: usize| std::f64::consts::TAU * i as f64 / GRID as f64;
    let at = |fy: f64, fx: f64| {
        let (mut re, mut im) = (1.0, 0.0);
        for ((y, x), weight) in kernel.weights().indexed_iter() {
            let phase = fy * (y as f64 - reach_y as f64) + fx * (x as f64 - reach_x as f64);
            re -= weight * elementary::cos(phase);
            im -= weight * elementary::sin(phase);
        }
        elementary::hypot(re, im)
    };
    (0..GRID * GRID)
        .map(|i| at(angle(i / GRID), angle(i % GRID)))
        .fold(0.0, f64::max)
}
