//! Sums of shares of events, exact: whole numbers of parts.
//!
//! An event in a window of `length` microseconds gives a bin so many `length`-ths of itself. Added
//! up as floating point, shares that cancel leave a residue, and a voxel that is 0 looks as if it
//! were not.

/// What events have given to each voxel of a window, in parts of an event.
#[derive(Clone, Debug)]
pub(super) enum Sums {
    /// As long as every sum fits.
    Narrow(Vec<i32>),
    /// From the first sum on that does not.
    Wide(Vec<i64>),
}

impl Sums {
    /// So many sums of 0.
    pub fn new(voxels: usize) -> Self {
        Self::Narrow(vec![0; voxels])
    }

    /// Adds so many parts to a voxel, fewer than 2^33; where there is no such voxel, to none.
    #[inline]
    pub fn add(&mut self, voxel: usize, parts: i64) {
        if let Self::Narrow(sums) = self {
            let Some(sum) = sums.get_mut(voxel) else {
                return;
            };
            if let Ok(parts) = i32::try_from(parts)
                && let Some(more) = sum.checked_add(parts)
            {
                *sum = more;
                return;
            }
        }
        self.add_wide(voxel, parts);
    }

    /// The same, in wide sums.
    #[cold]
    fn add_wide(&mut self, voxel: usize, parts: i64) {
        if let Self::Narrow(sums) = self {
            *self = Self::Wide(sums.iter().copied().map(i64::from).collect());
        }
        if let Self::Wide(sums) = self
            && let Some(sum) = sums.get_mut(voxel)
        {
            *sum = sum.saturating_add(parts);
        }
    }

    /// The sums in events of so many parts.
    pub fn into_events(self, parts: i64) -> Vec<f32> {
        let each = 1.0 / parts as f64;
        match self {
            // In place.
            Self::Narrow(sums) => { sums.into_iter() }
                .map(|sum| (f64::from(sum) * each) as f32)
                .collect(),
            Self::Wide(sums) => { sums.iter() }
                .map(|sum| (*sum as f64 * each) as f32)
                .collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sums that leave 32 bits go on, and those beside them stay.
    #[test]
    fn sums_grow() {
        let mut sums = Sums::new(3);
        for (parts, times) in [(12_500, 200_000), (-1, 7), (1 << 32, 3)] {
            for _ in 0..times {
                sums.add(1, parts);
            }
            sums.add(2, parts);
            sums.add(3, parts);
        }
        let wanted: i64 = 12_500 * 200_000 - 7 + (3 << 32);
        let beside = 12_499 + (1_i64 << 32);
        assert!(matches!(&sums, Sums::Wide(sums) if *sums == [0, wanted, beside]));
        let events = sums.into_events(12_500);
        assert_eq!(events[1], (wanted as f64 / 12_500.0) as f32);
    }
}
