//! Feature maps: planes with a rim of zeros, so that a convolution is one loop over all pixels.
//!
//! A row of `width` pixels is followed by one zero, which is the rim to its right and to the left of
//! the next row; a row of zeros lies above and below. The neighbour at (dy, dx) of the value at `p` is
//! then at `p + dy (width + 1) + dx`, at every place. What a loop over all of them writes to the rim
//! is multiplied by 0 ([`Shape::mask`]).
//!
//! Maps hold some pictures, one below the other with a row of zeros between: a loop goes over all of
//! them, and is long where pictures are small.

use std::sync::{Arc, Mutex, PoisonError};

use amacrine::{gradient::Float, plane::Size};

/// Values that are worked on together.
pub(super) const BLOCK: usize = 16;

/// The places of a map's values.
#[derive(Clone, Debug)]
pub struct Shape<R> {
    size: Size,
    pictures: usize,
    mask: Vec<R>,
    spare: Spare<R>,
}

/// Values of maps that are no longer needed, to be written over: a step would otherwise spend a fifth
/// of its time on fresh pages of memory. Their rims are 0.
type Spare<R> = Arc<Mutex<Vec<Vec<R>>>>;

impl<R: Float> Shape<R> {
    /// Maps of so many pictures of this size.
    #[must_use]
    pub fn new(size: Size, pictures: usize) -> Self {
        let stride = size.width + 1;
        let each = (size.height + 1) * stride;
        let mut mask = vec![R::ZERO; (pictures * each).next_multiple_of(BLOCK)];
        for picture in mask.chunks_mut(each).take(pictures) {
            for row in picture.chunks_mut(stride).take(size.height) {
                row[..size.width].fill(R::ONE);
            }
        }
        Self {
            size,
            pictures,
            mask,
            spare: Spare::default(),
        }
    }

    /// How many pictures.
    #[must_use]
    pub const fn pictures(&self) -> usize {
        self.pictures
    }

    /// Rows and columns of a picture.
    #[must_use]
    pub const fn size(&self) -> Size {
        self.size
    }

    /// From a row to the next.
    pub(super) const fn stride(&self) -> usize {
        self.size.width + 1
    }

    /// Where the first pixel is.
    pub(super) const fn start(&self) -> usize {
        self.size.width + 2
    }

    /// 1 at each pixel from the first on, 0 between rows and after the last: a whole number of blocks.
    pub(super) fn mask(&self) -> &[R] {
        &self.mask
    }

    /// Values of one map, its rim included.
    pub(super) fn plane(&self) -> usize {
        self.start() + self.mask.len() + self.stride() + 1
    }

    /// Where row `y` of a picture begins.
    const fn row(&self, picture: usize, y: usize) -> usize {
        self.start() + (picture * (self.size.height + 1) + y) * self.stride()
    }
}

/// Maps of some pictures of one size, one for each channel; the rim is 0.
#[derive(Debug)]
pub struct Maps<R> {
    channels: usize,
    plane: usize,
    values: Vec<R>,
    spare: Spare<R>,
}

impl<R> Drop for Maps<R> {
    fn drop(&mut self) {
        let values = std::mem::take(&mut self.values);
        let mut spare = self.spare.lock().unwrap_or_else(PoisonError::into_inner);
        spare.push(values);
    }
}

impl<R: Clone> Clone for Maps<R> {
    fn clone(&self) -> Self {
        Self {
            channels: self.channels,
            plane: self.plane,
            values: self.values.clone(),
            spare: Arc::clone(&self.spare),
        }
    }
}

impl<R: Float> Maps<R> {
    /// Maps of zeros.
    #[must_use]
    pub fn zeros(shape: &Shape<R>, channels: usize) -> Self {
        let mut maps = Self::unwritten(shape, channels);
        maps.values.fill(R::ZERO);
        maps
    }

    /// Maps to be written over: only the rim is sure to be 0.
    pub(super) fn unwritten(shape: &Shape<R>, channels: usize) -> Self {
        let plane = shape.plane();
        let mut values = {
            let mut spare = shape.spare.lock().unwrap_or_else(PoisonError::into_inner);
            // The smallest that is large enough, else the largest.
            let places = spare.iter().enumerate();
            let fit = places.min_by_key(|(_, values)| {
                let size = values.capacity();
                let short = size < channels * plane;
                (short, if short { usize::MAX - size } else { size })
            });
            fit.map(|(n, _)| n)
                .map_or_else(Vec::new, |n| spare.swap_remove(n))
        };
        values.resize(channels * plane, R::ZERO);
        Self {
            channels,
            plane,
            values,
            spare: Arc::clone(&shape.spare),
        }
    }

    /// How many maps.
    #[must_use]
    pub const fn channels(&self) -> usize {
        self.channels
    }

    pub(super) fn map(&self, channel: usize) -> &[R] {
        &self.values[channel * self.plane..][..self.plane]
    }

    pub(super) fn map_mut(&mut self, channel: usize) -> &mut [R] {
        &mut self.values[channel * self.plane..][..self.plane]
    }

    /// All values, map after map.
    pub(super) fn values(&self) -> &[R] {
        &self.values
    }

    pub(super) fn values_mut(&mut self) -> &mut [R] {
        &mut self.values
    }

    /// Row `y` of a picture in a map.
    #[must_use]
    pub fn row(&self, shape: &Shape<R>, (picture, channel): (usize, usize), y: usize) -> &[R] {
        &self.map(channel)[shape.row(picture, y)..][..shape.size().width]
    }

    /// Row `y` of a picture in a map.
    pub fn row_mut(
        &mut self,
        shape: &Shape<R>,
        (picture, channel): (usize, usize),
        y: usize,
    ) -> &mut [R] {
        &mut self.map_mut(channel)[shape.row(picture, y)..][..shape.size().width]
    }

    /// These maps and, after them, those of `other`.
    pub(super) fn joined(&self, shape: &Shape<R>, other: &Self) -> Self {
        let mut both = Self::unwritten(shape, self.channels + other.channels);
        let (first, second) = both.values.split_at_mut(self.values.len());
        first.copy_from_slice(&self.values);
        second.copy_from_slice(&other.values);
        both
    }

    /// The first `channels` maps, and the others.
    pub(super) fn parted(&self, shape: &Shape<R>, channels: usize) -> (Self, Self) {
        let mut first = Self::unwritten(shape, channels);
        let mut second = Self::unwritten(shape, self.channels - channels);
        let (a, b) = self.values.split_at(channels * self.plane);
        first.values.copy_from_slice(a);
        second.values.copy_from_slice(b);
        (first, second)
    }

    /// Adds other maps.
    pub(super) fn add(&mut self, other: &Self) {
        for (value, other) in self.values.iter_mut().zip(&other.values) {
            *value = *value + *other;
        }
    }
}
