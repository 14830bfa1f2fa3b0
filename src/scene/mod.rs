//! Light over time: one frame after another, pushed one way.
//!
//! A [`Scene`] is read once, frame by frame, so memory does not grow with a clip's length.
//! Frame `n` of a source is at `n / fps` seconds, computed from `n` (never accumulated), so
//! time does not drift. [`upsample::Upsampled`] puts frames between those of a source where light
//! changes fast, [`evenly::Evenly`] everywhere.
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
mod frame;
mod gray;
mod light;
mod mp4;
mod npy;
mod open;
mod options;
mod rate;
mod still;
mod y4m;

pub mod evenly;
pub mod part;
pub mod pattern;
pub mod upsample;

pub use bundled::bundled;
pub use error::SceneError;
pub use frame::{Frame, Scene};
pub use open::open;
pub use options::OpenOptions;
pub use rate::ASSUMED_FPS;
