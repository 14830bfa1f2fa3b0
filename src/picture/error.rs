//! Why a picture cannot be made.

use crate::{plane::Size, save::SaveError};

/// A picture cannot be made.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum PictureError {
    /// No moment to show.
    #[error("there is no moment to show")]
    #[diagnostic(help("give at least one frame"))]
    Nothing,
    /// Frames and packets of different sizes.
    #[error("the {what} is {got}, the sensor is {want}")]
    #[diagnostic(help("frames and packets of one picture have one size"))]
    Size {
        /// What does not fit.
        what: &'static str,
        /// The size of what does not fit.
        got: Size,
        /// Size of the reference's sensor.
        want: Size,
    },
    /// A sensor without pixels.
    #[error("a sensor of {0} pixels cannot be shown")]
    #[diagnostic(help(
        "the file has no events and does not say how large its sensor is: give one that does"
    ))]
    NoPixels(Size),
    /// Larger than the file can be.
    #[error("the picture would be {0}; a side is at most 65535")]
    #[diagnostic(help("show fewer moments, or a part of the sensor"))]
    TooLarge(Size),
    /// The file cannot be saved.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Save(#[from] SaveError),
}

/// Checks that a sensor has pixels, and not more than a picture can hold.
///
/// # Errors
/// When it has none, or a side beyond 65535.
pub(super) fn check_size(size: Size) -> Result<(), PictureError> {
    let most = usize::from(u16::MAX);
    if size.height.max(size.width) > most {
        return Err(PictureError::TooLarge(size));
    }
    if size.height.min(size.width) == 0 {
        return Err(PictureError::NoPixels(size));
    }
    Ok(())
}
