//! The light of a frame, held as its samples are.
//!
//! Video has one or two bytes a sample. They stay as they are, beside a table of the light that
//! each code stands for: range, scale and transfer change the table and no pixel, and a sensor
//! reads its signals from a table of its own. Whoever wants numbers has them: an image is a plane
//! of f64 too, which is made when it is first looked at.

use std::{
    ops::{Deref, DerefMut},
    sync::{Arc, OnceLock},
};

use crate::plane::{Plane, Size};

/// The light of a frame, `[y, x]`: codes of 8 or 16 bits and what they stand for, or numbers.
///
/// It can be used as the plane of its numbers.
pub struct Image {
    coded: Option<Coded>,
    /// Set from the start where there are no codes.
    plane: OnceLock<Plane<f64>>,
}

/// The pixels of an image as codes.
#[derive(Clone, Debug)]
pub struct Coded {
    size: Size,
    codes: Codes,
    levels: Levels,
}

/// Codes, row by row; copies share them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Codes {
    /// Of 8 bits.
    Bytes(Arc<Vec<u8>>),
    /// Of up to 16 bits.
    Words(Arc<Vec<u16>>),
}

impl Codes {
    /// The mean size of the change from these to others; infinite where they are of another kind or
    /// number.
    pub(in crate::scene) fn mean_change(&self, others: &Self) -> f64 {
        fn mean<T: Copy>(a: &[T], b: &[T], apart: fn(T, T) -> u64) -> f64 {
            let each = a.iter().zip(b);
            let sum: u64 = each.map(|(a, b)| apart(*a, *b)).sum();
            sum as f64 / a.len().max(1) as f64
        }
        match (self, others) {
            (Self::Bytes(a), Self::Bytes(b)) if a.len() == b.len() => {
                mean(a, b, |a, b| a.abs_diff(b).into())
            }
            (Self::Words(a), Self::Words(b)) if a.len() == b.len() => {
                mean(a, b, |a, b| a.abs_diff(b).into())
            }
            _ => f64::INFINITY,
        }
    }
}

/// The light of each code, from 0 on: of 256, or of 65,536. Copies share them.
#[derive(Clone, Debug)]
pub struct Levels {
    light: Arc<[f64]>,
    /// Whether a higher code is never less light.
    rise: bool,
    /// Whether it is the code itself, of 8 bits.
    are_codes: bool,
}

impl Levels {
    /// Codes of 8 bits that are light.
    #[must_use]
    pub fn bytes() -> Self {
        static BYTES: OnceLock<Levels> = OnceLock::new();
        let new = || Self::new((0..=u8::MAX).map(f64::from));
        BYTES.get_or_init(new).clone()
    }

    /// Codes of 16 bits that are light.
    #[must_use]
    pub fn words() -> Self {
        static WORDS: OnceLock<Levels> = OnceLock::new();
        WORDS.get_or_init(|| Self::of_words(f64::from)).clone()
    }

    /// Codes of up to 16 bits that stand for this light.
    pub fn of_words(light: impl Fn(u16) -> f64) -> Self {
        Self::new((0..=u16::MAX).map(light))
    }

    /// Codes of so many bits, 1 to 16, from 0 to the largest, that are light from 0 to 255.
    ///
    /// # Panics
    /// When there are no bits, or more than 16: codes have no more.
    #[must_use]
    pub fn of_bits(bits: u32) -> Self {
        assert!(
            (1..=u16::BITS).contains(&bits),
            "codes of {bits} bits, and they have 1 to 16"
        );
        if bits == 8 {
            return Self::bytes();
        }
        let most = f64::from((1_u32 << bits) - 1);
        Self::of_words(|code| f64::from(code) * 255.0 / most)
    }

    fn new(light: impl Iterator<Item = f64>) -> Self {
        let light: Arc<[f64]> = light.collect();
        let codes = (0..=u8::MAX).map(|code| f64::from(code).to_bits());
        Self {
            rise: light.windows(2).all(|pair| pair[0] <= pair[1]),
            are_codes: light.iter().map(|light| light.to_bits()).eq(codes),
            light,
        }
    }

    /// The same codes, of which each stands for what is made of its light.
    #[must_use]
    pub fn map(&self, light: impl Fn(f64) -> f64) -> Self {
        Self::new(self.light.iter().map(|level| light(*level)))
    }

    /// The light of each code.
    #[must_use]
    pub fn light(&self) -> &[f64] {
        &self.light
    }

    /// Whether codes of 8 bits are the light themselves.
    #[must_use]
    pub const fn are_codes(&self) -> bool {
        self.are_codes
    }

    /// Whether these are copies of each other; equal ones need not be.
    #[must_use]
    pub fn same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.light, &other.light)
    }

    fn of(&self, code: usize) -> f64 {
        self.light.get(code).copied().unwrap_or(0.0)
    }
}

impl Coded {
    /// Height and width.
    #[must_use]
    pub const fn size(&self) -> Size {
        self.size
    }

    /// The codes.
    #[must_use]
    pub const fn codes(&self) -> &Codes {
        &self.codes
    }

    /// What they stand for.
    #[must_use]
    pub const fn levels(&self) -> &Levels {
        &self.levels
    }

    /// The lowest and the highest code; none of no pixels.
    fn extent(&self) -> Option<(usize, usize)> {
        fn ends<T: Copy + Ord + Into<usize>>(codes: &[T]) -> Option<(usize, usize)> {
            let first = *codes.first()?;
            let ends = codes.iter().fold((first, first), |(low, high), code| {
                (low.min(*code), high.max(*code))
            });
            Some((ends.0.into(), ends.1.into()))
        }
        match &self.codes {
            Codes::Bytes(codes) => ends(codes),
            Codes::Words(codes) => ends(codes),
        }
    }

    fn plane(&self) -> Plane<f64> {
        let light = match &self.codes {
            Codes::Bytes(codes) => codes.iter().map(|c| self.levels.of((*c).into())).collect(),
            Codes::Words(codes) => codes.iter().map(|c| self.levels.of((*c).into())).collect(),
        };
        Plane::from_shape_vec(self.size.shape(), light).expect("a code for each pixel")
    }
}

impl Image {
    /// Codes of 8 bits, row by row; none where they are not as many as pixels, or levels are not
    /// as many as codes.
    #[must_use]
    pub fn of_bytes(size: Size, codes: Vec<u8>, levels: Levels) -> Option<Self> {
        Self::of_shared_bytes(size, codes.into(), levels)
    }

    /// The same, of codes that others have too.
    #[must_use]
    pub fn of_shared_bytes(size: Size, codes: Arc<Vec<u8>>, levels: Levels) -> Option<Self> {
        let fits = codes.len() == size.pixels() && levels.light.len() == 1 << 8;
        fits.then(|| Self::coded_as(size, Codes::Bytes(codes), levels))
    }

    /// Codes of up to 16 bits, row by row; none as above.
    #[must_use]
    pub fn of_words(size: Size, codes: Vec<u16>, levels: Levels) -> Option<Self> {
        let fits = codes.len() == size.pixels() && levels.light.len() == 1 << 16;
        fits.then(|| Self::coded_as(size, Codes::Words(codes.into()), levels))
    }

    const fn coded_as(size: Size, codes: Codes, levels: Levels) -> Self {
        let coded = Coded {
            size,
            codes,
            levels,
        };
        Self {
            coded: Some(coded),
            plane: OnceLock::new(),
        }
    }

    /// The pixels as codes, where they are held so.
    #[must_use]
    pub const fn coded(&self) -> Option<&Coded> {
        self.coded.as_ref()
    }

    /// The same pixels under other levels, which must be as many; none where it holds numbers.
    #[must_use]
    pub fn under(&self, levels: &Levels) -> Option<Self> {
        let Coded { size, codes, .. } = self.coded.as_ref()?;
        Some(Self::coded_as(*size, codes.clone(), levels.clone()))
    }

    /// Height and width.
    #[must_use]
    pub fn size(&self) -> Size {
        self.coded
            .as_ref()
            .map_or_else(|| Size::of(self), Coded::size)
    }

    /// The light of the pixel of this number, counted row by row; dark where there is none.
    #[must_use]
    pub fn at(&self, pixel: usize) -> f64 {
        let Some(Coded { codes, levels, .. }) = &self.coded else {
            let width = self.ncols().max(1);
            let light = self.get((pixel / width, pixel % width));
            return light.copied().unwrap_or(0.0);
        };
        let code = match codes {
            Codes::Bytes(codes) => codes.get(pixel).copied().map(usize::from),
            Codes::Words(codes) => codes.get(pixel).copied().map(usize::from),
        };
        code.map_or(0.0, |code| levels.of(code))
    }

    /// The least and the most light; what is not a number is neither. None of no pixels, and where
    /// none is a number.
    #[must_use]
    pub fn extent(&self) -> Option<(f64, f64)> {
        let coded = self.coded.as_ref().filter(|coded| coded.levels.rise);
        let (low, high) = match coded {
            Some(coded) => {
                let (low, high) = coded.extent()?;
                (coded.levels.of(low), coded.levels.of(high))
            }
            None => match self.as_slice() {
                Some(light) => extent(light),
                None => extent(&self.iter().copied().collect::<Vec<_>>()),
            },
        };
        (low <= high).then_some((low, high))
    }

    /// Its numbers.
    #[must_use]
    pub fn into_plane(mut self) -> Plane<f64> {
        let made = self.plane.take();
        let make = || {
            let none = || Plane::zeros((0, 0));
            self.coded.as_ref().map_or_else(none, Coded::plane)
        };
        made.unwrap_or_else(make)
    }
}

/// The least and the most light, several pixels at a time; what is not a number is neither.
fn extent(light: &[f64]) -> (f64, f64) {
    const LANES: usize = 8;
    let (mut least, mut most) = ([f64::INFINITY; LANES], [f64::NEG_INFINITY; LANES]);
    let (blocks, rest) = light.as_chunks::<LANES>();
    let mut look = |lane: usize, light: f64| {
        least[lane] = if light < least[lane] {
            light
        } else {
            least[lane]
        };
        most[lane] = if light > most[lane] {
            light
        } else {
            most[lane]
        };
    };
    for block in blocks {
        for (lane, light) in block.iter().enumerate() {
            look(lane, *light);
        }
    }
    for light in rest {
        look(0, *light);
    }
    (
        least.into_iter().fold(f64::INFINITY, f64::min),
        most.into_iter().fold(f64::NEG_INFINITY, f64::max),
    )
}

impl From<Plane<f64>> for Image {
    fn from(plane: Plane<f64>) -> Self {
        Self {
            coded: None,
            plane: OnceLock::from(plane),
        }
    }
}

impl Deref for Image {
    type Target = Plane<f64>;

    fn deref(&self) -> &Plane<f64> {
        let make = || {
            let none = || Plane::zeros((0, 0));
            self.coded.as_ref().map_or_else(none, Coded::plane)
        };
        self.plane.get_or_init(make)
    }
}

/// Who changes numbers has numbers alone: the codes are then gone.
impl DerefMut for Image {
    fn deref_mut(&mut self) -> &mut Plane<f64> {
        if self.coded.is_some() {
            let image = std::mem::replace(self, Plane::zeros((0, 0)).into());
            *self = image.into_plane().into();
        }
        self.plane.get_mut().expect("the numbers, without codes")
    }
}

/// Codes are shared, and the numbers that were made of them left behind.
impl Clone for Image {
    fn clone(&self) -> Self {
        match &self.coded {
            Some(coded) => Self {
                coded: Some(coded.clone()),
                plane: OnceLock::new(),
            },
            None => (**self).clone().into(),
        }
    }
}

/// The numbers are compared, however they are held.
impl PartialEq for Image {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl PartialEq<Plane<f64>> for Image {
    fn eq(&self, other: &Plane<f64>) -> bool {
        **self == *other
    }
}

impl std::fmt::Debug for Image {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        (**self).fmt(f)
    }
}

impl<'a> IntoIterator for &'a Image {
    type Item = &'a f64;
    type IntoIter = ndarray::iter::Iter<'a, f64, ndarray::Ix2>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn bits(plane: &Plane<f64>) -> Vec<u64> {
        plane.iter().map(|light| light.to_bits()).collect()
    }

    #[test]
    fn codes_have_one_to_sixteen_bits() {
        assert_eq!(Levels::of_bits(1).light()[..2], [0.0, 255.0]);
        assert_eq!(Levels::of_bits(16).light()[65535], 255.0);
        for bits in [0, 17, 32] {
            assert!(std::panic::catch_unwind(|| Levels::of_bits(bits)).is_err());
        }
    }

    proptest! {
        /// Whatever is asked of codes is what is asked of their numbers.
        #[test]
        fn codes_are_their_numbers(
            codes in proptest::collection::vec(any::<u16>(), 1..40),
            by in prop_oneof![Just(1.0), Just(0.0), -2.0f64..2.0],
            wide: bool,
            broken: bool,
        ) {
            let size = Size::new(1, codes.len());
            let level = |light: f64| if broken && light == 7.0 { -1e3 } else { light * by };
            let image = if wide {
                Image::of_words(size, codes, Levels::words().map(level))
            } else {
                let codes = codes.iter().map(|code| *code as u8).collect();
                Image::of_bytes(size, codes, Levels::bytes().map(level))
            }
            .unwrap();
            let mut numbers = Image::from(image.clone().into_plane());
            prop_assert_eq!(bits(&image), bits(&numbers));
            prop_assert_eq!(image.extent(), numbers.extent());
            prop_assert_eq!(image.size(), numbers.size());
            for pixel in 0..=size.width {
                prop_assert_eq!(image.at(pixel), numbers.at(pixel));
            }
            let mut changed = image.clone();
            *changed += 1.0;
            *numbers += 1.0;
            prop_assert!(changed.coded().is_none() && changed == numbers && changed != image);
        }
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let size = Size::new(2, 2);
        assert!(Image::of_bytes(size, vec![0; 3], Levels::bytes()).is_none());
        assert!(Image::of_words(size, vec![0; 4], Levels::bytes()).is_none());
        let image = Image::of_bytes(size, vec![3, 9, 0, 255], Levels::bytes()).unwrap();
        assert!(image.coded().unwrap().levels().are_codes());
        assert_eq!(
            image
                .under(&Levels::bytes().map(|l| 2.0 * l))
                .unwrap()
                .at(1),
            18.0
        );
    }

    #[test]
    fn what_is_not_a_number_is_no_end() {
        let of =
            |light: Vec<f64>| Image::from(Plane::from_shape_vec((1, light.len()), light).unwrap());
        assert_eq!(of(vec![f64::NAN; 20]).extent(), None);
        assert_eq!(of(vec![]).extent(), None);
        assert_eq!(of(vec![f64::NAN, 3.0, -1.0]).extent(), Some((-1.0, 3.0)));
    }
}
