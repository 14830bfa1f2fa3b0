//! Voxels of windows in one range, however many events they hold.

use std::str::FromStr;

use super::error::{TensorError, named};

/// What a kind's voxels of one window are brought to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Normalise {
    /// Left in events.
    #[default]
    None,
    /// Those that are not 0 have a mean of 0 and a standard deviation of 1, as E2VID takes them
    /// (Rebecq et al., TPAMI 2019); where all are equal, or there is one, only the mean is taken
    /// away, so that they become 0.
    Deviation,
    /// The largest in size is 1.
    Largest,
}

const NAMES: [(&str, Normalise); 3] = [
    ("none", Normalise::None),
    ("std", Normalise::Deviation),
    ("max", Normalise::Largest),
];

impl FromStr for Normalise {
    type Err = TensorError;

    fn from_str(text: &str) -> Result<Self, TensorError> {
        named(&NAMES, "way to normalise", text)
    }
}

impl Normalise {
    /// Normalises the voxels of one kind.
    pub fn apply(self, voxels: &mut [f32]) {
        match self {
            Self::None => {}
            Self::Deviation => deviation(voxels),
            Self::Largest => {
                let largest = voxels.iter().fold(0.0f32, |most, v| most.max(v.abs()));
                if largest > 0.0 {
                    for v in voxels {
                        *v /= largest;
                    }
                }
            }
        }
    }
}

fn deviation(voxels: &mut [f32]) {
    let (mut count, mut sum) = (0u64, 0.0);
    for v in voxels.iter().filter(|v| **v != 0.0) {
        count += 1;
        sum += f64::from(*v);
    }
    if count == 0 {
        return;
    }
    let mean = sum / count as f64;
    let there = voxels.iter().filter(|v| **v != 0.0);
    let squares: f64 = there.map(|v| (f64::from(*v) - mean).powi(2)).sum();
    let deviation = (squares / count as f64).sqrt();
    let per = if deviation > 0.0 {
        1.0 / deviation
    } else {
        1.0
    };
    for v in voxels.iter_mut().filter(|v| **v != 0.0) {
        *v = ((f64::from(*v) - mean) * per) as f32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_zero_is_brought_to_one_range() {
        let mut voxels = [0.0, 1.0, 3.0, 0.0, 5.0];
        Normalise::Deviation.apply(&mut voxels);
        let s = (8.0f32 / 3.0).sqrt();
        let want = [0.0, -2.0 / s, 0.0, 0.0, 2.0 / s];
        assert!(
            voxels.iter().zip(want).all(|(a, b)| (a - b).abs() < 1e-6),
            "{voxels:?}"
        );
        let mut alike = [2.0, 0.0, 2.0];
        Normalise::Deviation.apply(&mut alike);
        assert_eq!(alike, [0.0; 3]);
        let mut voxels = [0.0, -4.0, 2.0];
        Normalise::Largest.apply(&mut voxels);
        assert_eq!(voxels, [0.0, -1.0, 0.5]);
        let mut none = [0.0; 3];
        for how in [Normalise::None, Normalise::Deviation, Normalise::Largest] {
            how.apply(&mut none);
            assert_eq!(none, [0.0; 3]);
        }
    }
}
