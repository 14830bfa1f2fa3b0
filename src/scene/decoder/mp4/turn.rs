//! How a player turns the pictures of a track: phones film as they are held, and write down how.

use super::boxes::u32_at;
use crate::{
    plane::Size,
    scene::{
        error::SceneError,
        frame::{Frame, Outline, Scene},
        light::image::{Codes, Image},
        observation::playback::Unlike,
    },
};

/// By quarters of a turn, and mirrored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Turn {
    /// Rows become columns first.
    transposed: bool,
    /// Then left becomes right,
    mirrored: bool,
    /// and top becomes bottom.
    flipped: bool,
}

impl Turn {
    /// Whether that matrix turns by an angle that is no quarter of a turn, or shears.
    pub fn is_other(tkhd: &[u8]) -> bool {
        let [a, b, c, d] = matrix(tkhd);
        (a != 0 || d != 0) && (b != 0 || c != 0)
    }

    /// From the matrix of `tkhd` (ISO/IEC 14496-12, 8.3.2 and 6.2.2): x to the right is shown at
    /// (a, b), y down at (c, d). What is no quarter of a turn is left as it is.
    pub fn from_tkhd(tkhd: &[u8]) -> Self {
        let [a, b, c, d] = matrix(tkhd);
        if a == 0 && d == 0 && b != 0 && c != 0 {
            Self {
                transposed: true,
                mirrored: c < 0,
                flipped: b < 0,
            }
        } else if b == 0 && c == 0 {
            Self {
                transposed: false,
                mirrored: a < 0,
                flipped: d < 0,
            }
        } else {
            Self::default()
        }
    }

    const fn size(self, size: Size) -> Size {
        if self.transposed {
            Size::new(size.width, size.height)
        } else {
            size
        }
    }

    fn image(self, image: Image) -> Image {
        let Some(coded) = image.coded() else {
            return image;
        };
        let (from, levels) = (coded.size(), coded.levels().clone());
        let size = self.size(from);
        let turned = match coded.codes() {
            Codes::Bytes(codes) => Image::of_bytes(size, self.codes(codes, from), levels),
            Codes::Words(codes) => Image::of_words(size, self.codes(codes, from), levels),
        };
        turned.unwrap_or(image)
    }

    fn codes<T: Copy>(self, codes: &[T], from: Size) -> Vec<T> {
        let size = self.size(from);
        let places = (0..size.height).flat_map(|y| (0..size.width).map(move |x| (y, x)));
        let source = |(y, x): (usize, usize)| {
            let y = if self.flipped { size.height - 1 - y } else { y };
            let x = if self.mirrored { size.width - 1 - x } else { x };
            let (y, x) = if self.transposed { (x, y) } else { (y, x) };
            codes[y * from.width + x]
        };
        places.map(source).collect()
    }
}

/// The four entries of the matrix that turn.
fn matrix(tkhd: &[u8]) -> [i32; 4] {
    let matrix = if tkhd.first() == Some(&1) { 52 } else { 40 };
    let entry = |n: usize| u32_at(tkhd, matrix + 4 * n).map_or(0, |entry| entry as i32);
    [entry(0), entry(1), entry(3), entry(4)]
}

/// A scene whose pictures are turned.
pub(super) struct Turned<S> {
    source: S,
    turn: Turn,
}

impl<S: Scene + 'static> Turned<S> {
    /// The scene itself where nothing is turned.
    pub fn scene(source: S, turn: Turn) -> Box<dyn Scene> {
        if turn == Turn::default() {
            Box::new(source)
        } else {
            Box::new(Self { source, turn })
        }
    }
}

impl<S: Scene> Scene for Turned<S> {
    fn outline(&self) -> Outline {
        let source = self.source.outline();
        Outline {
            size: self.turn.size(source.size),
            unlike: source.unlike.map(|unlike| match unlike {
                Unlike::Pixels { width, height } if self.turn.transposed => Unlike::Pixels {
                    width: height,
                    height: width,
                },
                other => other,
            }),
            // The picture before and after.
            bytes: source.bytes + source.size.pixels() as u128,
            ..source
        }
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError> {
        let frame = self.source.next_frame()?;
        Ok(frame.map(|frame| Frame {
            light: self.turn.image(frame.light),
            ..frame
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::light::image::Levels;

    /// What players show of 3 columns and 2 rows, 1 to 6.
    #[test]
    fn quarters_of_a_turn_are_those_of_players() {
        for (matrix, width, shown) in [
            ([1, 0, 0, 1], 3, [1, 2, 3, 4, 5, 6]),
            ([0, 1, -1, 0], 2, [4, 1, 5, 2, 6, 3]),
            ([-1, 0, 0, -1], 3, [6, 5, 4, 3, 2, 1]),
            ([0, -1, 1, 0], 2, [3, 6, 2, 5, 1, 4]),
            ([-1, 0, 0, 1], 3, [3, 2, 1, 6, 5, 4]),
            ([1, 1, 0, 1], 3, [1, 2, 3, 4, 5, 6]),
            ([0, 0, 0, 0], 3, [1, 2, 3, 4, 5, 6]),
        ] {
            for (version, at) in [(0, 40), (1, 52)] {
                let mut tkhd = vec![0; at + 36];
                tkhd[0] = version;
                for (entry, place) in matrix.into_iter().zip([0, 4, 12, 16]) {
                    let entry = (entry * 65_536_i32).to_be_bytes();
                    tkhd[at + place..][..4].copy_from_slice(&entry);
                }
                let is_other = matrix == [1, 1, 0, 1];
                assert_eq!(Turn::is_other(&tkhd), is_other, "{matrix:?}");
                let codes = (1..=6).collect();
                let image = Image::of_bytes(Size::new(2, 3), codes, Levels::bytes()).unwrap();
                let turned = Turn::from_tkhd(&tkhd).image(image);
                assert_eq!(turned.size(), Size::new(6 / width, width), "{matrix:?}");
                let light: Vec<_> = turned.iter().map(|light| *light as i32).collect();
                assert_eq!(light, shown, "{matrix:?}");
            }
        }
    }
}
