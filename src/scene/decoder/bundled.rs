//! The clip that comes with the program.

use std::{path::Path, sync::OnceLock};

use super::{animation, canvas::Delay};
use crate::scene::{OpenOptions, Scene, SceneError, check_rate, shown};

/// People walking past a still camera: a crop of `vtest.avi`, which comes with `OpenCV`, as
/// gray 8-bit video of 256x256 at 10 frames/s.
///
/// It is compiled in, so it needs no file and no feature. `clips/README.md` has its source
/// and licence.
///
/// # Errors
/// None in a sound build; the type is that of every other scene.
pub fn bundled() -> Result<Box<dyn Scene>, SceneError> {
    bundled_with(&OpenOptions::default())
}

/// The same with the options that every scene takes.
///
/// # Errors
/// When the options ask for what it is not.
pub fn bundled_with(options: &OpenOptions) -> Result<Box<dyn Scene>, SceneError> {
    static DELAYS: OnceLock<Vec<Delay>> = OnceLock::new();
    const CLIP: &[u8] = include_bytes!("../../../clips/vtest_256x256.apng");
    let name = Path::new("clips/vtest_256x256.apng");
    options.fps.map(check_rate).transpose()?;
    // It is small, and in memory anyway.
    let options = &OpenOptions {
        memory: None,
        ..*options
    };
    let (scene, source) = animation::play_apng(name, CLIP, *options, &DELAYS)?;
    shown(options.view, source.decode(scene, name, options)?)
}
