//! Pearson's correlation of two lists of whole numbers, `cov(a, b) / sqrt(var(a) var(b))`.
//!
//! The sums are whole numbers, so that equal lists give exactly 1.

/// The sums that the correlation is made of.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pearson {
    a: i128,
    b: i128,
    aa: i128,
    bb: i128,
    ab: i128,
}

impl Pearson {
    /// Takes one pair of numbers in.
    pub(super) const fn add(&mut self, a: i128, b: i128) {
        self.a += a;
        self.b += b;
        self.aa += a * a;
        self.bb += b * b;
        self.ab += a * b;
    }

    /// Both lists, one after the other.
    pub(super) const fn join(self, other: Self) -> Self {
        Self {
            a: self.a + other.a,
            b: self.b + other.b,
            aa: self.aa + other.aa,
            bb: self.bb + other.bb,
            ab: self.ab + other.ab,
        }
    }

    /// The correlation over `n` pairs, those that were not added being (0, 0). None when
    /// either list does not vary, or where 128 bits do not hold the sums.
    pub(super) fn over(self, n: Option<i128>) -> Option<f64> {
        let moment = |xy: i128, x: i128, y: i128| {
            let product = n?.checked_mul(xy)?.checked_sub(x.checked_mul(y)?)?;
            Some(product as f64)
        };
        let va = moment(self.aa, self.a, self.a)?;
        let vb = moment(self.bb, self.b, self.b)?;
        let cov = moment(self.ab, self.a, self.b)?;
        // In this order, equal counts give exactly 1.
        (va > 0.0 && vb > 0.0).then(|| cov / va * (va / vb).sqrt())
    }
}
