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
//!
//! - `open`, `options`, `view`, `shown`: a scene by its name, and what of it is shown.
//! - `frame`: a frame, and what all scenes are; `checks`: what all readers check; `error`.
//! - `decoder`: video, animations, pictures, arrays.
//! - `light`: what samples mean, and the light that they become.
//! - `space`, `time`: parts of a scene, larger pixels, other frame rates.
//! - `memory`: scenes that are shown more than once.
//! - [`pattern`]: scenes that are drawn.
//! - `observation`: what was seen of a scene: light, cuts, repeated frames.

mod checks;
mod decoder;
mod error;
mod frame;
mod light;
mod memory;
mod observation;
mod open;
mod options;
pub mod pattern;
mod shown;
mod space;
mod time;
mod view;

pub use self::{
    decoder::bundled::{bundled, bundled_with},
    error::SceneError,
    frame::{Frame, Gap, Outline, Scene},
    light::{
        coding::{Coding, Light, Origin, Range, Samples, Transfer, word_or_auto},
        image::{Coded, Codes, Image, Levels},
    },
    memory::{held, kept},
    observation::{
        aliasing::Alias,
        cut::Cut,
        observed::{Observation, Observed},
        playback::Unlike,
        repeated_frames::Repeated,
        seen_light::SeenLight,
    },
    open::{Reopen, image_of_pattern, open},
    options::OpenOptions,
    shown::shown,
    space::{crop::Crop, cropped::Cropped, resized::Resized},
    time::{
        frame_rate::{ASSUMED_FPS, check_rate},
        part, resample,
        slice::{Moment, Slice},
        sliced::Sliced,
        upsample,
    },
    view::View,
};
