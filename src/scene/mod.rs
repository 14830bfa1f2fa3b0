//! Light over time: one frame after another, pushed one way.
//!
//! A [`Scene`] is read once, frame by frame, so memory does not grow with a clip's length.
//! Frame `n` of a source is at `n / fps` seconds, computed from `n` (never accumulated), so
//! time does not drift. [`upsample::Upsampled`] puts frames between those of a source.
//!
//! | [`open()`] takes | what it is | frames per second |
//! |---|---|---|
//! | `clip.y4m` | raw video, 8 to 16 bits, its luma | from its header |
//! | `clip.mp4` | H.264 video, its luma (feature `mp4`) | from its time table |
//! | `clip.gif` `clip.apng` | an animation | from its delays |
//! | `folder/` | PNG and PGM pictures in natural order | assumed: [`ASSUMED_FPS`] |
//! | `still.png` `still.pgm` | one frame | assumed |
//! | `light.npy` | numbers `(T, H, W)`, used as given | assumed |
//! | `pattern:NAME?key=value` | drawn, with exact optical flow | a parameter |
//!
//! Video is used as it is coded: 0 to 255, no gamma undone, limited range not stretched, as
//! the authors of the RGC sensor feed their simulator. Colour becomes gray by Rec. 601
//! (0.299 R + 0.587 G + 0.114 B, the weights of video luma and of `OpenCV`), not rounded.

mod animation;
mod bundled;
mod canvas;
mod error;
mod folder;
mod gray;
mod light;
mod mp4;
mod npy;
mod open;
mod rate;
mod still;
mod y4m;

pub mod part;
pub mod pattern;
pub mod upsample;

pub use bundled::bundled;
pub use error::SceneError;
pub use open::{OpenOptions, open};
pub use rate::ASSUMED_FPS;

use crate::plane::{Plane, Size};

/// One picture of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Number of the frame, from 0.
    pub index: u64,
    /// When it was taken, in seconds.
    pub seconds: f64,
    /// Linear light, `[y, x]`: 0 to 255 for 8-bit video, as given for `.npy`.
    pub light: Plane<f64>,
}

/// A source of frames, all of one size.
pub trait Scene: Send {
    /// Size of every frame.
    fn size(&self) -> Size;

    /// Frames of the source per second.
    fn fps(&self) -> f64;

    /// Whether [`fps`](Self::fps) is [`ASSUMED_FPS`], because neither the source nor the
    /// caller said one. Whoever shows results should then say so.
    fn fps_is_assumed(&self) -> bool {
        false
    }

    /// How many frames there are, where that is known beforehand.
    fn frames(&self) -> Option<u64>;

    /// The next frame; `None` at the end.
    ///
    /// # Errors
    /// When the source cannot be read, or a frame is damaged, of another size, or not finite.
    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError>;

    /// Bytes that the source holds at most while frames are taken from it, the frame that it
    /// gives included.
    fn bytes(&self) -> u128 {
        light::GIVEN * self.size().pixels() as u128
    }
}

impl<S: Scene + ?Sized> Scene for Box<S> {
    fn size(&self) -> Size {
        (**self).size()
    }
    fn fps(&self) -> f64 {
        (**self).fps()
    }
    fn fps_is_assumed(&self) -> bool {
        (**self).fps_is_assumed()
    }
    fn frames(&self) -> Option<u64> {
        (**self).frames()
    }
    fn next_frame(&mut self) -> Result<Option<Frame>, SceneError> {
        (**self).next_frame()
    }
    fn bytes(&self) -> u128 {
        (**self).bytes()
    }
}
