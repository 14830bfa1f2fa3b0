//! Light over time: one frame after another, pushed one way.
//!
//! A [`Scene`] is read once, frame by frame, so memory does not grow with a clip's length.
//! Frame `n` of a source is at `n / fps` seconds, computed from `n` (never accumulated), so
//! time does not drift. [`upsample::Upsampled`] puts frames between those of a source where light
//! changes fast, [`resample::Resampled`] evenly.
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
//! Light is 0 to 255. Video of limited range is stretched to it, in the range that the file
//! states (`XCOLORRANGE` of y4m, `colr` and VUI of mp4) or that its kind usually has: limited for
//! video with colour, full for gray y4m, pictures and arrays. What lies outside is clipped. The
//! transfer is as coded, as in v2e, ESIM and the simulator of the RGC sensor's authors, unless
//! [`Coding`] asks for one to be undone. [`View`] shows a slice, a part of each picture, or larger
//! pixels. Colour becomes gray by Rec. 601 (0.299 R + 0.587 G +
//! 0.114 B, the weights of video luma and of `OpenCV`), not rounded.

mod alias;
mod animation;
mod bundled;
mod canvas;
mod chunks;
mod coding;
mod crop;
mod cropped;
mod cut;
mod decoded;
mod error;
mod folder;
mod frame;
mod gray;
mod image;
mod light;
mod mp4;
mod npy;
mod observed;
mod open;
mod options;
mod pgm;
mod rate;
mod repeats;
mod resized;
mod shown;
mod slice;
mod sliced;
mod spacing;
mod still;
mod unlike;
mod view;
mod y4m;

pub mod held;
pub mod kept;
pub mod part;
pub mod pattern;
pub mod resample;
pub mod upsample;

pub use alias::Alias;
pub use bundled::{bundled, bundled_with};
pub use coding::{Coding, Light, Origin, Range, Samples, Transfer, word_or_auto};
pub use crop::Crop;
pub use cropped::Cropped;
pub use cut::Cut;
pub use error::SceneError;
pub use frame::{Frame, Gap, Outline, Scene};
pub use image::{Coded, Codes, Image, Levels};
pub use observed::{Observation, Observed};
pub use open::{Reopen, image_of_pattern, open};
pub use options::OpenOptions;
pub use rate::{ASSUMED_FPS, check_rate};
pub use repeats::Repeated;
pub use resized::Resized;
pub use shown::shown;
pub use slice::{Moment, Slice};
pub use sliced::Sliced;
pub use unlike::Unlike;
pub use view::View;
