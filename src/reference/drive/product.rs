//! Products computed once: each pixel times each different weight of a kernel.

use multiversion::multiversion;

use crate::{number::Number, reference::signal::BLOCK};

use super::width::is_wide;

/// The different weights of a kernel that has few.
#[derive(Clone, Debug)]
pub(super) struct Shared<H> {
    /// Each different weight once.
    pub(super) weights: Vec<H>,
    /// Which weight stands where, row by row of the kernel.
    pub(super) places: Vec<Place>,
}

/// A place in a kernel, and which of the different weights stands there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Index into [`Shared::weights`].
    pub(super) weight: usize,
    /// Row and column of the kernel, from 0 on.
    pub(super) row: usize,
    pub(super) column: usize,
}

impl<H: Copy> Shared<H> {
    /// `None` where it does not pay: each different weight takes a plane of products.
    pub(super) fn new<N: Number<Held = H>>(number: &N, rows: &[Vec<H>]) -> Option<Self> {
        if is_wide(number) {
            return None;
        }
        let mut shared = Self {
            weights: Vec::new(),
            places: Vec::new(),
        };
        for (row, weights) in rows.iter().enumerate() {
            for (column, &held) in weights.iter().enumerate() {
                let bits = |held| number.value(held).to_bits();
                let known = shared.weights.iter().position(|w| bits(*w) == bits(held));
                let weight = known.unwrap_or(shared.weights.len());
                if known.is_none() {
                    shared.weights.push(held);
                }
                shared.places.push(Place {
                    weight,
                    row,
                    column,
                });
            }
        }
        (4 * shared.weights.len() <= shared.places.len()).then_some(shared)
    }
}

#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
pub(super) fn scale<N: Number>(
    number: &N,
    weight: N::Held,
    values: &[N::Held],
    out: &mut [N::Held],
) {
    for (out, &value) in out.iter_mut().zip(values) {
        *out = number.mul(weight, value);
    }
}

/// The sums of products at these places of `source`, for each pixel of a row.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
pub(super) fn add_up<N: Number>(
    number: &N,
    places: &[usize],
    source: &[N::Held],
    out: &mut [N::Held],
) {
    for (block, out) in out.chunks_mut(BLOCK).enumerate() {
        let mut sums = [N::ZERO; BLOCK];
        for &at in places {
            let start = at + block * BLOCK;
            let Some(source) = source.get(start..start + BLOCK) else {
                continue;
            };
            for (sum, &value) in sums.iter_mut().zip(source) {
                *sum = number.add(*sum, value);
            }
        }
        out.copy_from_slice(&sums[..out.len()]);
    }
}
