//! The cosine transform of rows: the modes of a line of resistors with open ends.
//!
//! ```text
//! C[k] = sum over n of x[n] cos(π k (2n + 1) / 2N)          x[n] = (C[0] + 2 sum over k > 0 of …) / N
//! ```
//!
//! The DCT-II and its inverse, of two real rows at a time: they are the real and the imaginary
//! part of one complex row, reordered as Makhoul (IEEE Trans. ASSP 28(1):27-34, 1980) has it,
//! so that one Fourier transform of the row's own length does both.

use std::{fmt, sync::Arc};

use multiversion::multiversion;
use rustfft::{Fft, num_complex::Complex};

use super::Float;
use crate::elementary;

/// The transform of rows of one length, and its working memory.
#[derive(Clone)]
pub(super) struct Cosine<T: Float> {
    forward: Arc<dyn Fft<T>>,
    inverse: Arc<dyn Fft<T>>,
    /// `(cos, sin)(π k / 2N)`, for k up to N/2.
    twiddles: Vec<Complex<T>>,
    length: usize,
    /// Complex rows, [`Cosine::pitch`] apart.
    rows: Vec<Complex<T>>,
    scratch: Vec<Complex<T>>,
    /// In the place of a row or column that makes a pair with the last of an odd number.
    spare: Vec<T>,
}

/// Columns that are transformed at a time: one or two cache lines wide.
pub(super) const COLUMNS: usize = 16;

/// Written by hand, since a plan of `rustfft` has no `Debug`.
impl<T: Float> fmt::Debug for Cosine<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Cosine of {}", self.length)
    }
}

impl<T: Float> Cosine<T> {
    pub(super) fn new(length: usize) -> Self {
        let [forward, inverse] = T::transforms(length);
        let scratch = forward
            .get_inplace_scratch_len()
            .max(inverse.get_inplace_scratch_len());
        let zero = Complex::new(T::nearest(0.0), T::nearest(0.0));
        let twiddle = |k: usize| {
            let angle = std::f64::consts::FRAC_PI_2 * k as f64 / length as f64;
            Complex::new(
                T::nearest(elementary::cos(angle)),
                T::nearest(elementary::sin(angle)),
            )
        };
        Self {
            forward,
            inverse,
            twiddles: (0..=length / 2).map(twiddle).collect(),
            length,
            rows: vec![zero; COLUMNS / 2 * pitch(length)],
            scratch: vec![zero; scratch],
            spare: vec![T::nearest(0.0); length],
        }
    }

    /// How much longer transforms of this length take than their `N log N`: 0 where all prime
    /// factors have a form of their own, 1 where the others are one above a product of such
    /// (Rader's way), 2 elsewhere (Bluestein's).
    pub(super) fn burden(length: usize) -> u32 {
        let own = |mut n: usize| {
            for prime in [2, 3, 5, 7, 11] {
                while n > 1 && n.is_multiple_of(prime) {
                    n /= prime;
                }
            }
            n
        };
        let mut rest = own(length);
        let mut burden = 0;
        let mut prime = 13;
        while rest > 1 {
            if prime * prime > rest {
                prime = rest;
            }
            if rest.is_multiple_of(prime) {
                rest /= prime;
                burden = burden.max(if own(prime - 1) == 1 { 1 } else { 2 });
            } else {
                prime += 2;
            }
        }
        burden
    }

    /// The modes (DCT-II coefficients) of two rows, in place; `off` is subtracted from each value
    /// first.
    pub(super) fn forward(&mut self, a: &mut [T], b: &mut [T], off: T) {
        let row = &mut self.rows[..self.length];
        gather(a, b, off, row);
        self.forward.process_with_scratch(row, &mut self.scratch);
        part(row, &self.twiddles, a, b);
    }

    /// Two rows from their modes, in place: the inverse transform.
    pub(super) fn inverse(&mut self, a: &mut [T], b: &mut [T]) {
        let scale = T::nearest(1.0 / self.length as f64);
        let row = &mut self.rows[..self.length];
        join(a, b, &self.twiddles, scale, row);
        self.inverse.process_with_scratch(row, &mut self.scratch);
        scatter(row, a, b);
    }

    /// The modes of up to [`COLUMNS`] columns of a plane from column `x` on, one column after the
    /// other; the plane's rows are `width` long.
    pub(super) fn forward_columns(
        &mut self,
        (plane, width, x): (&[T], usize, usize),
        off: T,
        modes: &mut [T],
    ) {
        let (length, pitch) = (self.length, pitch(self.length));
        let columns = modes.len() / length;
        gather_columns((plane, width, x), columns, off, (&mut self.rows, length));
        let rows = self.rows.chunks_mut(pitch);
        for (row, pair) in rows.zip(modes.chunks_mut(2 * length)) {
            let row = &mut row[..length];
            self.forward.process_with_scratch(row, &mut self.scratch);
            let (a, b) = pair.split_at_mut(length);
            let b = if b.is_empty() { &mut self.spare } else { b };
            part(row, &self.twiddles, a, b);
        }
    }

    /// The inverse of [`Cosine::forward_columns`]; `shown` is applied to each value.
    pub(super) fn inverse_columns(
        &mut self,
        modes: &[T],
        (plane, width, x): (&mut [T], usize, usize),
        shown: impl Fn(T) -> T,
    ) {
        let (length, pitch) = (self.length, pitch(self.length));
        let scale = T::nearest(1.0 / length as f64);
        let columns = modes.len() / length;
        self.spare.fill(T::nearest(0.0));
        let rows = self.rows.chunks_mut(pitch);
        for (row, pair) in rows.zip(modes.chunks(2 * length)) {
            let row = &mut row[..length];
            let (a, b) = pair.split_at(length);
            let b = if b.is_empty() { &self.spare } else { b };
            join(a, b, &self.twiddles, scale, row);
            self.inverse.process_with_scratch(row, &mut self.scratch);
        }
        let to = (plane, width, x);
        scatter_columns((&self.rows, length), columns, to, shown);
    }
}

/// From one complex row to the next: rows that are a power of two apart fight for the same lines
/// of the cache.
const fn pitch(length: usize) -> usize {
    length + 4
}

/// The place of value `n` in Makhoul's order.
#[inline]
const fn place(n: usize, length: usize) -> usize {
    if n.is_multiple_of(2) {
        n / 2
    } else {
        length - 1 - n / 2
    }
}

/// Pairs of columns as complex rows in Makhoul's order.
fn gather_columns<T: Float>(
    (plane, width, x): (&[T], usize, usize),
    columns: usize,
    off: T,
    (rows, length): (&mut [Complex<T>], usize),
) {
    for (n, line) in plane.chunks_exact(width).enumerate() {
        let (pairs, last) = line[x..x + columns].as_chunks();
        let mut to = place(n, length);
        for &[a, b] in pairs {
            rows[to] = Complex::new(a - off, b - off);
            to += pitch(length);
        }
        if let [a] = last {
            rows[to] = Complex::new(*a - off, T::nearest(0.0));
        }
    }
}

/// The inverse of [`gather_columns`].
fn scatter_columns<T: Float>(
    (rows, length): (&[Complex<T>], usize),
    columns: usize,
    (plane, width, x): (&mut [T], usize, usize),
    shown: impl Fn(T) -> T,
) {
    for (n, line) in plane.chunks_exact_mut(width).enumerate() {
        let (pairs, last) = line[x..x + columns].as_chunks_mut();
        let mut from = place(n, length);
        for [a, b] in pairs {
            (*a, *b) = (shown(rows[from].re), shown(rows[from].im));
            from += pitch(length);
        }
        if let [a] = last {
            *a = shown(rows[from].re);
        }
    }
}

/// Two real rows as one complex row in Makhoul's order: even columns from the left, odd ones from
/// the right.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn gather<T: Float>(a: &[T], b: &[T], off: T, row: &mut [Complex<T>]) {
    let length = a.len();
    let (left, right) = row.split_at_mut(length.div_ceil(2));
    let pairs = a.chunks_exact(2).zip(b.chunks_exact(2));
    for ((left, right), (a, b)) in left.iter_mut().zip(right.iter_mut().rev()).zip(pairs) {
        *left = Complex::new(a[0] - off, b[0] - off);
        *right = Complex::new(a[1] - off, b[1] - off);
    }
    if length % 2 == 1
        && let (Some(left), Some(a), Some(b)) = (left.last_mut(), a.last(), b.last())
    {
        *left = Complex::new(*a - off, *b - off);
    }
}

/// The inverse of [`gather`]: two real rows from a complex row.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn scatter<T: Float>(row: &[Complex<T>], a: &mut [T], b: &mut [T]) {
    let length = a.len();
    let (left, right) = row.split_at(length.div_ceil(2));
    let pairs = a.chunks_exact_mut(2).zip(b.chunks_exact_mut(2));
    for ((left, right), (a, b)) in left.iter().zip(right.iter().rev()).zip(pairs) {
        (a[0], b[0]) = (left.re, left.im);
        (a[1], b[1]) = (right.re, right.im);
    }
    if length % 2 == 1
        && let (Some(left), Some(a), Some(b)) = (left.last(), a.last_mut(), b.last_mut())
    {
        (*a, *b) = (left.re, left.im);
    }
}

/// The modes of two rows from the spectrum of the complex row: those of `a` (the real part) are in
/// its Hermitian-symmetric half, those of `b` in the antisymmetric one.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn part<T: Float>(row: &[Complex<T>], twiddles: &[Complex<T>], a: &mut [T], b: &mut [T]) {
    let length = a.len();
    let (Some(first), Some((a0, a)), Some((b0, b))) =
        (row.first(), a.split_first_mut(), b.split_first_mut())
    else {
        return;
    };
    (*a0, *b0) = (first.re, first.im);
    // What is left has length - 1 places; place i is mode i + 1, its mirror image mode
    // length - 1 - i.
    let half = T::nearest(0.5);
    let pairs = (length - 1) / 2;
    let row = &row[1..];
    let (a, a_mirror) = a.split_at_mut(length / 2);
    let (b, b_mirror) = b.split_at_mut(length / 2);
    let modes = row
        .iter()
        .zip(row.iter().rev())
        .zip(&twiddles[1..])
        .take(pairs);
    let low = a.iter_mut().zip(b.iter_mut());
    let high = a_mirror.iter_mut().rev().zip(b_mirror.iter_mut().rev());
    for (((z, m), twiddle), ((a, b), (am, bm))) in modes.zip(low.zip(high)) {
        let (c, s) = (twiddle.re * half, twiddle.im * half);
        let (sum_re, dif_re) = (z.re + m.re, m.re - z.re);
        let (sum_im, dif_im) = (z.im + m.im, z.im - m.im);
        *a = c * sum_re + s * dif_im;
        *am = s * sum_re - c * dif_im;
        *b = c * sum_im + s * dif_re;
        *bm = s * sum_im - c * dif_re;
    }
    if length.is_multiple_of(2)
        && let (Some(z), Some(twiddle)) = (row.get(pairs), twiddles.last())
        && let (Some(a), Some(b)) = (a.get_mut(pairs), b.get_mut(pairs))
    {
        // This mode is its own mirror image.
        (*a, *b) = (z.re * twiddle.re, z.im * twiddle.re);
    }
}

/// The inverse of [`part`]: the spectrum of the complex row from the modes of both rows.
#[multiversion(targets("x86_64+avx2", "aarch64+neon"))]
fn join<T: Float>(a: &[T], b: &[T], twiddles: &[Complex<T>], scale: T, row: &mut [Complex<T>]) {
    let length = a.len();
    let (Some((first, row)), Some((a0, a)), Some((b0, b))) =
        (row.split_first_mut(), a.split_first(), b.split_first())
    else {
        return;
    };
    *first = Complex::new(*a0 * scale, *b0 * scale);
    let pairs = (length - 1) / 2;
    let (row, row_mirror) = row.split_at_mut(length / 2);
    let low = a.iter().zip(b).zip(&twiddles[1..]).take(pairs);
    let high = a.iter().rev().zip(b.iter().rev());
    let to = row.iter_mut().zip(row_mirror.iter_mut().rev());
    for ((((a, b), twiddle), (am, bm)), (z, m)) in low.zip(high).zip(to) {
        let (c, s) = (twiddle.re * scale, twiddle.im * scale);
        let (are, aim) = (c * *a + s * *am, s * *a - c * *am);
        let (bre, bim) = (c * *b + s * *bm, s * *b - c * *bm);
        *z = Complex::new(are - bim, aim + bre);
        *m = Complex::new(are + bim, bre - aim);
    }
    if length.is_multiple_of(2)
        && let (Some(z), Some(twiddle)) = (row.last_mut(), twiddles.last())
        && let (Some(a), Some(b)) = (a.get(pairs), b.get(pairs))
    {
        // V = (c + i s)(C - i C), with c = s.
        let both = (twiddle.re + twiddle.im) * scale;
        *z = Complex::new(*a * both, *b * both);
    }
}
