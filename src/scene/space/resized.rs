//! A scene seen by fewer, larger pixels.

use crate::{
    plane::{Plane, Size},
    scene::{Frame, Outline, Scene, SceneError},
};

/// A scene whose pixels are made larger: each has the mean of the light that falls on it, as a
/// photodiode of that pitch has.
#[derive(Debug)]
pub struct Resized<S> {
    source: S,
    size: Size,
    /// What falls on each row, and on each column.
    rows: Vec<Shares>,
    columns: Vec<Shares>,
}

/// Pixels of the source from one on, and the share of each in the mean.
type Shares = (usize, Vec<f64>);

impl<S: Scene> Resized<S> {
    /// `source` in this size.
    ///
    /// # Errors
    /// When it is larger than the source's in either direction.
    pub fn new(source: S, size: Size) -> Result<Self, SceneError> {
        let from = source.size();
        if size.height > from.height || size.width > from.width || !size.is_possible() {
            return Err(SceneError::Enlarged { size, from });
        }
        Ok(Self {
            rows: shares(from.height, size.height),
            columns: shares(from.width, size.width),
            source,
            size,
        })
    }

    fn resized(&self, light: &Plane<f64>) -> Plane<f64> {
        let mut wide = Plane::zeros((self.size.height, light.ncols()));
        for (mut row, (first, shares)) in wide.rows_mut().into_iter().zip(&self.rows) {
            for (k, share) in shares.iter().enumerate() {
                row.scaled_add(*share, &light.row(first + k));
            }
        }
        let at = |(y, x): (usize, usize)| {
            let (first, shares) = &self.columns[x];
            let light = shares.iter().enumerate();
            light.map(|(k, share)| share * wide[(y, first + k)]).sum()
        };
        Plane::from_shape_fn(self.size.shape(), at)
    }
}

/// How much of each of `from` pixels falls on each of `to`.
fn shares(from: usize, to: usize) -> Vec<Shares> {
    // In units of 1/to of a source's pixel, all ends are whole.
    let covered = |k: usize| {
        let (start, end) = (k * from, (k + 1) * from);
        let first = start / to;
        let pixels = first..end.div_ceil(to);
        let share = |pixel: usize| {
            let (left, right) = ((pixel * to).max(start), ((pixel + 1) * to).min(end));
            (right - left) as f64 / from as f64
        };
        (first, pixels.map(share).collect())
    };
    (0..to).map(covered).collect()
}

impl<S: Scene> Scene for Resized<S> {
    fn outline(&self) -> Outline {
        let source = self.source.outline();
        // The plane that is averaged, and that of a frame that is half done.
        let drawn = Outline::new(source.size, source.fps);
        Outline {
            size: self.size,
            bytes: source.bytes + 2 * drawn.bytes,
            ..source
        }
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError> {
        let frame = self.source.next_frame()?;
        Ok(frame.map(|frame| Frame {
            light: self.resized(&frame.light).into(),
            ..frame
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_those_of_areas() {
        assert_eq!(shares(4, 2), [(0, vec![0.5, 0.5]), (2, vec![0.5, 0.5])]);
        let third = [1.0 / 3.0, 2.0 / 3.0];
        let (first, second) = (vec![third[1], third[0]], third.to_vec());
        assert_eq!(shares(3, 2), [(0, first), (1, second)]);
        for (from, to) in [(7, 7), (720, 256), (101, 17), (65_536, 65_535)] {
            let all = shares(from, to);
            assert_eq!(all.len(), to);
            for (first, shares) in all {
                assert!(first + shares.len() <= from);
                assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-9);
            }
        }
    }
}
