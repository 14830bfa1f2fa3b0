//! The drive: the correlation of the signal with the kernel.
//!
//! ```text
//! S(p) = sum over d of W(d) u(p + d)          u = R(I), the photoreceptor's signal
//! ```
//!
//! A correlation, as in the paper (So & Wetzstein, arXiv 2504.13457, Eq. 2) and in the
//! released code (`Conv2d`). What lies off the array is the nearest pixel (`replicate`) or
//! zero; zero is put in after the response, so that it means "no signal", not "no light".
//!
//! The sum is taken in the order of the kernel's rows, without fused multiply-add, so that
//! every machine gives the same bits. A block of pixels is summed at a time, so that the sums
//! stay in registers: one multiplication, one addition and one load for each weight and pixel.
//! In f32 and f64, where rows of a kernel are equal, pixels below each other are added before they
//! are multiplied: of the five rows of a centre and its surround two products remain. In narrower
//! formats such a sum could overflow. Where no rows are equal, two rows of sums are computed at a
//! time, so that a pixel that both need is loaded once.
//!
//! Where a product takes many instructions, as in all formats but f32 and f64, and a kernel has few
//! different weights, each pixel is multiplied once by each different weight, and a sum is
//! additions alone: the same products in the same order.

mod exact;
mod line;
mod product;
mod weights;
mod width;

pub(crate) use self::exact::{Exact, differences, held, largest};
pub(crate) use self::weights::{Made, Parts, Weights, log_temporal};
