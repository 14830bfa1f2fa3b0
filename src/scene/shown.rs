//! A scene as it is shown.

use super::{
    Scene, SceneError, View,
    space::{cropped::Cropped, resized::Resized},
    time::sliced::Sliced,
};

/// What a view shows of a scene.
///
/// # Errors
/// When the scene has no such part.
pub fn shown<'a>(
    view: View,
    scene: Box<dyn Scene + 'a>,
) -> Result<Box<dyn Scene + 'a>, SceneError> {
    let mut shown = scene;
    if let Some(slice) = view.slice {
        shown = Box::new(Sliced::new(shown, slice));
    }
    if let Some(crop) = view.crop {
        shown = Box::new(Cropped::new(shown, crop)?);
    }
    if let Some(size) = view.resize {
        shown = Box::new(Resized::new(shown, size)?);
    }
    Ok(shown)
}
