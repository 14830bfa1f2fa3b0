//! A scene read once and kept as small as it can be, to be looked at and shown again.

use std::sync::Arc;

use crate::{
    plane::{Plane, Size},
    scene::{Codes, Frame, Image, Levels, Outline, Scene, SceneError, checks},
};

/// A scene in memory: a byte a pixel where light is 0, 1, … 255, as in 8-bit video.
#[derive(Clone, Debug)]
pub struct Kept {
    frames: Arc<Vec<One>>,
    /// Of the scene that was read, with its frames and what they take; and of the one that is given.
    outline: Outline,
}

#[derive(Clone, Debug)]
struct One {
    index: u64,
    seconds: f64,
    pixels: Store,
}

#[derive(Clone, Debug)]
enum Store {
    Bytes(Arc<Vec<u8>>),
    Numbers(Plane<f64>),
}

/// The light of a frame, row by row.
#[derive(Clone, Copy, Debug)]
pub enum Pixels<'a> {
    /// Whole numbers from 0 to 255.
    Bytes(&'a [u8]),
    /// Any.
    Numbers(&'a [f64]),
}

impl Pixels<'_> {
    /// The light of the pixel of this number, counted row by row; dark where there is none.
    #[inline]
    #[must_use]
    pub fn at(self, pixel: usize) -> f64 {
        match self {
            Self::Bytes(bytes) => bytes.get(pixel).copied().map_or(0.0, f64::from),
            Self::Numbers(numbers) => numbers.get(pixel).copied().unwrap_or(0.0),
        }
    }
}

impl Store {
    fn new(light: Image) -> Self {
        if let Some(coded) = light.coded()
            && let (Codes::Bytes(codes), true) = (coded.codes(), coded.levels().are_codes())
        {
            return Self::Bytes(Arc::clone(codes));
        }
        let light = light.into_plane();
        // `as` saturates.
        let is_byte = |light: &f64| f64::from(*light as u8).to_bits() == light.to_bits();
        if light.iter().all(is_byte) {
            let codes: Vec<u8> = light.iter().map(|light| *light as u8).collect();
            Self::Bytes(codes.into())
        } else if light.is_standard_layout() {
            Self::Numbers(light)
        } else {
            Self::Numbers(light.as_standard_layout().into_owned())
        }
    }

    fn bytes(&self) -> usize {
        match self {
            Self::Bytes(bytes) => bytes.len(),
            Self::Numbers(numbers) => numbers.len() * size_of::<f64>(),
        }
    }

    fn into_image(self, size: Size) -> Image {
        match self {
            Self::Bytes(codes) => Image::of_shared_bytes(size, codes, Levels::bytes())
                .unwrap_or_else(|| Plane::zeros(size.shape()).into()),
            Self::Numbers(numbers) => numbers.into(),
        }
    }
}

impl Kept {
    /// Reads a scene to its end; none where it would take more than so many bytes, and its frames
    /// are then gone.
    ///
    /// # Errors
    /// When the scene cannot be read.
    pub fn new(scene: &mut dyn Scene, most: usize) -> Result<Option<Self>, SceneError> {
        let size = scene.size();
        let least = |frames: u64| u128::from(frames) * size.pixels() as u128 > most as u128;
        if scene.frames().is_some_and(least) {
            return Ok(None);
        }
        let (mut frames, mut bytes) = (Vec::new(), 0);
        while let Some(Frame {
            index,
            seconds,
            light,
        }) = scene.next_frame()?
        {
            let pixels = Store::new(light);
            bytes += pixels.bytes();
            // Frames are alike: the first says what all take.
            let all = scene.frames().filter(|_| index == 0).unwrap_or(1);
            let too_many = u128::from(all) * pixels.bytes() as u128 > most as u128;
            if bytes > most || too_many {
                return Ok(None);
            }
            frames.push(One {
                index,
                seconds,
                pixels,
            });
        }
        Ok(Some(Self {
            outline: Outline {
                frames: Some(frames.len() as u64),
                bytes: bytes as u128 + checks::PIXEL_BYTES * size.pixels() as u128,
                ..scene.outline()
            },
            frames: frames.into(),
        }))
    }

    /// Bytes of the light of all frames.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.frames.iter().map(|one| one.pixels.bytes()).sum()
    }

    /// How many frames.
    #[must_use]
    pub fn len(&self) -> usize {
        self.frames.len()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.frames.is_empty()
    }

    /// Size of every frame.
    #[must_use]
    pub const fn size(&self) -> Size {
        self.outline.size
    }

    /// The number of a frame in its scene, its time and its light.
    #[must_use]
    pub fn frame(&self, n: usize) -> Option<(u64, f64, Pixels<'_>)> {
        let One {
            index,
            seconds,
            pixels,
        } = self.frames.get(n)?;
        let pixels = match pixels {
            Store::Bytes(bytes) => Pixels::Bytes(bytes),
            Store::Numbers(numbers) => Pixels::Numbers(numbers.as_slice().unwrap_or_default()),
        };
        Some((*index, *seconds, pixels))
    }

    /// The light of a frame.
    #[must_use]
    pub fn image(&self, n: usize) -> Option<Image> {
        let one = self.frames.get(n)?;
        Some(one.pixels.clone().into_image(self.size()))
    }

    /// The light of a frame as numbers.
    #[must_use]
    pub fn plane(&self, n: usize) -> Option<Plane<f64>> {
        self.image(n).map(Image::into_plane)
    }

    /// The scene from its beginning; its frames are those that were read, to the bit.
    #[must_use]
    pub fn scene(&self) -> Again {
        Again {
            kept: self.clone(),
            given: 0,
        }
    }

    /// As [`scene`](Self::scene), where nobody else will look: frames are given away, not copied.
    #[must_use]
    pub fn into_scene(self) -> Box<dyn Scene> {
        let Self { frames, outline } = self;
        match Arc::try_unwrap(frames) {
            Ok(frames) => Box::new(Once {
                left: frames.into_iter(),
                outline,
            }),
            Err(frames) => Box::new(Again {
                kept: Self { frames, outline },
                given: 0,
            }),
        }
    }
}

/// A scene that was kept, given away.
#[derive(Debug)]
struct Once {
    left: std::vec::IntoIter<One>,
    outline: Outline,
}

impl Scene for Once {
    fn outline(&self) -> Outline {
        Outline {
            frames: Some(self.left.len() as u64),
            ..self.outline
        }
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError> {
        Ok(self.left.next().map(|one| Frame {
            index: one.index,
            seconds: one.seconds,
            light: one.pixels.into_image(self.outline.size),
        }))
    }
}

/// A scene that is kept, shown from its beginning.
#[derive(Debug)]
pub struct Again {
    kept: Kept,
    given: usize,
}

impl Scene for Again {
    fn outline(&self) -> Outline {
        self.kept.outline
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError> {
        let Some(light) = self.kept.image(self.given) else {
            return Ok(None);
        };
        let frame = self.kept.frame(self.given);
        self.given += 1;
        Ok(frame.map(|(index, seconds, _)| Frame {
            index,
            seconds,
            light,
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::memory::held::Held;

    #[test]
    fn frames_come_back_as_they_were() {
        let light = [[0.0, 255.0], [0.5, 3.0], [-0.0, 1.0], [256.0, 2.0]];
        let frames: Vec<Frame> = { (0..).zip(light) }
            .map(|(index, [a, b])| Frame {
                index,
                seconds: index as f64 * 0.1,
                light: Plane::from_shape_vec((1, 2), vec![a, b]).unwrap().into(),
            })
            .collect();
        let size = Size::new(1, 2);
        let mut scene = Held::new(frames.clone(), size, 10.0);
        let kept = Kept::new(&mut scene, 1 << 20).unwrap().unwrap();
        assert!(matches!(kept.frame(0), Some((0, _, Pixels::Bytes(_)))));
        assert!(matches!(kept.frame(2), Some((2, _, Pixels::Numbers(_)))));
        let again: Box<dyn Scene> = Box::new(kept.scene());
        let shared: Box<dyn Scene> = kept.clone().into_scene();
        drop(shared);
        for mut scene in [again, kept.into_scene()] {
            for frame in &frames {
                let shown = scene.next_frame().unwrap().unwrap();
                assert_eq!(&shown, frame);
                let bits = |frame: &Frame| frame.light.mapv(f64::to_bits);
                assert_eq!(bits(&shown), bits(frame));
            }
            assert!(scene.next_frame().unwrap().is_none());
        }
        for most in [1, 20] {
            let mut scene = Held::new(frames.clone(), size, 10.0);
            assert!(Kept::new(&mut scene, most).unwrap().is_none());
        }
    }
}
