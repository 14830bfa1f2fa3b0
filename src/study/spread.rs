//! What lies between a tenth and nine tenths of some values.

/// What lies between 10 and 90 % of some values.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Spread {
    /// A tenth of them is less.
    pub p10: f64,
    /// Half of them.
    pub median: f64,
    /// A tenth of them is more.
    pub p90: f64,
}

impl Spread {
    /// Of some values, by straight lines between those that were found; none of none.
    #[must_use]
    pub fn new(values: &[f64]) -> Option<Self> {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let last = sorted.len().checked_sub(1)?;
        let at = |share: f64| {
            let place = share * last as f64;
            let (below, way) = (place.floor() as usize, place.fract());
            let above = sorted[(below + 1).min(last)];
            sorted[below] + way * (above - sorted[below])
        };
        Some(Self {
            p10: at(0.1),
            median: at(0.5),
            p90: at(0.9),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spreads_lie_between_the_values() {
        let values: Vec<f64> = (0..=10).rev().map(f64::from).collect();
        let spread = Spread::new(&values).unwrap();
        assert_eq!((spread.p10, spread.median, spread.p90), (1.0, 5.0, 9.0));
        let one = Spread::new(&[3.0]).unwrap();
        assert_eq!((one.p10, one.p90), (3.0, 3.0));
        let two = Spread::new(&[0.0, 1.0]).unwrap();
        assert!((two.p10 - 0.1).abs() < 1e-12 && (two.p90 - 0.9).abs() < 1e-12);
        assert!(Spread::new(&[]).is_none());
    }
}
